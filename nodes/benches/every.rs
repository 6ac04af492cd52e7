//! Every node that needs no file, with its default settings, on terrain of three sizes.
//!
//! The list is the registry's own, so a new node is measured by being registered. Writers write into memory that is
//! thrown away at once.

use std::{
    fmt,
    io::{self, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::Arc,
    time::Duration,
};

use divan::Bencher;
use orograph_contract::inputs_of;
use orograph_core::{Context, Error, Host, Instance, Job, NodeType, OutputStream, ParamKind, Result};

const SIDES: [usize; 3] = [256, 512, 1024];

fn main() {
    divan::main();
}

/// A node on terrain of one size.
struct Case {
    node: NodeType,
    instance: Arc<dyn Instance>,
    side: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.node.spec().id, self.side)
    }
}

fn cases() -> Vec<Case> {
    let sizes =
        SIDES.into_iter().flat_map(|side| orograph_nodes::all().into_iter().map(move |node| (node, side)));
    let mut cases: Vec<Case> = sizes
        .filter(|(node, _)| {
            !node.spec().params.iter().any(|param| matches!(param.kind, ParamKind::InputPath))
        })
        .filter_map(|(node, side)| {
            let values: Vec<_> = node.spec().params.iter().map(|param| param.default.clone()).collect();
            let instance = node.instantiate(&values).ok()?;
            Some(Case { node, instance, side })
        })
        .collect();
    cases.sort_by_key(|case| (case.node.spec().id.to_string(), case.side));
    cases
}

#[divan::bench(args = cases(), sample_count = 3, sample_size = 1, max_time = Duration::from_secs(3))]
fn node(bencher: Bencher<'_, '_>, case: &Case) {
    let slots = inputs_of(case.node.spec(), case.side, case.side);
    let job = Job::new(&Nowhere, Context { seed: 1, resolution: u32::try_from(case.side).ok() });
    bencher.bench(|| case.instance.run(&slots, &job));
}

/// A host whose files are nowhere.
struct Nowhere;

impl Host for Nowhere {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        8 << 30
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Err(Error::reading(path, "there are no files here"))
    }
    fn create(&self, _: &str) -> Result<Box<dyn OutputStream>> {
        Ok(Box::new(Nothing(io::Cursor::default())))
    }
}

struct Nothing(io::Cursor<Vec<u8>>);

impl Write for Nothing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Nothing {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

impl OutputStream for Nothing {
    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
