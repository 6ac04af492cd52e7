//! Voids of a rough terrain, and a terrain rebuilt from few samples.

mod ground;

use divan::{Bencher, counter::ItemsCount};
use ground::rough;
use orograph_core::{Heightfield, Job, Node, key, unit};
use orograph_nodes::repair::{
    harmonic_fill::harmonic_fill,
    thin_plate_fill::{Stiffness, thin_plate_fill},
    void_patch::{VoidPatch, VoidPatchIn},
};

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}

/// Discs of 10 to 100 cells across, about so many cells in all.
fn holed(side: usize, cells: usize) -> Heightfield {
    let mut terrain = rough((side, side), 90.0, 9, 2000.0);
    let mut done = 0;
    for which in 0.. {
        if done >= cells {
            break;
        }
        let number = |k: u64| unit(key(9, k, which, 0));
        let (row, col) = (number(0) * side as f64, number(1) * side as f64);
        let radius = 5.0 + 45.0 * number(2);
        for i in 0..side * side {
            let (down, across) = ((i / side) as f64 - row, (i % side) as f64 - col);
            let height = &mut terrain.cells_mut()[i];
            if down * down + across * across < radius * radius && !height.is_nan() {
                *height = f32::NAN;
                done += 1;
            }
        }
    }
    terrain
}

/// A tile of 1201² with 131,000 void cells, one of 1025² with 5 %, and half and a quarter as many voids.
const VOIDS: [(usize, usize); 4] = [(1201, 131_000), (1201, 65_500), (1201, 32_750), (1025, 52_500)];

#[divan::bench(args = VOIDS)]
fn patch_voids(bencher: Bencher, (side, cells): (usize, usize)) {
    let terrain = holed(side, cells);
    bencher.counter(ItemsCount::new(cells)).bench_local(|| {
        VoidPatch::default().run(VoidPatchIn { terrain: &terrain, around: None }, &Job::detached())
    });
}

#[divan::bench(args = VOIDS)]
fn thin_plate(bencher: Bencher, (side, cells): (usize, usize)) {
    let terrain = holed(side, cells);
    bencher
        .counter(ItemsCount::new(cells))
        .bench_local(|| thin_plate_fill(&terrain, None, Stiffness::default(), &Job::detached()));
}

#[divan::bench(args = VOIDS)]
fn harmonic(bencher: Bencher, (side, cells): (usize, usize)) {
    let terrain = holed(side, cells);
    bencher.counter(ItemsCount::new(cells)).bench_local(|| harmonic_fill(&terrain, None, &Job::detached()));
}

/// A terrain of 1025² rebuilt from 3.4 % of its cells.
#[divan::bench]
fn rebuild_by_thin_plate(bencher: Bencher) {
    let mut terrain = rough((1025, 1025), 90.0, 9, 2000.0);
    let lost = |i: usize| unit(key(5, 5, i as i64, 0)) > 0.034;
    terrain
        .cells_mut()
        .iter_mut()
        .enumerate()
        .filter(|(i, _)| lost(*i))
        .for_each(|(_, height)| *height = f32::NAN);
    bencher
        .counter(ItemsCount::new(1025_usize * 1025))
        .bench_local(|| thin_plate_fill(&terrain, None, Stiffness::default(), &Job::detached()));
}
