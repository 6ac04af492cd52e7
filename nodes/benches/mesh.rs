//! Meshes of rough terrain, in cells: adaptive at three sizes and errors, regular, and the files that hold them.
//!
//! `OROGRAPH_DEM_DIR` is not needed: the terrain is noise as rough as young mountains.

mod ground;

use divan::{Bencher, counter::ItemsCount};
use ground::rough;
use orograph_core::{Job, Node};
use orograph_nodes::mesh::triangulate::{Method, Triangulate, TriangulateIn};

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
}

#[divan::bench(args = [(513, 1.0), (1025, 1.0), (2049, 1.0), (4097, 1.0), (1025, 10.0), (4097, 10.0)], sample_count = 3)]
fn adaptive(bencher: Bencher, (side, max_error): (usize, f64)) {
    let terrain = rough((side, side), 30.0, 5, 1500.0);
    let node = Triangulate { max_error, ..Triangulate::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench_local(|| node.run(TriangulateIn { terrain: &terrain }, &Job::detached()));
}

#[divan::bench(args = [513, 1025, 2049, 4097], sample_count = 3)]
fn regular(bencher: Bencher, side: usize) {
    let terrain = rough((side, side), 30.0, 5, 1500.0);
    let node = Triangulate { method: Method::Regular, ..Triangulate::default() };
    bencher
        .counter(ItemsCount::new(side * side))
        .bench_local(|| node.run(TriangulateIn { terrain: &terrain }, &Job::detached()));
}
