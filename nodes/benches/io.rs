//! Throughput of the formats of terrain at three sizes, in bytes of raw samples.
//!
//! `OROGRAPH_DEM_DIR` (default `../shared/dem`) supplies real relief, mirrored to size; without it a synthetic
//! field with noise of a few decimetres stands in. Run with `RAYON_NUM_THREADS=1` for CPU seconds.

use std::{fmt, io::Cursor, path::Path, sync::LazyLock};

use divan::{Bencher, counter::BytesCount};
use orograph_core::{key, prelude::*, signed_unit};
use orograph_nodes::io::{
    ascii, exr,
    geotiff::{self, Compression, Options, SampleType},
    hgt,
    raw::{self, RawFormat, RawLayout},
    read_dem, read_png,
    write_png::{self, Depth},
};

const SIDES: [usize; 3] = [1025, 2049, 4097];
/// HGT has two sizes.
const TILES: [usize; 2] = [1201, 3601];
const RANGE: (f64, f64) = (0.0, 4000.0);
const CELL: CellSize = CellSize::square(30.0);
const RAW: RawLayout = RawLayout { format: RawFormat::R16Little, range: RANGE, south_first: false };

static TERRAIN: LazyLock<Heightfield> = LazyLock::new(terrain);

/// Real relief mirrored to the largest size, or a stand-in.
fn terrain() -> Heightfield {
    let folder = std::env::var("OROGRAPH_DEM_DIR")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/dem").into());
    let job = Job::detached();
    let path = Path::new(&folder).join("half_dome_yosemite_ned1as_1027x875.tif");
    let dem = std::fs::read(path).ok().and_then(|bytes| read_dem::read(&bytes, "dem", &job).ok());
    let side = SIDES[SIDES.len() - 1];
    let grid = Grid::new(side, side, CELL).expect("a sound grid");
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

/// A format, how it is written and read, and bytes of a raw sample.
struct Format {
    name: &'static str,
    sample: usize,
    sides: &'static [usize],
    write: fn(&Heightfield, &Job) -> Result<Vec<u8>>,
    read: fn(&[u8], &Job) -> Result<Heightfield>,
}

static FORMATS: [Format; 7] = [
    Format {
        name: "geotiff_int16",
        sample: 2,
        sides: &SIDES,
        write: |terrain, job| write_geotiff(terrain, SampleType::Int16, job),
        read: |bytes, job| geotiff::read(bytes, "bench", job),
    },
    Format {
        name: "geotiff_float32",
        sample: 4,
        sides: &SIDES,
        write: |terrain, job| write_geotiff(terrain, SampleType::Float32, job),
        read: |bytes, job| geotiff::read(bytes, "bench", job),
    },
    Format {
        name: "png_16",
        sample: 2,
        sides: &SIDES,
        write: |terrain, job| {
            let mut out = Vec::new();
            write_png::write(terrain, Depth::Sixteen, RANGE, &mut out, "bench", job).map(|()| out)
        },
        read: |bytes, job| read_png::read(bytes, "bench", RANGE, CELL, job),
    },
    Format {
        name: "exr",
        sample: 4,
        sides: &SIDES,
        write: |terrain, job| {
            let mut out = Cursor::new(Vec::new());
            exr::write(terrain, &mut out, "bench", job).map(|()| out.into_inner())
        },
        read: |bytes, job| exr::read(bytes, "bench", CELL, job),
    },
    Format {
        name: "raw_16",
        sample: 2,
        sides: &SIDES,
        write: |terrain, job| raw::write(terrain, &RAW, job),
        read: |bytes, job| {
            let side = (bytes.len() / 2).isqrt();
            raw::read(bytes, "bench", Grid::new(side, side, CELL)?, &RAW, job)
        },
    },
    Format {
        name: "ascii",
        sample: 4,
        sides: &SIDES,
        write: |terrain, job| {
            let mut out = Vec::new();
            ascii::write(terrain, &mut out, "bench", job).map(|()| out)
        },
        read: |bytes, job| ascii::read(bytes, "bench", job),
    },
    Format {
        name: "hgt",
        sample: 2,
        sides: &TILES,
        write: hgt::write,
        read: |bytes, job| hgt::read(bytes, "N44W072.hgt", job),
    },
];

fn write_geotiff(terrain: &Heightfield, sample: SampleType, job: &Job) -> Result<Vec<u8>> {
    let options = Options { sample, compression: Compression::Deflate, level: 1, ..Options::default() };
    let mut out = Cursor::new(Vec::new());
    geotiff::write(terrain, &options, &mut out, "bench", job).map(|()| out.into_inner())
}

/// A format at one size.
struct Case(&'static Format, usize);

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0.name, self.1)
    }
}

impl Case {
    fn terrain(&self) -> Heightfield {
        TERRAIN.crop(0, 0, self.1, self.1, &Job::detached()).expect("no side is larger than the terrain's")
    }

    fn bytes(&self) -> BytesCount {
        BytesCount::new(self.1 * self.1 * self.0.sample)
    }
}

fn cases() -> impl Iterator<Item = Case> {
    FORMATS.iter().flat_map(|format| format.sides.iter().map(move |&side| Case(format, side)))
}

#[divan::bench(args = cases(), sample_count = 5)]
fn write(bencher: Bencher<'_, '_>, case: &Case) {
    let terrain = case.terrain();
    bencher
        .counter(case.bytes())
        .bench(|| (case.0.write)(&terrain, &Job::detached()).expect("the terrain fits the format"));
}

#[divan::bench(args = cases(), sample_count = 5)]
fn read(bencher: Bencher<'_, '_>, case: &Case) {
    let bytes = (case.0.write)(&case.terrain(), &Job::detached()).expect("the terrain fits the format");
    bencher
        .counter(case.bytes())
        .bench(|| (case.0.read)(&bytes, &Job::detached()).expect("what was written is sound"));
}

/// What "near memory speed" is measured against: the heights of a tile copied into memory of their own.
#[divan::bench(args = TILES, sample_count = 5)]
fn copy(bencher: Bencher<'_, '_>, side: usize) {
    let heights = Case(&FORMATS[6], side).terrain();
    bencher.counter(BytesCount::new(side * side * 2)).bench(|| heights.cells().to_vec());
}

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}
