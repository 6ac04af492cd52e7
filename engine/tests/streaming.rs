//! Chains that run band by band: the same bits as node by node, and the same manners.

#![allow(clippy::unwrap_used)]

mod support;

use std::{collections::BTreeMap, fs, path::Path, sync::Arc};

use orograph_core::{Context, Digest, Error, ParamValue};
use orograph_engine::{
    Cache, CancelToken, DiskTier, Evaluator, Graph, NodeId, Outcome, OutputRef, Report, Request,
    cache::Tier,
    eval::{Event, Observer, Silent},
};
use proptest::prelude::*;
use support::{Bench, Starts};
use tempfile::TempDir;

/// Memory that holds every graph of these tests many times over.
const MUCH: u64 = 1 << 30;
/// Memory that holds each of their larger rasters once, but not four times.
const LITTLE: u64 = 40 << 10;

fn integer(value: i64) -> ParamValue {
    ParamValue::Integer(value)
}

fn text(value: &str) -> ParamValue {
    ParamValue::Text(value.into())
}

fn evaluator(memory: u64, disk: Option<&Path>) -> Evaluator {
    Evaluator::new(Cache::new(memory, disk.map(|folder| DiskTier::open(folder).unwrap())), 2).unwrap()
}

/// What a request asks for: the first outputs of these nodes, and all writers.
fn request(graph: &Arc<Graph>, outputs: &[NodeId], folder: &Path) -> Request {
    Request {
        outputs: outputs.iter().map(|&node| OutputRef { node, output: 0 }).collect(),
        writers: graph.writers().collect(),
        out_dir: folder.to_owned(),
        context: Context { seed: 7, resolution: None },
        ..Request::values(Arc::clone(graph), Vec::new())
    }
}

fn run(evaluator: &Evaluator, request: &Request) -> Report {
    evaluator.run(request.clone(), Arc::new(Silent), &CancelToken::new())
}

fn outcome<'a>(report: &'a Report, name: &str) -> &'a Outcome {
    &report.nodes.iter().find(|node| node.name == name).unwrap().outcome
}

/// The digests of the values asked for, and the content of every file.
fn results(report: &Report, folder: &Path) -> (Vec<Option<Digest>>, BTreeMap<String, Vec<u8>>) {
    let values = report.values.iter().map(|value| value.as_ref().map(|value| value.digest())).collect();
    let files = fs::read_dir(folder).into_iter().flatten().map(|entry| {
        let entry = entry.unwrap();
        (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap())
    });
    (values, files.collect())
}

/// Runs with much and with little memory, and expects the same results; the report with little.
fn same_in_bands(graph: &Arc<Graph>, outputs: &[NodeId]) -> Report {
    let (whole, bands) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let expected = run(&evaluator(MUCH, None), &request(graph, outputs, whole.path()));
    assert!(expected.nodes.iter().all(|node| node.outcome != Outcome::Streamed));
    let report = run(&evaluator(LITTLE, None), &request(graph, outputs, bands.path()));
    assert_eq!(results(&report, bands.path()), results(&expected, whole.path()));
    report
}

/// Hills, spread twice, joined with themselves, and written.
fn chain(rows: i64, fails: i64) -> (Bench, [NodeId; 4]) {
    let mut bench = Bench::new();
    let size = [("rows", integer(rows)), ("cols", integer(9)), ("fails", integer(fails))];
    let hills = bench.add("hills", "test.hills", &size, &[]);
    let spread =
        bench.add("spread", "test.spread", &[("reach", integer(5))], &[("terrain", hills, "terrain")]);
    let wide = bench.add("wide", "test.spread", &[("reach", integer(17))], &[("terrain", spread, "terrain")]);
    let inputs = [("terrains", hills, "terrain"), ("terrains", wide, "terrain")];
    let join = bench.add("join", "test.join", &[], &inputs);
    bench.add("file", "test.write_rows", &[("file", text("a.bin"))], &[("terrain", join, "terrain")]);
    (bench, [hills, spread, wide, join])
}

#[test]
fn a_chain_too_large_for_the_memory_runs_in_bands_and_gives_the_same_bytes() {
    let (bench, _) = chain(1000, 100_000);
    let report = same_in_bands(&bench.build(), &[]);
    for node in &report.nodes {
        assert_eq!((&node.outcome, node.outcome.word()), (&Outcome::Streamed, "streamed"), "{}", node.name);
        assert!(node.key.is_some() && node.outputs.is_empty());
    }
    assert_eq!(report.nodes.iter().map(|node| node.files.len()).sum::<usize>(), 1);
    assert_eq!(report.counts().computed, 5);
}

