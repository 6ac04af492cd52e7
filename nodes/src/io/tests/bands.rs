//! A GeoTIFF read and written some rows at a time is the one read and written at once.

use super::{super::geotiff::GeotiffSource, *};

#[test]
fn geotiff_in_bands_is_geotiff_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let (path, job) = (folder.path().join("x.tif"), Job::detached());
    for (rows, cols) in [(1, 1), (257, 300), (700, 513)] {
        let terrain = sample(rows, cols);
        for options in every_option() {
            let bytes = geotiff_of(&terrain, &options).unwrap();
            fs::write(&path, &bytes).unwrap();
            let whole = geotiff::read(&bytes, "x.tif", &job).unwrap();
            for step in [100, 256] {
                let mut out = Cursor::new(Vec::new());
                let mut writer = geotiff::heights(terrain.grid(), &options, &mut out, "x.tif").unwrap();
                let file = fs::File::open(&path).unwrap();
                let source = GeotiffSource::open(file, "x.tif", "x.tif", &job).unwrap().unwrap();
                assert_eq!(source.grid(), whole.grid());
                for first in (0..rows).step_by(step) {
                    let part = step.min(rows - first);
                    let expected = whole.crop(first, 0, part, cols, &job).unwrap();
                    let Value::Heightfield(found) = source.band(first, part, &job).unwrap() else { panic!() };
                    assert_eq!((bits(&found), found.grid()), (bits(&expected), expected.grid()));
                    writer.take(&terrain.cells()[first * cols..(first + part) * cols], &job).unwrap();
                }
                writer.finish(&job).unwrap();
                assert_eq!(out.into_inner(), bytes, "{rows} × {cols} by {step}, {options:?}");
            }
        }
    }
}

#[test]
fn a_broken_geotiff_is_told_in_bands_too() {
    let folder = tempfile::tempdir().unwrap();
    let (path, job) = (folder.path().join("x.tif"), Job::detached());
    // The writer would refuse such a height.
    let options = Options { layout: Layout::Strips, compression: Compression::None, ..Options::default() };
    let mut bytes = geotiff_of(&sample(600, 7), &options).unwrap();
    let height = sample(600, 7).at(500, 3).to_le_bytes();
    let at = bytes.windows(4).enumerate().filter(|(_, part)| *part == height).map(|(at, _)| at);
    let at = at.min_by_key(|at| at.abs_diff(8 + (500 * 7 + 3) * 4)).unwrap();
    bytes[at..at + 4].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    let open = || GeotiffSource::open(fs::File::open(&path).unwrap(), "x.tif", "x.tif", &job);
    let failed = open().unwrap().unwrap().band(400, 150, &job).unwrap_err();
    assert_eq!(failed, Error::NonFinite { what: "x.tif".into(), row: 500, col: 3 });
    // Cut short, its header, which stands last, is not there.
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(matches!(open(), Err(Error::Format { .. })));
}
