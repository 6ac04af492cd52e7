//! Voids of a rough terrain, and a terrain rebuilt from few samples.

use divan::{Bencher, counter::ItemsCount};
use orograph_core::{CellSize, Grid, Heightfield, Job, Node, key, signed_unit, unit};
use orograph_nodes::repair::{
    harmonic_fill::harmonic_fill,
    thin_plate_fill::{Stiffness, thin_plate_fill},
    void_patch::{VoidPatch, VoidPatchIn},
};

fn main() {
    divan::main();
}

/// Fractal noise of value lattices, over cells of 90 m.
fn rough(rows: usize, cols: usize) -> Heightfield {
    let lattice = |octave: u64, x: usize, y: usize| signed_unit(key(1, octave, x as i64, y as i64));
    let height = |row: usize, col: usize| {
        (0..9).fold(0.0, |sum, octave| {
            let step = 512_usize >> octave;
            let (x, y, fx, fy) = (col / step, row / step, (col % step) as f64, (row % step) as f64);
            let (fx, fy) = (fx / step as f64, fy / step as f64);
            let at = |dx, dy| lattice(octave, x + dx, y + dy);
            let top = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
            let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
            sum + (top + (bottom - top) * fy) * 2000.0 / f64::from(1 << octave)
        })
    };
    let grid = Grid::new(rows, cols, CellSize::square(90.0)).expect("the sides are small");
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols) as f32).collect();
    Heightfield::new(grid, cells).expect("one height a cell")
}

/// Discs of 10 to 100 cells across, about so many cells in all.
fn holed(side: usize, cells: usize) -> Heightfield {
    let mut terrain = rough(side, side);
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
    bencher
        .counter(ItemsCount::new(cells))
        .bench_local(|| VoidPatch::default().run(VoidPatchIn { terrain: &terrain }, &Job::detached()));
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
    let mut terrain = rough(1025, 1025);
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
