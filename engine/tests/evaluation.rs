//! What evaluation promises: lazy, cached, cut off early, one computation per key, cancellable, fenced.

mod support;

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use orograph_core::{Context, Error, ParamValue, Value};
use orograph_engine::{
    Cache, CancelToken, DiskTier, Evaluator, Graph, NodeId, Outcome, OutputRef, Report, Request, cache::Tier,
    eval::Silent,
};
use support::{Bench, Starts, in_memory, on_disk};

fn output(node: NodeId) -> OutputRef {
    OutputRef { node, output: 0 }
}

fn pull(evaluator: &Evaluator, graph: &Arc<Graph>, nodes: &[NodeId]) -> Report {
    let request = Request::values(Arc::clone(graph), nodes.iter().map(|node| output(*node)).collect());
    evaluator.run(request, Arc::new(Silent), &CancelToken::new())
}

fn pull_counting(
    evaluator: &Evaluator,
    graph: &Arc<Graph>,
    nodes: &[NodeId],
    starts: &Arc<Starts>,
) -> Report {
    let request = Request::values(Arc::clone(graph), nodes.iter().map(|node| output(*node)).collect());
    evaluator.run(request, Arc::clone(starts) as _, &CancelToken::new())
}

fn number(report: &Report, index: usize) -> f64 {
    match report.values[index] {
        Some(Value::Number(x)) => x,
        ref other => panic!("no number but {other:?}"),
    }
}

fn outcome<'a>(report: &'a Report, name: &str) -> Option<&'a Outcome> {
    report.nodes.iter().find(|node| node.name == name).map(|node| &node.outcome)
}

#[test]
fn only_what_is_asked_for_is_computed_and_nothing_twice() {
    let mut bench = Bench::new();
    let a = bench.number("a", 2.0);
    let b = bench.number("b", 3.0);
    let sum = bench.add("sum", "test.add", &[], &[("numbers", a, "number"), ("numbers", b, "number")]);
    bench.add("other", "test.trouble", &[], &[]);
    let graph = bench.build();
    let evaluator = in_memory(2);
    let report = pull(&evaluator, &graph, &[sum]);
    assert_eq!(number(&report, 0), 5.0);
    assert_eq!(report.counts().computed, 3);
    assert_eq!(outcome(&report, "other"), None, "what nobody needs is not touched");
    let again = pull(&evaluator, &graph, &[sum]);
    assert_eq!(number(&again, 0), 5.0);
    assert_eq!(outcome(&again, "sum"), Some(&Outcome::Hit(Tier::Memory)));
    assert_eq!(outcome(&again, "a"), None, "a hit ends the walk");
}

#[test]
fn an_equal_input_cuts_off_what_follows() {
    let build = |value: f64| {
        let mut bench = Bench::new();
        let a = bench.number("a", value);
        let floor = bench.add("floor", "test.floor", &[], &[("number", a, "number")]);
        let sum = bench.add("sum", "test.add", &[], &[("numbers", floor, "number")]);
        (bench.build(), sum)
    };
    let evaluator = in_memory(2);
    let (graph, sum) = build(2.25);
    pull(&evaluator, &graph, &[sum]);
    let (graph, sum) = build(2.75);
    let report = pull(&evaluator, &graph, &[sum]);
    assert_eq!(number(&report, 0), 2.0);
    assert_eq!(outcome(&report, "floor"), Some(&Outcome::Computed));
    assert_eq!(outcome(&report, "sum"), Some(&Outcome::Cutoff(Tier::Memory)));
    // The recipe is known from now on.
    assert_eq!(outcome(&pull(&evaluator, &graph, &[sum]), "sum"), Some(&Outcome::Hit(Tier::Memory)));
}