#[test]
fn what_fits_is_cached_node_by_node() {
    let (bench, _) = chain(20, 100_000);
    let report = same_in_bands(&bench.build(), &[]);
    assert!(report.nodes.iter().all(|node| node.outcome == Outcome::Computed));
}

#[test]
fn what_is_known_whole_is_not_made_again() {
    let (mut bench, [_, _, wide, join]) = chain(1000, 100_000);
    let top = bench.add("top", "test.top", &[], &[("terrain", wide, "terrain")]);
    bench.add("second", "test.write_rows", &[("file", text("b.bin"))], &[("terrain", top, "terrain")]);
    let graph = bench.build();
    let report = same_in_bands(&graph, &[join]);
    // The second section is only a file: nothing to gain.
    assert_eq!(outcome(&report, "second"), &Outcome::Computed);
    let folder = TempDir::new().unwrap();
    let cache = folder.path().join("cache");
    let out = folder.path().join("out");
    let first = run(&evaluator(LITTLE, Some(&cache)), &request(&graph, &[join], &out));
    assert_eq!(outcome(&first, "join"), &Outcome::Streamed);
    let again = run(&evaluator(LITTLE, Some(&cache)), &request(&graph, &[join], &out));
    for node in &again.nodes {
        assert_eq!(node.outcome, Outcome::Hit(Tier::Disk), "{}", node.name);
    }
    assert_eq!(results(&again, &out), results(&first, &out));
    // With the file gone only what leads to it runs, from the value that is known.
    fs::remove_file(out.join("a.bin")).unwrap();
    let third = run(&evaluator(LITTLE, Some(&cache)), &request(&graph, &[], &out));
    assert_eq!(outcome(&third, "file"), &Outcome::Computed);
    assert!(third.nodes.iter().all(|node| node.name != "hills"), "nobody looked at the hills");
    assert_eq!(results(&third, &out).1, results(&first, &out).1);
}

#[test]
fn an_error_names_its_node_and_row_and_stops_only_what_needs_it() {
    let (mut bench, [_, spread, ..]) = chain(1000, 777);
    let size = [("rows", integer(1000)), ("cols", integer(9))];
    let sound = bench.add("sound", "test.hills", &size, &[]);
    let more = bench.add("more", "test.spread", &[], &[("terrain", sound, "terrain")]);
    bench.add("other", "test.write_rows", &[("file", text("b.bin"))], &[("terrain", more, "terrain")]);
    let joined = [("terrains", more, "terrain"), ("terrains", spread, "terrain")];
    let both = bench.add("both", "test.join", &[], &joined);
    bench.add("third", "test.write_rows", &[("file", text("c.bin"))], &[("terrain", both, "terrain")]);
    let graph = bench.build();
    let folder = TempDir::new().unwrap();
    let report = run(&evaluator(LITTLE, None), &request(&graph, &[], folder.path()));
    let failed = Error::NonFinite { what: "hills".into(), row: 777, col: 0 };
    assert_eq!(outcome(&report, "hills"), &Outcome::Failed(failed));
    for name in ["spread", "wide", "join", "file", "both", "third"] {
        assert_eq!(outcome(&report, name), &Outcome::Skipped { because: "hills".into() }, "{name}");
    }
    for name in ["sound", "more", "other"] {
        assert_eq!(outcome(&report, name), &Outcome::Streamed, "{name}");
    }
    let (_, files) = results(&report, folder.path());
    assert_eq!(files.keys().collect::<Vec<_>>(), ["b.bin"], "no torn file, and the sound one is there");
}

#[test]
fn a_file_that_cannot_be_begun_stops_no_other() {
    let (mut bench, [.., join]) = chain(1000, 100_000);
    bench.add("second", "test.write_rows", &[("file", text("b.bin"))], &[("terrain", join, "terrain")]);
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("a.bin")).unwrap();
    let report = run(&evaluator(LITTLE, None), &request(&bench.build(), &[], folder.path()));
    assert!(matches!(outcome(&report, "file"), Outcome::Failed(Error::Io { .. })));
    assert_eq!(outcome(&report, "second"), &Outcome::Streamed);
    assert!(folder.path().join("b.bin").is_file());
}

