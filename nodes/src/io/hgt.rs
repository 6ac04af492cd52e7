//! SRTM tiles: big-endian 16-bit heights, 1201 or 3601 a side, the south-west corner in the file's name.
//!
//! The first sample's centre lies on the corner of the degree, so a tile shares its edge rows and columns with
//! its neighbours and its cells reach half a cell beyond the degree.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    ground::{MapUnit, cell_size},
    whole::nearest,
};

/// Sides of the two kinds of tile, in samples.
const SIDES: [usize; 2] = [1201, 3601];
/// What a tile holds where nothing was measured.
const VOID: i16 = i16::MIN;

/// Latitude and longitude of the south-west corner that a name such as `N44W072.hgt` gives.
#[must_use]
pub fn corner(name: &str) -> Option<(i32, i32)> {
    let stem = name.rsplit(['/', '\\']).next()?;
    let number = |range: std::ops::Range<usize>| {
        let digits = stem.get(range)?;
        digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse::<i32>().ok()).flatten()
    };
    let sign = |at: usize, plus: u8, minus: u8| match stem.as_bytes().get(at)?.to_ascii_uppercase() {
        letter if letter == plus => Some(1),
        letter if letter == minus => Some(-1),
        _ => None,
    };
    let latitude = sign(0, b'N', b'S')? * number(1..3)?;
    let longitude = sign(3, b'E', b'W')? * number(4..7)?;
    ((-90..90).contains(&latitude) && (-180..180).contains(&longitude)).then_some((latitude, longitude))
}

/// The name of the tile at that south-west corner.
#[must_use]
pub fn tile_name(latitude: i32, longitude: i32) -> String {
    let (ns, ew) = (if latitude < 0 { 'S' } else { 'N' }, if longitude < 0 { 'W' } else { 'E' });
    format!("{ns}{:02}{ew}{:03}.hgt", latitude.abs(), longitude.abs())
}

/// The tiles around the one that a file is named after: for each, its steps north and east, and the names that its file may
/// have beside that file, likeliest first. None for a name that gives no corner, none beyond the poles.
#[must_use]
pub fn neighbours(file: &str) -> Vec<([i32; 2], Vec<String>)> {
    let (Some((latitude, longitude)), Some(stem), Some(ending)) =
        (corner(file), file.get(..7), file.get(7..))
    else {
        return Vec::new();
    };
    let is_small = stem.bytes().any(|byte| byte.is_ascii_lowercase());
    let mut all = Vec::with_capacity(8);
    for (north, east) in [(1, -1), (1, 0), (1, 1), (0, -1), (0, 1), (-1, -1), (-1, 0), (-1, 1)] {
        let latitude = latitude + north;
        if !(-90..90).contains(&latitude) {
            continue;
        }
        let name = tile_name(latitude, (longitude + east + 180).rem_euclid(360) - 180);
        let stem = &name[..7];
        let stem = if is_small { stem.to_ascii_lowercase() } else { stem.to_owned() };
        let mut names: Vec<String> = Vec::new();
        for ending in [ending, ".hgt", ".hgt.zip"] {
            let name = format!("{stem}{ending}");
            if !names.contains(&name) {
                names.push(name);
            }
        }
        all.push(([north, east], names));
    }
    all
}

/// The heights in a tile; `name` gives its place and names it in errors. -32768 becomes a void.
///
/// # Errors
/// [`Error::Format`] when the length is no tile's, [`Error::Invalid`] when the name gives no corner.
pub fn read(bytes: &[u8], name: &str, job: &Job) -> Result<Heightfield> {
    let side = SIDES.into_iter().find(|side| side * side * 2 == bytes.len()).ok_or_else(|| {
        let reason = format!(
            "{} bytes are no SRTM tile: one of 1201 samples a side has 2884802, one of 3601 has 25934402",
            bytes.len()
        );
        Error::format(name, reason)
    })?;
    let (latitude, longitude) = corner(name).ok_or_else(|| {
        Error::invalid(
            format!("`{name}` does not say where the tile lies"),
            "name the file after its south-west corner, such as `N44W072.hgt`",
        )
    })?;
    let step = 1.0 / (side - 1) as f64;
    let (west, north) = (f64::from(longitude) - step / 2.0, f64::from(latitude + 1) + step / 2.0);
    let transform = [west, step, 0.0, north, 0.0, -step];
    let mut grid = Grid::new(side, side, cell_size(&transform, (side, side), MapUnit::Degrees(1.0), name)?)?;
    grid.georef = Some(Georef { transform, crs: "EPSG:4326".into() }.into());
    // Through pieces of many rows rather than `build`, which costs a second pass over memory.
    job.admit(bytes.len() as u64 * 2, || name.into())?;
    job.check()?;
    let height = |pair: &[u8; 2]| match i16::from_be_bytes(*pair) {
        VOID => f32::NAN,
        known => f32::from(known),
    };
    let cells = bytes.as_chunks::<2>().0.par_iter().with_min_len(1 << 16).map(height).collect();
    job.progress(1.0);
    Heightfield::new(grid, cells)
}

/// What a tile holds for a height, and whether that says just this height and nothing else.
fn sample(height: f32) -> (i16, bool) {
    let (whole, fits) = nearest(height, i32::from(VOID) + 1, i32::from(i16::MAX));
    let is_void = height.is_nan();
    (if is_void { VOID } else { whole as i16 }, is_void | fits)
}

