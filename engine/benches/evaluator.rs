//! What evaluation costs beside the nodes: `cargo bench -p orograph-engine --bench evaluator`.
//!
//! Divide a line's time by its number of nodes for the cost of one.

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::Arc;

use divan::Bencher;
use orograph_engine::{CancelToken, Evaluator, Graph, OutputRef, Request, eval::Silent};
use support::{Bench, in_memory};

fn main() {
    divan::main();
}

/// A number, then `n - 1` additions one after the other.
fn chain(n: usize) -> (Arc<Graph>, OutputRef) {
    let mut bench = Bench::new();
    let mut node = bench.number("n0", 1.0);
    for i in 1..n {
        let more = [("more", orograph_core::ParamValue::Number(i as f64))];
        node = bench.add(&format!("n{i}"), "test.add", &more, &[("numbers", node, "number")]);
    }
    (bench.build(), OutputRef { node, output: 0 })
}

/// `n - 1` numbers into one sum.
fn fan(n: usize) -> (Arc<Graph>, OutputRef) {
    let mut bench = Bench::new();
    let numbers: Vec<_> = (1..n).map(|i| bench.number(&format!("n{i}"), i as f64)).collect();
    let wires: Vec<_> = numbers.iter().map(|node| ("numbers", *node, "number")).collect();
    let node = bench.add("sum", "test.add", &[], &wires);
    (bench.build(), OutputRef { node, output: 0 })
}

fn pull(evaluator: &Evaluator, graph: &Arc<Graph>, output: OutputRef) {
    let request = Request::values(Arc::clone(graph), vec![output]);
    let report = evaluator.run(request, Arc::new(Silent), &CancelToken::new());
    assert!(report.values[0].is_some());
}

/// Every node runs: an empty cache each time.
#[divan::bench(args = [1, 2])]
fn run_10000_trivial_nodes_in_a_chain(bencher: Bencher<'_, '_>, jobs: usize) {
    let (graph, output) = chain(10_000);
    bencher.with_inputs(|| in_memory(jobs)).bench_local_refs(|evaluator| pull(evaluator, &graph, output));
}

/// Every node runs, none waits for another.
#[divan::bench(args = [1, 2])]
fn run_10000_trivial_nodes_side_by_side(bencher: Bencher<'_, '_>, jobs: usize) {
    let (graph, output) = fan(10_000);
    bencher.with_inputs(|| in_memory(jobs)).bench_local_refs(|evaluator| pull(evaluator, &graph, output));
}

/// Nothing runs: the keys are made and the output is found.
#[divan::bench]
fn pull_1000_cached_nodes(bencher: Bencher<'_, '_>) {
    let (graph, output) = chain(1000);
    let evaluator = in_memory(2);
    pull(&evaluator, &graph, output);
    bencher.bench_local(|| pull(&evaluator, &graph, output));
}
