//! Readers of data files. What was read is written in the same format, and must be read back the same.

use std::io::Cursor;

use orograph_core::{CellSize, Grid};
use orograph_nodes::io::{
    ascii, exr, geotiff, hgt,
    raw::{self, RawFormat, RawLayout},
    read_dem, read_mask, read_png, read_points, read_texture,
};

use super::{heights, is_told, job, same};

/// A GeoTIFF.
pub(super) fn geotiff(bytes: &[u8]) {
    let Some(terrain) = heights(geotiff::read(bytes, "x.tif", &job())) else { return };
    let mut out = Cursor::new(Vec::new());
    match geotiff::write(&terrain, &geotiff::Options::default(), &mut out, "x.tif", &job()) {
        Ok(()) => {
            let back = geotiff::read(out.get_ref(), "x.tif", &job());
            assert!(same(&back.expect("what was written is read"), &terrain));
        }
        Err(error) => is_told(&error),
    }
}

/// An SRTM tile: a line with its name, then its bytes; after `tile` as many more of them as a tile has.
pub(super) fn hgt(bytes: &[u8]) {
    let mut parts = bytes.splitn(2, |&byte| byte == b'\n');
    let name = String::from_utf8_lossy(parts.next().unwrap_or_default()).into_owned();
    let content = parts.next().unwrap_or_default();
    if let Some((latitude, longitude)) = hgt::corner(&name) {
        assert_eq!(hgt::corner(&hgt::tile_name(latitude, longitude)), Some((latitude, longitude)));
    }
    for (_, names) in hgt::neighbours(&name) {
        assert!(names.iter().all(|name| hgt::corner(name).is_some()), "{names:?}");
    }
    let content = match content.strip_prefix(b"tile") {
        Some(some) if !some.is_empty() => some.iter().copied().cycle().take(1201 * 1201 * 2).collect(),
        _ => content.to_vec(),
    };
    let Some(terrain) = heights(hgt::read(&content, &name, &job())) else { return };
    assert_eq!(hgt::write(&terrain, &job()).expect("a tile is a tile"), content);
}

/// A zip of an elevation model.
pub(super) fn zip(bytes: &[u8]) {
    heights(read_dem::read(bytes, "x.zip", &job()));
}

/// An ASCII grid.
pub(super) fn ascii(bytes: &[u8]) {
    let Some(terrain) = heights(ascii::read(bytes, "x.asc", &job())) else { return };
    let mut out = Vec::new();
    match ascii::write(&terrain, &mut out, "x.asc", &job()) {
        Ok(()) => {
            let back = ascii::read(&out, "x.asc", &job());
            assert!(same(&back.expect("what was written is read"), &terrain));
        }
        Err(error) => is_told(&error),
    }
}

/// A PNG picture as heights, as a mask and as colours.
pub(super) fn png(bytes: &[u8]) {
    let cell = CellSize::square(1.0);
    heights(read_png::read(bytes, "x.png", (0.0, 1000.0), cell, &job()));
    match read_mask::read(bytes, "x.png", cell, &job()) {
        Ok(mask) => assert!(mask.cells().iter().all(|share| (0.0..=1.0).contains(share))),
        Err(error) => is_told(&error),
    }
    if let Err(error) = read_texture::read(bytes, "x.png", cell, &job()) {
        is_told(&error);
    }
}

/// Headerless heights: a byte for the format, one for the order of rows, two each for rows and columns, the bytes.
pub(super) fn raw(bytes: &[u8]) {
    let Some(([format, order, rows @ .., c0, c1], content)) = bytes.split_first_chunk::<6>() else { return };
    let format = [RawFormat::R16Little, RawFormat::R16Big, RawFormat::R32][usize::from(*format) % 3];
    let side = |pair: [u8; 2]| usize::from(u16::from_le_bytes(pair));
    let size = raw::size(content.len(), format, side(*rows), side([*c0, *c1]), "x.raw");
    let grid = size.and_then(|(rows, cols)| Grid::new(rows, cols, CellSize::square(1.0)));
    let grid = match grid {
        Ok(grid) => grid,
        Err(error) => return is_told(&error),
    };
    let layout = RawLayout { format, range: (0.0, 65535.0), south_first: order % 2 == 1 };
    let Some(terrain) = heights(raw::read(content, "x.raw", grid, &layout, &job())) else { return };
    let back = raw::write(&terrain, &layout, &job()).expect("it was small enough to read");
    // NaN may change its bits.
    assert!(back == content || format == RawFormat::R32);
}

/// An OpenEXR picture.
pub(super) fn exr(bytes: &[u8]) {
    let cell = CellSize::square(1.0);
    let Some(terrain) = heights(exr::read(bytes, "x.exr", cell, &job())) else { return };
    let mut out = Cursor::new(Vec::new());
    exr::write(&terrain, &mut out, "x.exr", &job()).expect("it was small enough to read");
    let back = exr::read(out.get_ref(), "x.exr", cell, &job());
    assert!(same(&back.expect("what was written is read"), &terrain));
}

/// Points as a table.
pub(super) fn points(bytes: &[u8]) {
    match read_points::read(bytes, "x.csv", &job()) {
        Ok(points) => {
            let finite =
                |(x, y, height): (f64, f64, f64)| x.is_finite() && y.is_finite() && height.is_finite();
            assert!(points.iter().all(finite));
        }
        Err(error) => is_told(&error),
    }
}
