//! Synthesis: the cut, the seam equations on a rectangle and on a disc, the window search, and the whole.

use divan::{Bencher, counter::ItemsCount};
use orograph_core::{CellSize, Features, Grid, Heightfield, Job, Node, key, signed_unit};
use orograph_nodes::{
    feature::{
        ppa::{Ppa, PpaIn},
        settings::Reduction,
    },
    synthesis::{
        cut::{Keep, Overlay, SeamWeight, seam},
        exemplar::Exemplar,
        poisson::{
            masked::{self, Cell, Domain},
            rectangle,
        },
        settings::{Order, Preset, Rules},
        ssd::{Query, Searcher},
        synthesise::{SynthesiseIn, synthesise},
    },
};

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}

/// Fractal noise of value lattices, 10 m cells.
fn terrain(rows: usize, cols: usize, seed: u64) -> Heightfield {
    let height = |row: usize, col: usize| {
        (0..8_u64).fold(0.0, |sum, octave| {
            let step = 256_usize >> octave;
            let lattice = |y: usize, x: usize| signed_unit(key(seed, octave, x as i64, y as i64));
            let (y, x) = (row / step, col / step);
            let (fy, fx) = ((row % step) as f64 / step as f64, (col % step) as f64 / step as f64);
            let top = lattice(y, x) + (lattice(y, x + 1) - lattice(y, x)) * fx;
            let bottom = lattice(y + 1, x) + (lattice(y + 1, x + 1) - lattice(y + 1, x)) * fx;
            sum + (top + (bottom - top) * fy) * 800.0 / f64::from(1_u32 << octave)
        })
    };
    let cells = (0..rows * cols).map(|i| height(i / cols, i % cols) as f32).collect();
    let grid = Grid::new(rows, cols, CellSize::square(10.0)).expect("the sides are small");
    Heightfield::new(grid, cells).expect("one height a cell")
}

#[divan::bench(args = [(80, 27), (150, 150), (1024, 256), (2048, 2048)], max_time = 10)]
fn cut(bencher: Bencher<'_, '_>, (rows, cols): (usize, usize)) {
    let (old, new) = (terrain(rows, cols, 1), terrain(rows, cols, 2));
    let side = |i: usize| match i % cols {
        0 => Keep::Old,
        col if col + 1 == cols => Keep::New,
        _ => Keep::Either,
    };
    let keep: Vec<Keep> = (0..rows * cols).map(side).collect();
    let overlay = Overlay { cols, old: old.cells(), new: new.cells(), keep: &keep };
    bencher
        .counter(ItemsCount::new(rows * cols))
        .bench(|| seam(&overlay, SeamWeight::Plain, &Job::detached()));
}

#[divan::bench(args = [511, 512, 2047])]
fn seam_on_a_rectangle(bencher: Bencher<'_, '_>, side: usize) {
    let b: Vec<f64> = (0..side * side).map(|i| if i % side == side / 2 { 10.0 } else { 0.0 }).collect();
    bencher.counter(ItemsCount::new(side * side)).bench(|| rectangle::solve(side, &b, &Job::detached()));
}

#[divan::bench(args = [150, 512])]
fn seam_on_a_disc(bencher: Bencher<'_, '_>, side: usize) {
    let half = side as f64 / 2.0;
    let away = |i: usize| libm::hypot((i / side) as f64 - half, (i % side) as f64 - half);
    let cells: Vec<Cell> =
        (0..side * side).map(|i| if away(i) < half - 2.0 { Cell::Free } else { Cell::Fixed }).collect();
    let b: Vec<f64> = (0..side * side).map(|i| if i % side == side / 2 { 10.0 } else { 0.0 }).collect();
    let domain = Domain { cols: side, cells: &cells, weights: [1.0; 2] };
    bencher.counter(ItemsCount::new(side * side)).bench(|| masked::solve(&domain, &b, &Job::detached()));
}

#[divan::bench(args = [1201, 4096])]
fn window_search(bencher: Bencher<'_, '_>, side: usize) {
    let exemplar = Exemplar::new(&terrain(side, side, 3), &Job::detached()).expect("there is ground");
    let searcher = Searcher::new(&exemplar, &[], &Job::detached()).expect("there is room");
    let window = terrain(150, 150, 4);
    let open: Vec<bool> = (0..150 * 150).map(|i| i % 150 > 50).collect();
    let heights: Vec<f32> = window
        .cells()
        .iter()
        .zip(&open)
        .map(|(&height, &open)| if open { f32::NAN } else { height })
        .collect();
    let query = Query {
        cols: 150,
        heights: &heights,
        open: &open,
        lift: Some(200.0),
        most_lines: f64::INFINITY,
        usual_lines: 0.0,
        balanced: false,
        n: 4,
    };
    bencher.bench(|| searcher.search(&query, &[1], |_| 0, &Job::detached()));
}

fn features(terrain: &Heightfield) -> Features {
    let node = Ppa { profiles: false, ..Ppa::default() };
    node.run(PpaIn { terrain }, &Job::detached()).expect("there is ground").features
}

#[divan::bench(args = [512, 1000], sample_count = 5)]
fn whole(bencher: Bencher<'_, '_>, side: usize) {
    let exemplar = terrain(1201, 1201, 5);
    let lines = features(&exemplar);
    // The lines of other ground, the main ones only, are the sketch.
    let ground = terrain(side, side, 6);
    let reduction = Reduction { min_group: 60, ..Reduction::default() };
    let node = Ppa { profiles: false, density: 0.005, reduction, ..Ppa::default() };
    let sketch = node.run(PpaIn { terrain: &ground }, &Job::detached()).expect("there is ground").features;
    let inputs = SynthesiseIn {
        sketches: vec![&sketch],
        exemplars: vec![&exemplar],
        features: vec![&lines],
        styles: None,
        given: None,
        constraints: None,
    };
    let rules = Rules::of(Preset::Default, 80);
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| synthesise(&inputs, &rules, Order::Tree, &Job::detached()));
}
