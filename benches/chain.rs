//! Ten pointwise or small-stencil nodes in a row at 4096 × 4096, through the evaluator.
//!
//! `benches/numpy_chain.py` does the same in NumPy. Two terrains are made beforehand; every sample changes the
//! first node's setting, so that all ten nodes run and all ten outputs are digested and cached.

use std::{
    hint::black_box,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

use divan::Bencher;
use orograph_core::ParamValue::{self, Number, Text};
use orograph_engine::{
    Cache, CancelToken, Evaluator, Graph, GraphBuilder, NodeId, OutputRef, Registry, Request, eval::Silent,
};

const SIDE: i64 = 4096;

fn main() {
    divan::main();
}

struct Chain {
    registry: Registry,
    builder: GraphBuilder,
}

impl Chain {
    fn add(&mut self, name: &str, id: &str, set: &[(&str, ParamValue)], wires: &[(&str, NodeId)]) -> NodeId {
        let node_type = self.registry.get(id).expect("a built-in node");
        let value = |name: &str| set.iter().find(|(set, _)| *set == name).map(|(_, value)| value.clone());
        let params = &node_type.spec().params;
        let values = params.iter().map(|param| value(&param.name).unwrap_or(param.default.clone())).collect();
        let node = self.builder.add(name, node_type, values).expect("sound settings");
        for (port, from) in wires {
            self.builder.wire(OutputRef { node: *from, output: 0 }, node, port).expect("a sound wire");
        }
        node
    }
}

/// The graph, its two sources, and its last node.
fn graph(shift: f64) -> (Arc<Graph>, [OutputRef; 2], OutputRef) {
    let registry = Registry::new(orograph_nodes::all()).expect("distinct ids");
    let mut chain = Chain { registry, builder: GraphBuilder::new() };
    let source = |seed| [("cells", ParamValue::Integer(SIDE)), ("seed", ParamValue::Integer(seed))];
    let a = chain.add("a", "generate.fbm", &source(1), &[]);
    let b = chain.add("b", "generate.fbm", &source(2), &[]);
    let operation = |name: &str| ("operation", Text(name.into()));
    let value = |value| ("value", Number(value));

    let raised = chain.add("raised", "combine.arithmetic", &[operation("add"), value(shift)], &[("a", a)]);
    let sum = chain.add("sum", "combine.arithmetic", &[operation("add")], &[("a", raised), ("b", b)]);
    let levels = [("from_low", -2000.0), ("from_high", 2000.0), ("to_low", 0.0), ("to_high", 3000.0)];
    let levels = levels.map(|(name, level)| (name, Number(level)));
    let remapped = chain.add("remapped", "adjust.remap", &levels, &[("terrain", sum)]);
    let ends = [("lowest", Number(1000.0)), ("highest", Number(2500.0))];
    let clamped = chain.add("clamped", "adjust.clamp", &ends, &[("terrain", remapped)]);
    let scaled =
        chain.add("scaled", "combine.arithmetic", &[operation("multiply"), value(0.5)], &[("a", clamped)]);
    let share = [("share", Number(0.3))];
    let mixed = chain.add("mixed", "combine.blend", &share, &[("a", scaled), ("b", b)]);
    let floored =
        chain.add("floored", "combine.arithmetic", &[operation("maximum"), value(300.0)], &[("a", mixed)]);
    let soft = [("low", Number(450.0)), ("high", Number(700.0)), ("soft", Number(100.0))];
    let band = chain.add("band", "mask.from_height", &soft, &[("terrain", floored)]);
    let wires = [("a", floored), ("b", scaled), ("mask", band)];
    let masked = chain.add("masked", "combine.blend", &[("share", Number(1.0))], &wires);
    let shaded = chain.add("shaded", "look.hillshade", &[], &[("terrain", masked)]);

    let output = |node| OutputRef { node, output: 0 };
    let graph = chain.builder.build().expect("a sound graph");
    (Arc::new(graph), [output(a), output(b)], output(shaded))
}

#[divan::bench(args = [1, 2], sample_count = 5, sample_size = 1)]
fn ten_nodes_at_4096(bencher: Bencher<'_, '_>, jobs: usize) {
    // Room for the sources and one sample's outputs, as a session with the default budget has.
    let evaluator = Evaluator::new(Cache::new(1 << 30, None), jobs).expect("threads");
    let pull = |graph: Arc<Graph>, outputs: Vec<OutputRef>| {
        let report = evaluator.run(Request::values(graph, outputs), Arc::new(Silent), &CancelToken::new());
        assert!(report.values.iter().all(Option::is_some));
        black_box(report);
    };
    let (first, sources, _) = graph(0.0);
    pull(first, sources.to_vec());
    let sample = AtomicU64::new(0);
    bencher
        .with_inputs(|| {
            // The sources count as used, so that the budget drops the last sample's outputs before them.
            let (graph, sources, last) = graph(1.0 + sample.fetch_add(1, Ordering::Relaxed) as f64);
            pull(Arc::clone(&graph), sources.to_vec());
            (graph, last)
        })
        .bench_local_values(|(graph, last)| pull(graph, vec![last]));
}