/// A tile's bytes. Heights are rounded to whole metres, halves away from zero.
///
/// # Errors
/// [`Error::Invalid`] unless the terrain is 1201 or 3601 cells a side and its heights fit 16 bits.
pub fn write(terrain: &Heightfield, job: &Job) -> Result<Vec<u8>> {
    let (rows, cols) = terrain.grid().size();
    if rows != cols || !SIDES.contains(&rows) {
        return Err(Error::invalid(
            format!("an SRTM tile has 1201 × 1201 or 3601 × 3601 samples, not {rows} × {cols}"),
            "resize the terrain to 1201 or 3601 cells a side, or write a GeoTIFF",
        ));
    }
    job.admit(terrain.cells().len() as u64 * 2, || "the tile".into())?;
    let mut bytes = vec![0; terrain.cells().len() * 2];
    bytes.par_chunks_mut(cols * 2).enumerate().try_for_each(|(row, out)| {
        job.check()?;
        let heights = terrain.row(row);
        // All cells before any is judged: a way out of the loop would keep it from taking many at once.
        let mut fits = true;
        for (out, &height) in out.as_chunks_mut::<2>().0.iter_mut().zip(heights) {
            let (stored, is_its_own) = sample(height);
            *out = stored.to_be_bytes();
            fits &= is_its_own;
        }
        let stray = if fits { None } else { heights.iter().position(|&height| !sample(height).1) };
        stray.map_or(Ok(()), |col| {
            let height = heights[col];
            Err(Error::invalid(
                format!("height {height} m at row {row}, column {col} does not fit an SRTM tile"),
                "clamp the heights to -32767 to 32767 m first",
            ))
        })
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_corners_and_corners_names() {
        for (name, place) in
            [("N44W072.hgt", (44, -72)), ("s45e169.HGT", (-45, 169)), ("dir/N00E000", (0, 0))]
        {
            assert_eq!(corner(name), Some(place), "{name}");
        }
        for name in ["", "N4", "X44W072.hgt", "N4aW072.hgt", "N44W999.hgt", "N9öW072", "N-1E+01.hgt"] {
            assert_eq!(corner(name), None, "{name}");
        }
        assert_eq!(tile_name(-5, 7), "S05E007.hgt");
    }

    #[test]
    fn neighbours_lie_around_and_are_named_alike() {
        let names = |file: &str| -> Vec<String> {
            neighbours(file).into_iter().map(|(_, names)| names[0].clone()).collect()
        };
        assert_eq!(
            names("N46E008.hgt.zip"),
            ["N47E007", "N47E008", "N47E009", "N46E007", "N46E009", "N45E007", "N45E008", "N45E009"]
                .map(|stem| format!("{stem}.hgt.zip"))
        );
        // Across the equator and Greenwich, across the date line, at a pole, and in small letters.
        assert_eq!(names("n00e000.HGT")[5..], ["s01w001.HGT", "s01e000.HGT", "s01e001.HGT"]);
        assert_eq!(names("S01W001.hgt")[..3], ["N00W002.hgt", "N00W001.hgt", "N00E000.hgt"]);
        assert_eq!(names("N10E179.hgt")[4], "N10W180.hgt");
        assert_eq!(names("N10W180.hgt")[3], "N10E179.hgt");
        assert_eq!(names("S90E010.hgt").len(), 5);
        assert_eq!(names("N89E010.hgt").len(), 5);
        assert_eq!(neighbours("N46E008.hgt")[0].1, ["N47E007.hgt", "N47E007.hgt.zip"]);
        assert_eq!(neighbours("N46E008_v3.tif")[0].1, ["N47E007_v3.tif", "N47E007.hgt", "N47E007.hgt.zip"]);
        for file in ["", "tile.hgt", "N46E0", "N46E00ö.hgt"] {
            assert!(neighbours(file).is_empty(), "{file}");
        }
    }

    #[test]
    fn a_tile_has_its_first_sample_on_the_degree_lines_and_round_trips() {
        let mut bytes = vec![0; 1201 * 1201 * 2];
        bytes[..6].copy_from_slice(&[0x80, 0x00, 0x7f, 0xff, 0xff, 0xff]);
        let terrain = read(&bytes, "N44W072.hgt", &Job::detached()).unwrap();
        assert!(terrain.at(0, 0).is_nan());
        assert_eq!(terrain.row(0)[1..3], [32767.0, -1.0]);
        let georef = terrain.grid().georef_here().unwrap();
        let centre = |origin: f64, step: f64| origin + step / 2.0;
        assert!((centre(georef.transform[0], georef.transform[1]) + 72.0).abs() < 1e-12);
        assert!((centre(georef.transform[3], georef.transform[5]) - 45.0).abs() < 1e-12);
        assert_eq!(write(&terrain, &Job::detached()).unwrap(), bytes);
    }

    #[test]
    fn other_lengths_and_nameless_tiles_are_refused() {
        let job = Job::detached();
        assert!(matches!(read(&[0; 100], "N44W072.hgt", &job), Err(Error::Format { .. })));
        assert!(matches!(read(&vec![0; 2_884_802], "tile.hgt", &job), Err(Error::Invalid { .. })));
        assert!(write(&crate::test_fields::field(3, 3, |_, _| 0.0), &job).is_err());
    }
}
