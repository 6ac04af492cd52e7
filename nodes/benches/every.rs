//! Every node that needs no file, with its default settings, on terrain of three sizes.
//!
//! The list is the registry's own, so a new node is measured by being registered. Writers write into memory that is
//! thrown away at once.

mod host;

use std::{fmt, sync::Arc, time::Duration};

use divan::Bencher;
use host::Nowhere;
use orograph_contract::inputs_of;
use orograph_core::{Context, Instance, Job, NodeType, ParamKind};

const SIDES: [usize; 3] = [256, 512, 1024];

fn main() {
    // On a thread of the pool, as an evaluation runs nodes; from outside, each parallel step would wake one first.
    rayon::scope(|_| divan::main());
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
    let host = Nowhere::default();
    let job = Job::new(&host, Context { seed: 1, resolution: u32::try_from(case.side).ok() });
    bencher.bench(|| case.instance.run(&slots, &job));
}