#[test]
fn rasters_of_several_sizes_fail_as_they_do_whole() {
    let (mut bench, [.., wide, _]) = chain(1000, 100_000);
    let small = bench.add("small", "test.hills", &[("rows", integer(900))], &[]);
    let joined = [("terrains", small, "terrain"), ("terrains", wide, "terrain")];
    let unlike = bench.add("unlike", "test.join", &[], &joined);
    bench.add("never", "test.write_rows", &[("file", text("b.bin"))], &[("terrain", unlike, "terrain")]);
    let graph = bench.build();
    let report = same_in_bands(&graph, &[]);
    assert!(matches!(outcome(&report, "unlike"), Outcome::Failed(Error::DimensionMismatch { .. })));
    assert_eq!(outcome(&report, "file"), &Outcome::Streamed);
}

#[test]
fn every_node_of_a_chain_is_told_of() {
    let (mut bench, [_, spread, ..]) = chain(1000, 100_000);
    let inputs = [("terrain", spread, "terrain")];
    let high = bench.add("high", "test.spread", &[("remarkable", ParamValue::Number(0.9))], &inputs);
    bench.add("second", "test.write_rows", &[("file", text("b.bin"))], &[("terrain", high, "terrain")]);
    let graph = bench.build();
    let folder = TempDir::new().unwrap();
    let starts = Arc::new(Starts::default());
    let report = evaluator(LITTLE, None).run(
        request(&graph, &[], folder.path()),
        Arc::clone(&starts) as _,
        &CancelToken::new(),
    );
    assert_eq!(starts.count(), 7);
    for node in &report.nodes {
        let expected: &[String] = if node.name == "high" { &["it is high".into()] } else { &[] };
        assert_eq!(node.warnings, expected, "{}", node.name);
    }
}

/// Cancels when the run is half done.
struct Canceller(CancelToken);

impl Observer for Canceller {
    fn event(&self, event: &Event<'_>) {
        if matches!(event, Event::Progress { done, .. } if *done > 0.5) {
            self.0.cancel();
        }
    }
}

#[test]
fn a_chain_that_is_cancelled_leaves_nothing() {
    let (bench, _) = chain(4000, 100_000);
    let (folder, cancel) = (TempDir::new().unwrap(), CancelToken::new());
    let observer = Arc::new(Canceller(cancel.clone()));
    let report = evaluator(LITTLE, None).run(request(&bench.build(), &[], folder.path()), observer, &cancel);
    assert!(report.was_cancelled());
    assert!(results(&report, folder.path()).1.is_empty());
}

/// A graph made by lot: for each node its kind and which earlier nodes it takes.
fn graph_of(plan: &[(u8, usize, usize, i64)], rows: i64) -> (Arc<Graph>, Vec<NodeId>) {
    let mut bench = Bench::new();
    let size = |step: i64| [("rows", integer(rows)), ("cols", integer(5)), ("step", integer(step))];
    let more = bench.number("more", 0.25);
    let mut nodes = vec![bench.add("first", "test.hills", &size(1), &[])];
    for (index, &(kind, a, b, number)) in plan.iter().enumerate() {
        let (a, b) = (nodes[a % nodes.len()], nodes[b % nodes.len()]);
        let name = format!("n{index}");
        let from = [("terrain", a, "terrain")];
        nodes.push(match kind {
            0 => bench.add(&name, "test.hills", &size(1 + number * 7), &[]),
            1..=3 => bench.add(&name, "test.spread", &[("reach", integer(number))], &from),
            4 => bench.add(&name, "test.top", &[], &from),
            5 => {
                bench.add(&name, "test.write_rows", &[("file", text(&name))], &from);
                continue;
            }
            _ => {
                let inputs =
                    [("terrains", a, "terrain"), ("terrains", b, "terrain"), ("more", more, "number")];
                bench.add(&name, "test.join", &[], &inputs)
            }
        });
    }
    (bench.build(), nodes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_graph_gives_the_same_results_in_bands(
        plan in prop::collection::vec((0u8..8, 0usize..100, 0usize..100, 0i64..20), 1..14),
        rows in 900i64..1500,
        wanted in prop::collection::vec(0usize..100, 0..3),
    ) {
        let (graph, nodes) = graph_of(&plan, rows);
        let outputs: Vec<_> = wanted.iter().map(|node| nodes[node % nodes.len()]).collect();
        same_in_bands(&graph, &outputs);
    }
}