#[test]
fn two_nodes_with_one_key_compute_once() {
    let mut bench = Bench::new();
    let a = bench.number("a", 7.5);
    let twins: Vec<_> = (0..50)
        .map(|i| bench.add(&format!("floor{i}"), "test.floor", &[], &[("number", a, "number")]))
        .collect();
    let graph = bench.build();
    let starts = Arc::new(Starts::default());
    let report = pull_counting(&in_memory(8), &graph, &twins, &starts);
    assert_eq!(starts.count(), 2, "the number and one of the twins");
    assert_eq!(report.counts().computed, 2);
    assert!((0..50).all(|i| number(&report, i) == 7.0));
}

#[test]
fn concurrent_runs_share_one_computation() {
    let mut bench = Bench::new();
    let field = bench.add("field", "test.field", &[("cells", ParamValue::Integer(2000))], &[]);
    let raised = bench.add("raised", "test.raise", &[], &[("terrain", field, "terrain")]);
    let graph = bench.build();
    let evaluator = in_memory(4);
    let starts = Arc::new(Starts::default());
    std::thread::scope(|scope| {
        for _ in 0..6 {
            scope.spawn(|| {
                let report = pull_counting(&evaluator, &graph, &[raised], &starts);
                assert!(report.values[0].is_some());
            });
        }
    });
    assert_eq!(starts.count(), 2, "the field and its raising, once for all");
}

#[test]
fn errors_reach_everyone_and_are_never_cached() {
    let mut bench = Bench::new();
    let bad = bench.add("bad", "test.trouble", &[], &[]);
    let sum = bench.add("sum", "test.add", &[], &[("numbers", bad, "number")]);
    let good = bench.number("good", 1.0);
    let graph = bench.build();
    let evaluator = in_memory(2);
    for _ in 0..2 {
        let report = pull(&evaluator, &graph, &[sum, good]);
        assert!(matches!(outcome(&report, "bad"), Some(Outcome::Failed(Error::Invalid { .. }))));
        assert_eq!(outcome(&report, "sum"), Some(&Outcome::Skipped { because: "bad".into() }));
        assert_eq!(number(&report, 1), 1.0, "what does not depend on it is computed");
    }
}

#[test]
fn a_panic_is_that_nodes_error() {
    let mut bench = Bench::new();
    let bad = bench.add("bad", "test.trouble", &[("kind", ParamValue::Text("panic".into()))], &[]);
    let graph = bench.build();
    let report = pull(&in_memory(2), &graph, &[bad]);
    let expected = Outcome::Failed(Error::Panicked { message: "as it was told to".into() });
    assert_eq!(outcome(&report, "bad"), Some(&expected));
}

#[test]
fn cancelling_takes_effect_within_a_tenth_of_a_second() {
    let mut bench = Bench::new();
    let wait = bench.add("wait", "test.trouble", &[("kind", ParamValue::Text("wait".into()))], &[]);
    let sum = bench.add("sum", "test.add", &[], &[("numbers", wait, "number")]);
    let graph = bench.build();
    let evaluator = in_memory(2);
    let cancel = CancelToken::new();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| {
            evaluator.run(Request::values(Arc::clone(&graph), vec![output(sum)]), Arc::new(Silent), &cancel)
        });
        std::thread::sleep(Duration::from_millis(50));
        let asked = Instant::now();
        cancel.cancel();
        let report = run.join().unwrap();
        assert!(asked.elapsed() < Duration::from_millis(500), "took {:?}", asked.elapsed());
        assert!(report.was_cancelled());
    });
}

#[test]
fn undeclared_context_does_not_enter_a_key() {
    let mut bench = Bench::new();
    let a = bench.number("a", 1.0);
    let field = bench.add("field", "test.field", &[], &[]);
    let graph = bench.build();
    let evaluator = in_memory(2);
    let run = |seed| {
        let mut request = Request::values(Arc::clone(&graph), vec![output(a), output(field)]);
        request.context = Context { seed, resolution: Some(64) };
        evaluator.run(request, Arc::new(Silent), &CancelToken::new())
    };
    run(1);
    let report = run(2);
    assert_eq!(outcome(&report, "a"), Some(&Outcome::Hit(Tier::Memory)));
    assert_eq!(outcome(&report, "field"), Some(&Outcome::Computed));
}

