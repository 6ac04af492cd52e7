//! GeoTIFFs that other software wrote, in every layout that is about: `data/gdal_*.tif` by GDAL 3.10,
//! `data/tifffile_*.tif` by tifffile, the rest put together by hand and read by GDAL as stated here. All of them show
//! the same invented terrain, see [`height`].

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

use std::{path::Path, sync::Mutex};

use orograph_core::prelude::*;
use orograph_core::{Context, Host, OutputStream};
use orograph_nodes::io::read_dem::ReadDem;

/// Length of the US survey foot, in metres.
const SURVEY_FOOT: f64 = 1200.0 / 3937.0;

/// Finds files and hears remarks.
#[derive(Default)]
struct Reader(Mutex<Vec<String>>);

impl Host for Reader {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, message: &str) {
        self.0.lock().unwrap().push(message.into());
    }
    fn memory_limit(&self) -> u64 {
        1 << 30
    }
    fn input_path(&self, path: &str) -> Result<std::path::PathBuf> {
        Ok(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(path))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::reading(path, "nothing is written here"))
    }
}

fn open(name: &str) -> Result<(Heightfield, Vec<String>)> {
    let host = Reader::default();
    let node = ReadDem { file: InputPath(format!("{name}.tif")), ..ReadDem::default() };
    let terrain = node.run((), &Job::new(&host, Context::default()))?.terrain;
    Ok((terrain, host.0.into_inner().unwrap()))
}

/// Height in whole metres at a cell of every sample but the old-style LZW's.
fn height(row: usize, col: usize) -> f64 {
    (100 + (7 * row + 13 * col) % 50 + 3 * row) as f64
}

/// Compares a sample with `expected` cell by cell; NaN stands for a void.
fn holds(name: &str, expected: impl Fn(usize, usize) -> f64) -> (Heightfield, Vec<String>) {
    let (terrain, remarks) = open(name).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (rows, cols) = terrain.grid().size();
    for row in 0..rows {
        for col in 0..cols {
            let (found, stated) = (f64::from(terrain.at(row, col)), expected(row, col));
            assert!(
                found == stated || (found.is_nan() && stated.is_nan()),
                "{name}: {found} at row {row}, column {col}, not {stated}"
            );
        }
    }
    (terrain, remarks)
}

/// What a cell's height is when the one at (3, 5) is unknown.
fn with_void(row: usize, col: usize, otherwise: f64) -> f64 {
    if (row, col) == (3, 5) { f64::NAN } else { otherwise }
}

#[test]
fn samples_of_every_type_layout_and_byte_order_hold_their_heights() {
    let whole: &[&str] = &[
        "gdal_uint16_tiled_lzw",
        "gdal_uint8",
        "gdal_planar_separate",
        "gdal_pixel_interleaved",
        "gdal_bigtiff",
        "gdal_rotated",
    ];
    let quarters: &[&str] = &[
        "gdal_float32_tiled_predictor3",
        "gdal_float32_big_endian_predictor3",
        "gdal_float64_big_endian",
        "gdal_bigtiff_big_endian",
        "tifffile_big_endian_planar",
    ];
    for name in whole {
        holds(name, height);
    }
    for name in quarters {
        holds(name, |row, col| height(row, col) + 0.25);
    }
    for name in ["gdal_int32_lzw_predictor2", "gdal_int32_big_endian_predictor2"] {
        holds(name, |row, col| height(row, col) * 1000.0);
    }
    for name in ["gdal_packbits", "gdal_packbits_tiled_big_endian"] {
        holds(name, |row, col| height(row, col).min(140.0));
    }
    holds("gdal_int8", |row, col| height(row, col) - 140.0);
    holds("old_style_lzw", |row, col| ((7 * row + 13 * col) % 50 + 31 * row + col * col) as f64);
}

#[test]
fn nodata_values_of_every_type_are_voids() {
    holds("gdal_int16_big_endian_lzw_predictor2", |row, col| with_void(row, col, height(row, col)));
    for name in ["gdal_float64_deflate_predictor3", "gdal_nodata_nan"] {
        holds(name, |row, col| with_void(row, col, height(row, col) + 0.25));
    }
    let (sparse, _) = open("gdal_sparse").unwrap();
    assert_eq!(sparse.void_count(), sparse.grid().len());
}

#[test]
fn samples_lie_where_gdal_put_them() {
    let utm = [500_000.0, 30.0, 0.0, 4_600_000.0, 0.0, -30.0];
    // Metres of a degree at the samples' centre, 45.994°: Snyder, Map Projections, equations 4-18 and 4-20.
    let degree = (77_470.0, 111_151.0);
    let square = CellSize::square;
    for (name, crs, transform, cell) in [
        ("gdal_bigtiff", "EPSG:32633", utm, square(30.0)),
        ("gdal_pixel_is_point", "EPSG:32633", utm, square(30.0)),
        ("gdal_rotated", "EPSG:32633", [500_000.0, 24.0, 18.0, 4_600_000.0, 18.0, -24.0], square(30.0)),
        (
            "gdal_geographic",
            "EPSG:4326",
            [7.0, 0.001, 0.0, 46.0, 0.0, -0.001],
            CellSize { x: degree.0 / 1000.0, y: degree.1 / 1000.0 },
        ),
        ("gdal_us_feet", "EPSG:2225", [6e6, 100.0, 0.0, 2e6, 0.0, -100.0], square(100.0 * SURVEY_FOOT)),
        (
            "feet_by_number_alone",
            "EPSG:2225",
            [6e6, 100.0, 0.0, 2e6, 0.0, -100.0],
            square(100.0 * SURVEY_FOOT),
        ),
        ("gdal_international_feet", "EPSG:2223", [6e5, 100.0, 0.0, 2e5, 0.0, -100.0], square(30.48)),
        // At the samples' centre, y = 4,999,400 m, the latitude is 40.9137°.
        ("gdal_web_mercator", "EPSG:3857", [6e5, 100.0, 0.0, 5e6, 0.0, -100.0], square(75.57)),
    ] {
        let (terrain, remarks) = holds(name, height);
        let grid = terrain.grid();
        assert_eq!(grid.size(), (12, 17), "{name}");
        let georef = grid.georef_here().unwrap();
        assert_eq!((georef.crs.as_str(), georef.transform), (crs, transform), "{name}");
        let near = |found: f64, stated: f64| (found / stated - 1.0).abs() < 2e-4;
        assert!(near(grid.cell.x, cell.x) && near(grid.cell.y, cell.y), "{name}: {:?}", grid.cell);
        assert_eq!(remarks, [""; 0], "{name}");
    }
    let (terrain, _) = holds("gdal_own_projection_in_feet", height);
    assert!((terrain.grid().cell.x / (100.0 * SURVEY_FOOT) - 1.0).abs() < 1e-9);
    // GDAL finds the names in a citation by the bars between them.
    let crs = &terrain.grid().georef.as_ref().unwrap().crs;
    assert!(crs.contains("|2049:tGCS Name = unknown%7CPrimem = Greenwich%7C|"), "{crs}");
}

#[test]
fn further_bands_are_told_of_and_zstandard_is_refused_by_name() {
    for name in ["gdal_planar_separate", "gdal_pixel_interleaved"] {
        assert!(open(name).unwrap().1.concat().contains("2 bands"), "{name}");
    }
    let error = open("gdal_zstd").unwrap_err().to_string();
    assert!(error.contains("Zstandard") && error.contains("gdal_zstd.tif"), "{error}");
}
