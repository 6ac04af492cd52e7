//! Fractal noise: at most 50 ms of CPU time per million cells of eight octaves.

use divan::counter::ItemsCount;
use orograph_core::prelude::*;
use orograph_nodes::{
    Ground,
    generate::{GroundIn, fbm::Fbm, ridged::Ridged},
};

fn main() {
    divan::main();
}

fn one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread").install(work)
}

/// Metres per cell: from a build of 10 m cells to a preview whose last octaves are finer than a cell.
#[divan::bench(args = [10, 40, 160])]
fn fbm_8_octaves(bencher: divan::Bencher, cell: u32) {
    let extent = f64::from(cell) * 1000.0;
    let ground = Ground { width: extent, height: extent, cells: 1000 };
    let node = Fbm { ground, ..Fbm::default() };
    bencher
        .counter(ItemsCount::new(1_000_000_u64))
        .bench_local(|| one_thread(|| node.run(GroundIn { like: None }, &Job::detached())));
}

#[divan::bench(args = [10, 40, 160])]
fn ridged_8_octaves(bencher: divan::Bencher, cell: u32) {
    let extent = f64::from(cell) * 1000.0;
    let ground = Ground { width: extent, height: extent, cells: 1000 };
    let node = Ridged { ground, ..Ridged::default() };
    bencher
        .counter(ItemsCount::new(1_000_000_u64))
        .bench_local(|| one_thread(|| node.run(GroundIn { like: None }, &Job::detached())));
}