/// field → raise → … → raise, each by another height.
fn chain(n: usize, cells: i64, last: f64) -> (Arc<Graph>, NodeId) {
    let mut bench = Bench::new();
    let mut node = bench.add("field", "test.field", &[("cells", ParamValue::Integer(cells))], &[]);
    for i in 0..n {
        let by = if i + 1 == n { last } else { i as f64 };
        let by = [("by", ParamValue::Number(by))];
        node = bench.add(&format!("raise{i}"), "test.raise", &by, &[("terrain", node, "terrain")]);
    }
    (bench.build(), node)
}

fn height(report: &Report) -> f32 {
    match &report.values[0] {
        Some(Value::Heightfield(field)) => field.at(0, 0),
        other => panic!("no field but {other:?}"),
    }
}

#[test]
fn a_new_process_recomputes_nothing_and_a_changed_last_node_exactly_one() {
    let folder = tempfile::tempdir().unwrap();
    let (graph, end) = chain(5, 64, 100.0);
    let first = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
    assert_eq!(first.counts().computed, 6);
    let second = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
    assert_eq!((second.counts().computed, second.counts().hits), (0, 1));
    assert_eq!(height(&second), height(&first));
    let (graph, end) = chain(5, 64, 200.0);
    let third = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
    assert_eq!(third.counts().computed, 1);
    assert_eq!(height(&third), height(&first) + 100.0);
}

#[test]
fn large_values_from_disk_reach_many_nodes_at_once() {
    // Such a value is checked on the whole pool; a thread that holds a lock meanwhile can be asked for it again by
    // what it takes up while it waits.
    let graph = |by: f64| {
        let mut bench = Bench::new();
        let ends: Vec<_> = (0..16)
            .map(|i| {
                let look =
                    [("cells", ParamValue::Integer(400)), ("height", ParamValue::Number(f64::from(i)))];
                let field = bench.add(&format!("field{i}"), "test.field", &look, &[]);
                let by = [("by", ParamValue::Number(by))];
                bench.add(&format!("raise{i}"), "test.raise", &by, &[("terrain", field, "terrain")])
            })
            .collect();
        (bench.build(), ends)
    };
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().to_owned();
    let (done, told) = std::sync::mpsc::channel();
    // Not joined: where it is stuck, the test is to fail and not to wait.
    std::thread::spawn(move || {
        for run in 0..40 {
            let (graph, ends) = graph(f64::from(run));
            let cache = Cache::new(1 << 30, Some(DiskTier::open(&root).unwrap()));
            let report = pull(&Evaluator::new(cache, 4).unwrap(), &graph, &ends);
            let _ = done.send(report.counts().computed);
        }
    });
    for run in 0..40 {
        let computed =
            told.recv_timeout(Duration::from_secs(60)).unwrap_or_else(|_| panic!("run {run} is stuck"));
        assert_eq!(computed, if run == 0 { 32 } else { 16 }, "the fields come from disk");
    }
}

#[test]
fn a_tiny_memory_budget_changes_no_result() {
    let folder = tempfile::tempdir().unwrap();
    let (graph, end) = chain(6, 100, 9.0);
    let expected = height(&pull(&in_memory(1), &graph, &[end]));
    // Room for one field of 40 kB, so that everything else must leave.
    for jobs in [1, 2, 8] {
        let evaluator = Evaluator::new(orograph_engine::Cache::new(50_000, None), jobs).unwrap();
        assert_eq!(height(&pull(&evaluator, &graph, &[end])), expected);
        assert!(evaluator.cache().memory_bytes() <= 50_000);
    }
    assert_eq!(height(&pull(&on_disk(folder.path(), 50_000), &graph, &[end])), expected);
}

