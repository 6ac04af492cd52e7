//! Throughput of the formats on a 4097 × 4097 terrain, in bytes of raw samples.
//!
//! `OROGRAPH_DEM_DIR` (default `../shared/dem`) supplies real relief, mirrored to size; without it a synthetic
//! field with noise of a few decimetres stands in. Run with `RAYON_NUM_THREADS=1` for CPU seconds.

use std::{io::Cursor, path::Path, sync::LazyLock};

use divan::{Bencher, counter::BytesCount};
use orograph_core::{key, prelude::*, signed_unit};
use orograph_nodes::io::{
    exr,
    geotiff::{self, Compression, Options, SampleType},
    hgt, read_dem, read_png,
    write_png::{self, Depth},
};

const SIDE: usize = 4097;
const CELLS: usize = SIDE * SIDE;

static TERRAIN: LazyLock<Heightfield> = LazyLock::new(terrain);

/// Real relief mirrored to size, or a stand-in.
fn terrain() -> Heightfield {
    let folder = std::env::var("OROGRAPH_DEM_DIR")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/dem").into());
    let job = Job::detached();
    let path = Path::new(&folder).join("half_dome_yosemite_ned1as_1027x875.tif");
    let dem = std::fs::read(path).ok().and_then(|bytes| read_dem::read(&bytes, "dem", &job).ok());
    let grid = Grid::new(SIDE, SIDE, CellSize::square(30.0)).expect("a sound grid");
    let mirrored = |i: usize, n: usize| if (i / n).is_multiple_of(2) { i % n } else { n - 1 - i % n };
    Heightfield::build(grid, &job, |row, out| {
        for (col, out) in out.iter_mut().enumerate() {
            *out = match &dem {
                Some(dem) => dem.at(mirrored(row, dem.rows()), mirrored(col, dem.cols())),
                None => {
                    let wave = libm::sin(row as f64 / 90.0) + libm::cos(col as f64 / 70.0);
                    (1500.0 + 600.0 * wave + signed_unit(key(1, 0, row as i64, col as i64))) as f32
                }
            };
        }
        Ok(())
    })
    .expect("memory for the terrain")
}

fn options(sample: SampleType) -> Options {
    Options { sample, compression: Compression::Deflate, level: 1, ..Options::default() }
}

fn bytes_of(sample: SampleType) -> usize {
    if sample == SampleType::Float32 { CELLS * 4 } else { CELLS * 2 }
}

fn geotiff_bytes(sample: SampleType) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    geotiff::write(&TERRAIN, &options(sample), &mut out, "bench", &Job::detached()).expect("it fits");
    out.into_inner()
}

#[divan::bench(args = [SampleType::Int16, SampleType::Float32], sample_count = 5)]
fn write_geotiff(bencher: Bencher<'_, '_>, sample: SampleType) {
    LazyLock::force(&TERRAIN);
    bencher.counter(BytesCount::new(bytes_of(sample))).bench(|| geotiff_bytes(sample));
}

#[divan::bench(args = [SampleType::Int16, SampleType::Float32], sample_count = 5)]
fn read_geotiff(bencher: Bencher<'_, '_>, sample: SampleType) {
    let bytes = geotiff_bytes(sample);
    bencher
        .counter(BytesCount::new(bytes_of(sample)))
        .bench(|| geotiff::read(&bytes, "bench", &Job::detached()).expect("it is sound"));
}

fn png_bytes() -> Vec<u8> {
    let mut out = Vec::new();
    write_png::write(&TERRAIN, Depth::Sixteen, (0.0, 4000.0), &mut out, "bench", &Job::detached())
        .expect("it fits");
    out
}

#[divan::bench(sample_count = 5)]
fn write_png_16(bencher: Bencher<'_, '_>) {
    LazyLock::force(&TERRAIN);
    bencher.counter(BytesCount::new(CELLS * 2)).bench(png_bytes);
}

#[divan::bench(sample_count = 5)]
fn read_png_16(bencher: Bencher<'_, '_>) {
    let bytes = png_bytes();
    let cell = CellSize::square(30.0);
    bencher.counter(BytesCount::new(CELLS * 2)).bench(|| {
        read_png::read(&bytes, "bench", (0.0, 4000.0), cell, &Job::detached()).expect("it is sound")
    });
}

#[divan::bench(sample_count = 5)]
fn write_exr(bencher: Bencher<'_, '_>) {
    LazyLock::force(&TERRAIN);
    bencher.counter(BytesCount::new(CELLS * 4)).bench(|| {
        let mut out = Cursor::new(Vec::new());
        exr::write(&TERRAIN, &mut out, "bench", &Job::detached()).expect("it fits");
        out
    });
}

#[divan::bench(sample_count = 10)]
fn read_hgt_3601(bencher: Bencher<'_, '_>) {
    let bytes = vec![1; 3601 * 3601 * 2];
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench(|| hgt::read(&bytes, "N44W072.hgt", &Job::detached()).expect("it is sound"));
}

#[divan::bench(sample_count = 10)]
fn write_hgt_3601(bencher: Bencher<'_, '_>) {
    let terrain =
        TERRAIN.crop(0, 0, 3601, 3601, &Job::detached()).expect("the terrain is larger than a tile");
    bencher
        .counter(BytesCount::new(3601_usize * 3601 * 2))
        .bench(|| hgt::write(&terrain, &Job::detached()).expect("it fits"));
}

fn main() {
    divan::main();
}
