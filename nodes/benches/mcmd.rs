//! MCMD on a rough field of which 3.4 % is known: the bottom-up pass, the top-down pass, and the whole node.

use divan::{Bencher, counter::ItemsCount};
use orograph_core::{CellSize, Grid, Heightfield, Job, Node, key, signed_unit, unit};
use orograph_nodes::mcmd::{
    mcmd::{Mcmd, McmdIn},
    md::{Md, MdIn},
    mdbu::{Mdbu, MdbuIn},
    params::LargeForms,
    settings::Preset,
};

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}

/// The share of samples that the paper keeps.
const KEEP: f64 = 35_721.0 / 1_050_625.0;

/// Fractal noise of value lattices, kept at random cells.
fn constraints(side: usize) -> Heightfield {
    let lattice = |octave: u64, x: usize, y: usize| signed_unit(key(1, octave, x as i64, y as i64));
    let height = |row: usize, col: usize| {
        (0..8).fold(0.0, |sum, octave| {
            let step = (side - 1) >> octave;
            let (x, y, fx, fy) = (col / step, row / step, (col % step) as f64, (row % step) as f64);
            let (fx, fy) = (fx / step as f64, fy / step as f64);
            let at = |dx, dy| lattice(octave, x + dx, y + dy);
            let top = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
            let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
            sum + (top + (bottom - top) * fy) * 1000.0 / f64::from(1 << octave)
        })
    };
    let cells = (0..side * side).map(|i| {
        let (row, col) = (i / side, i % side);
        let kept = unit(key(2, 0, col as i64, row as i64)) < KEEP;
        if kept { height(row, col) as f32 } else { f32::NAN }
    });
    let grid = Grid::new(side, side, CellSize::square(10.0)).expect("the side is small");
    Heightfield::new(grid, cells.collect()).expect("one height a cell")
}

/// Nothing known but two corners: every other cell is displaced.
fn corners(side: usize) -> Heightfield {
    let grid = Grid::new(side, side, CellSize::square(10.0)).expect("the side is small");
    let mut cells = vec![f32::NAN; side * side];
    (cells[0], cells[side * side - 1]) = (0.0, 1000.0);
    Heightfield::new(grid, cells).expect("one height a cell")
}

#[divan::bench(args = [1025, 4097], sample_count = 5)]
fn mdbu(bencher: Bencher, side: usize) {
    let constraints = constraints(side);
    let node = Mdbu { large_forms: LargeForms { l_bu: 6.0 }, ..Mdbu::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| node.run(MdbuIn { constraints: &constraints }, &Job::detached()));
}

#[divan::bench(args = [1025, 4097], sample_count = 5)]
fn md_plain(bencher: Bencher, side: usize) {
    let constraints = corners(side);
    let node = Md { named: Preset::Reconstruct.into(), ..Md::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| node.run(MdIn { constraints: &constraints }, &Job::detached()));
}

#[divan::bench(args = [1025, 4097], sample_count = 5)]
fn md_displaced(bencher: Bencher, side: usize) {
    let constraints = corners(side);
    let node = Md { named: Preset::Mountains.into(), ..Md::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| node.run(MdIn { constraints: &constraints }, &Job::detached()));
}

#[divan::bench(args = [1025, 4097], sample_count = 5)]
fn reconstruct(bencher: Bencher, side: usize) {
    let constraints = constraints(side);
    let node = Mcmd { named: Preset::Reconstruct.into(), ..Mcmd::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| node.run(McmdIn { constraints: &constraints }, &Job::detached()));
}

#[divan::bench(args = [1025, 4097], sample_count = 5)]
fn mountains(bencher: Bencher, side: usize) {
    let constraints = constraints(side);
    let node = Mcmd { named: Preset::Mountains.into(), ..Mcmd::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench(|| node.run(McmdIn { constraints: &constraints }, &Job::detached()));
}