#[test]
fn damaged_cache_entries_are_recomputed() {
    fn damage(folder: &std::path::Path, shelf: &str, how: &dyn Fn(&mut Vec<u8>)) -> usize {
        let mut n = 0;
        for bucket in std::fs::read_dir(folder.join("v1").join(shelf)).unwrap() {
            for file in std::fs::read_dir(bucket.unwrap().path()).unwrap() {
                let path = file.unwrap().path();
                let mut bytes = std::fs::read(&path).unwrap();
                how(&mut bytes);
                std::fs::write(&path, bytes).unwrap();
                n += 1;
            }
        }
        n
    }
    let (graph, end) = chain(3, 64, 9.0);
    let expected = height(&pull(&in_memory(1), &graph, &[end]));
    type Damage = (&'static str, &'static dyn Fn(&mut Vec<u8>));
    let damages: [Damage; 7] = [
        ("values", &|bytes| bytes.truncate(bytes.len() / 2)),
        ("values", &|bytes| bytes.clear()),
        ("values", &|bytes| *bytes.last_mut().unwrap() ^= 1),
        ("values", &|bytes| bytes[7] = b'9'),
        ("records", &|bytes| bytes.truncate(20)),
        ("records", &|bytes| bytes[60] ^= 0x40),
        ("records", &|bytes| bytes[7] = b'9'),
    ];
    for (shelf, how) in damages {
        let folder = tempfile::tempdir().unwrap();
        pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
        assert!(damage(folder.path(), shelf, how) > 0);
        let report = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
        assert_eq!(height(&report), expected);
        assert!(report.counts().computed > 0, "{shelf}");
        let healed = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
        assert_eq!(healed.counts().computed, 0, "{shelf}: the entries were written anew");
    }
}

#[test]
fn swapped_cache_entries_are_recomputed() {
    let folder = tempfile::tempdir().unwrap();
    let (graph, end) = chain(3, 64, 9.0);
    let expected = height(&pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]));
    for shelf in ["values", "records"] {
        let mut files: Vec<_> = std::fs::read_dir(folder.path().join("v1").join(shelf))
            .unwrap()
            .flat_map(|bucket| std::fs::read_dir(bucket.unwrap().path()).unwrap())
            .map(|file| file.unwrap().path())
            .collect();
        files.sort();
        let contents: Vec<_> = files.iter().map(|file| std::fs::read(file).unwrap()).collect();
        for (i, file) in files.iter().enumerate() {
            std::fs::write(file, &contents[(i + 1) % files.len()]).unwrap();
        }
        let report = pull(&on_disk(folder.path(), 1 << 30), &graph, &[end]);
        assert_eq!(height(&report), expected, "{shelf}");
        assert!(report.counts().computed > 0, "{shelf}");
    }
}

#[test]
fn a_cache_folder_that_cannot_be_written_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let (graph, end) = chain(3, 64, 9.0);
    let evaluator = on_disk(folder.path(), 1 << 30);
    // A file where a folder is needed stops every write, whoever runs the test.
    std::fs::remove_dir_all(folder.path().join("v1")).unwrap();
    std::fs::write(folder.path().join("v1"), "in the way").unwrap();
    let report = pull(&evaluator, &graph, &[end]);
    assert_eq!(report.counts().computed, 4);
    evaluator.flush();
    assert!(evaluator.cache().take_disk_failure().is_some(), "the user is told once");
    assert!(evaluator.cache().take_disk_failure().is_none());
}

