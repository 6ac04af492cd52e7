//! What is tried on bytes that nobody vouches for: every reader of data, of graphs, of plugins and of the cache.
//!
//! A target takes any bytes and comes back. It panics where what it tried breaks a promise: a panic of its own, an
//! error that says nothing, a value that is none, a text that does not survive being written and read.
//!
//! `fuzz_targets` hands the targets to the fuzzer, and `tests/corpus.rs` runs them over the seeds.

mod binaries;
mod readers;
mod texts;

use orograph_core::{Context, Error, Heightfield, Host, Job, OutputStream, Result};

/// A name, and what takes any bytes.
pub type Target = (&'static str, fn(&[u8]));

/// The targets; each has seeds in `seeds/<name>` and a `[[bin]]` in the manifest.
pub const TARGETS: &[Target] = &[
    ("geotiff", readers::geotiff),
    ("hgt", readers::hgt),
    ("zip", readers::zip),
    ("ascii", readers::ascii),
    ("png", readers::png),
    ("raw", readers::raw),
    ("exr", readers::exr),
    ("points", readers::points),
    ("document", texts::document),
    ("settings", texts::settings),
    ("plugin_spec", texts::plugin_spec),
    ("library", binaries::library),
    ("cache", binaries::cache),
];

/// Runs a target on bytes.
pub fn run(name: &str, bytes: &[u8]) {
    match TARGETS.iter().find(|target| target.0 == name) {
        Some((_, target)) => target(bytes),
        None => panic!("no target is named {name}"),
    }
}

/// A host that lends little memory, so that a reader that takes what it did not ask for stands out.
struct Frugal;

/// What it lends.
const MEMORY: u64 = 32 << 20;

impl Host for Frugal {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, done: f64) {
        assert!((0.0..=1.0).contains(&done), "{done} of the work is done");
    }
    fn warn(&self, message: &str) {
        assert!(!message.is_empty());
    }
    fn memory_limit(&self) -> u64 {
        MEMORY
    }
    fn input_path(&self, path: &str) -> Result<std::path::PathBuf> {
        Ok(path.into())
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::writing(path, "nothing is written here"))
    }
}

fn job() -> Job<'static> {
    Job::new(&Frugal, Context::default())
}

/// An error must say what is wrong, and what would mend it.
fn is_told(error: &Error) {
    assert!(!error.to_string().is_empty() && error.hint().is_some(), "{error:?}");
    assert!(!matches!(error, Error::Cancelled | Error::Panicked { .. }), "{error:?}");
}

/// What a reader of heights gives: some, all finite or void, or an error.
fn heights(outcome: Result<Heightfield>) -> Option<Heightfield> {
    match outcome {
        Ok(terrain) => {
            let grid = terrain.grid();
            assert!(!grid.is_empty() && grid.len() == terrain.cells().len());
            assert!(
                grid.cell.x > 0.0 && grid.cell.x.is_finite() && grid.cell.y > 0.0 && grid.cell.y.is_finite()
            );
            assert!(terrain.cells().iter().all(|height| !height.is_infinite()));
            assert!(grid.len() as u64 * 4 <= MEMORY);
            Some(terrain)
        }
        Err(error) => {
            is_told(&error);
            None
        }
    }
}

/// Whether two rasters hold the same heights, and voids in the same places.
fn same(a: &Heightfield, b: &Heightfield) -> bool {
    a.grid().size() == b.grid().size()
        && a.cells().iter().zip(b.cells()).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
}
