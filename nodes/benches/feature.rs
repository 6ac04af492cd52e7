//! Ridges of rough ground, a sketch of wide strokes, a plan and its adherence.

mod ground;

use divan::{Bencher, counter::ItemsCount};
use ground::rough;
use orograph_core::{CellSize, Grid, Heightfield, Job, Node};
use orograph_nodes::feature::{
    adherence::{Adherence, AdherenceIn},
    from_sketch::{FromSketch, FromSketchIn},
    plan::{Order, plan},
    ppa::{Ppa, PpaIn},
};

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}

/// A bright cross with a ring around it.
fn sketch(side: usize, width: f64) -> Heightfield {
    let middle = side as f64 / 2.0;
    let grey = |i: usize| {
        let (y, x) = ((i / side) as f64 - middle, (i % side) as f64 - middle);
        let cross = if x.abs().max(y.abs()) < 0.3 * side as f64 { x.abs().min(y.abs()) } else { f64::MAX };
        let ring = ((x * x + y * y).sqrt() - 0.4 * side as f64).abs();
        if cross.min(ring) <= width / 2.0 { 1.0 } else { 0.0 }
    };
    let grid = Grid::new(side, side, CellSize::square(10.0)).expect("the side is small");
    Heightfield::new(grid, (0..side * side).map(grey).collect()).expect("one grey a cell")
}

/// Working cells of 5 × 5 cells, and the cells themselves.
#[divan::bench(args = [(1201, 1201, 5), (2401, 3601, 5), (4097, 4097, 5), (1025, 1025, 1)], sample_count = 5)]
fn ppa(bencher: Bencher, (rows, cols, working_cell): (usize, usize, u32)) {
    let terrain = rough((rows, cols), 10.0, 8, 1000.0);
    let node = Ppa { working_cell, ..Ppa::default() };
    bencher
        .counter(ItemsCount::new(rows * cols))
        .bench(|| node.run(PpaIn { terrain: &terrain }, &Job::detached()));
}

#[divan::bench(args = [(512, 10.0), (1000, 10.0), (1000, 40.0)], sample_count = 5)]
fn from_sketch(bencher: Bencher, (side, width): (usize, f64)) {
    let sketch = sketch(side, width);
    let node = FromSketch::default();
    bencher.bench(|| node.run(FromSketchIn { sketch: &sketch }, &Job::detached()));
}

#[divan::bench(sample_count = 20)]
fn plan_of_a_sketch(bencher: Bencher) {
    let sketch = sketch(1000, 15.0);
    let drawn = FromSketch::default().run(FromSketchIn { sketch: &sketch }, &Job::detached());
    let features = drawn.expect("the sketch is sound").features;
    bencher.bench(|| plan(&features, 80.0, Order::TreeBfs, &Job::detached()));
}

#[divan::bench(sample_count = 5)]
fn adherence(bencher: Bencher) {
    let (sketch, terrain) = (sketch(1000, 15.0), rough((1000, 1000), 10.0, 8, 1000.0));
    let drawn = FromSketch::default().run(FromSketchIn { sketch: &sketch }, &Job::detached());
    let drawn = drawn.expect("the sketch is sound").features;
    let node = Adherence::default();
    bencher
        .bench(|| node.run(AdherenceIn { drawn: &drawn, terrain: &terrain, found: None }, &Job::detached()));
}