#[test]
fn writers_write_whole_files_and_only_when_needed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = tempfile::tempdir().unwrap();
    let graph = |fail: bool, height: f64| {
        let mut bench = Bench::new();
        let field = bench.add("field", "test.field", &[("height", ParamValue::Number(height))], &[]);
        let params = [("file", ParamValue::Text("maps/a.bin".into())), ("fail", ParamValue::Boolean(fail))];
        let write = bench.add("write", "test.write", &params, &[("terrain", field, "terrain")]);
        (bench.build(), write)
    };
    let run = |fail: bool, height: f64| {
        let (graph, write) = graph(fail, height);
        let mut request = Request::values(graph, vec![]);
        request.writers = vec![write];
        request.out_dir = folder.path().join("out");
        on_disk(cache.path(), 1 << 30).run(request, Arc::new(Silent), &CancelToken::new())
    };
    let path = folder.path().join("out/maps/a.bin");
    let report = run(true, 1.0);
    assert_eq!(report.counts().failed, 1);
    assert!(!path.exists());
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 0, "nothing half-written is left");
    assert_eq!(outcome(&run(false, 1.0), "write"), Some(&Outcome::Computed));
    assert_eq!(std::fs::read(&path).unwrap().len(), 16 * 16 * 4);
    assert_eq!(outcome(&run(false, 1.0), "write"), Some(&Outcome::Hit(Tier::Disk)), "the file is up to date");
    std::fs::write(&path, "touched").unwrap();
    assert_eq!(
        outcome(&run(false, 1.0), "write"),
        Some(&Outcome::Computed),
        "a changed file is written again"
    );
    // A failure leaves the earlier file as it was.
    run(true, 2.0);
    assert_eq!(std::fs::read(&path).unwrap().len(), 16 * 16 * 4);
}

#[cfg(unix)]
#[test]
fn no_link_leads_out_of_the_output_folder() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path(), folder.path().join("out/maps")).unwrap();
    let mut bench = Bench::new();
    let field = bench.add("field", "test.field", &[], &[]);
    let params = [("file", ParamValue::Text("maps/a.bin".into()))];
    let write = bench.add("write", "test.write", &params, &[("terrain", field, "terrain")]);
    let mut request = Request::values(bench.build(), vec![]);
    request.writers = vec![write];
    request.out_dir = folder.path().join("out");
    let report = in_memory(1).run(request, Arc::new(Silent), &CancelToken::new());
    assert!(matches!(outcome(&report, "write"), Some(Outcome::Failed(Error::Io { .. }))));
    assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0);
}

#[test]
fn a_files_content_counts_and_its_folder_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let evaluator = in_memory(1);
    let length = |path: &std::path::Path| {
        let mut bench = Bench::new();
        let file = [("file", ParamValue::Text(path.display().to_string()))];
        let node = bench.add("length", "test.length", &file, &[]);
        let graph = bench.build();
        pull(&evaluator, &graph, &[node])
    };
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    std::fs::create_dir(&a).unwrap();
    std::fs::create_dir(&b).unwrap();
    std::fs::write(a.join("dem.bin"), "1234").unwrap();
    std::fs::write(b.join("dem.bin"), "1234").unwrap();
    assert_eq!(number(&length(&a.join("dem.bin")), 0), 4.0);
    assert_eq!(length(&b.join("dem.bin")).counts().computed, 0, "equal content under another path");
    std::fs::write(a.join("dem.bin"), "12345").unwrap();
    assert_eq!(number(&length(&a.join("dem.bin")), 0), 5.0);
    let missing = length(&a.join("none.bin"));
    assert!(matches!(outcome(&missing, "length"), Some(Outcome::Failed(Error::Io { .. }))));
}

#[test]
fn a_run_explains_itself() {
    let folder = tempfile::tempdir().unwrap();
    let run = |seed: u64, by: f64| {
        let (graph, end) = chain(2, 8, by);
        let mut request = Request::values(graph, vec![output(end)]);
        request.context.seed = seed;
        request.history = Some("chain".into());
        on_disk(folder.path(), 1 << 30).run(request, Arc::new(Silent), &CancelToken::new())
    };
    let reason = |report: &Report, name: &str| {
        report.nodes.iter().find(|node| node.name == name).and_then(|node| node.reason.clone()).unwrap()
    };
    assert!(reason(&run(0, 5.0), "raise1").contains("first run"));
    assert_eq!(reason(&run(0, 6.5), "raise1"), "`by` changed from 5 to 6.5");
    let report = run(3, 6.5);
    assert_eq!(reason(&report, "field"), "the run's seed changed from 0 to 3");
    assert_eq!(reason(&report, "raise1"), "its input `terrain` changed (raise0.terrain)");
}
