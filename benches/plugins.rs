//! What a plugin's call costs, here and in a process of its own, beside copying its inputs and outputs.

// A benchmark that cannot be set up is no benchmark.
#![allow(clippy::unwrap_used)]

use std::{
    path::{Path, PathBuf},
    process::Command,
    sync::{Arc, LazyLock},
};

use divan::{Bencher, black_box};
use orograph_core::{CellSize, Grid, Heightfield, Instance, Job, Slot, Value};
use orograph_engine::{
    Registry,
    plugin::{Plugins, Program},
};

fn main() {
    divan::main();
}

static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join("passthrough.so");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-O2", "-o"]).arg(&library).arg("-I").arg(root.join("plugins"));
    assert!(compiler.arg(root.join("benches/passthrough.c")).status().unwrap().success());
    library
});

/// The plugin's node, and what must live as long as it.
fn node(apart: bool) -> (Plugins, Arc<dyn Instance>) {
    let executable = env!("CARGO_BIN_EXE_orograph").into();
    let program = Program { executable, arguments: vec!["plugin-host".into()] };
    let plugins = Plugins::new(None, program).unwrap();
    let mut registry = Registry::default();
    let found = plugins.register(std::slice::from_ref(&*LIBRARY), &mut registry, &|_| apart);
    assert!(found[0].outcome.is_ok(), "{found:?}");
    let instance = registry.get("pass.through").unwrap().instantiate(&[]).unwrap();
    (plugins, instance)
}

fn terrain(side: usize) -> Heightfield {
    let grid = Grid::new(side, side, CellSize::square(30.0)).unwrap();
    Heightfield::build(grid, &Job::detached(), |row, cells| {
        cells.iter_mut().enumerate().for_each(|(col, cell)| *cell = (row * 7 + col) as f32);
        Ok(())
    })
    .unwrap()
}

const SIDES: [usize; 4] = [1, 257, 1025, 4097];

fn call(bencher: Bencher, side: usize, apart: bool) {
    let (_plugins, node) = node(apart);
    let slots = [Slot::One(Value::Heightfield(Arc::new(terrain(side))))];
    bencher.bench(|| node.run(black_box(&slots), &Job::detached()).unwrap());
}

#[divan::bench(args = SIDES)]
fn here(bencher: Bencher, side: usize) {
    call(bencher, side, false);
}

#[divan::bench(args = SIDES)]
fn apart(bencher: Bencher, side: usize) {
    call(bencher, side, true);
}

/// The measure for both: the input and the output copied once into fresh memory.
#[divan::bench(args = SIDES)]
fn copies_of_input_and_output(bencher: Bencher, side: usize) {
    let terrain = terrain(side);
    bencher.bench(|| (black_box(&terrain).clone(), black_box(&terrain).clone()));
}
