//! Runs that want the same computation: shared, and stopped only when nobody wants it any more.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread::{self, Scope, ScopedJoinHandle},
    time::{Duration, Instant},
};

use orograph_core::{Error, ParamValue, Value};
use orograph_engine::{
    CancelToken, Evaluator, Graph, NodeId, Observer, Outcome, OutputRef, Report, Request, eval::Event,
};
use support::{Bench, SLOW, in_memory};

/// A cancelled run is to be back within a tenth of a second; a busy machine gets some more.
const SOON: Duration = Duration::from_millis(600);

/// Hears how a run goes.
#[derive(Default)]
struct Ear {
    started: AtomicUsize,
    progress: AtomicUsize,
    finished: Mutex<Vec<(String, Outcome)>>,
}

impl Observer for Ear {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Started { .. } => self.started.fetch_add(1, Ordering::SeqCst),
            Event::Progress { .. } => self.progress.fetch_add(1, Ordering::SeqCst),
            Event::Finished { node, outcome, .. } => {
                self.finished.lock().unwrap().push(((*node).to_owned(), (*outcome).clone()));
                0
            }
            Event::Note { .. } => 0,
        };
    }
}

/// Cancels when it is dropped, so that a test that fails does not wait for what it began.
struct Cancelling(CancelToken);

impl Drop for Cancelling {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// One run of a graph's end, beside others.
struct Running<'scope> {
    ear: Arc<Ear>,
    cancel: Cancelling,
    report: ScopedJoinHandle<'scope, (Report, Instant)>,
}

impl<'scope> Running<'scope> {
    fn begin(
        scope: &'scope Scope<'scope, '_>,
        evaluator: &'scope Evaluator,
        (graph, end): &(Arc<Graph>, NodeId),
    ) -> Self {
        let (ear, cancel) = (Arc::new(Ear::default()), CancelToken::new());
        let request = Request::values(Arc::clone(graph), vec![OutputRef { node: *end, output: 0 }]);
        let (observer, token) = (Arc::clone(&ear), cancel.clone());
        let report = scope.spawn(move || (evaluator.run(request, observer, &token), Instant::now()));
        Self { ear, cancel: Cancelling(cancel), report }
    }

    /// Waits until the run hears that its node gets on, here or in another run.
    fn hears(&self) {
        wait_until("progress is heard", || self.ear.progress.load(Ordering::SeqCst) > 0);
    }

    /// Cancels the run, which must then be over soon, and gives its report.
    fn cancelled(self) -> Report {
        let asked = Instant::now();
        self.cancel.0.cancel();
        let (report, over) = self.report.join().unwrap();
        assert!(over - asked < SOON, "a cancelled run took {:?}", over - asked);
        assert!(report.was_cancelled());
        report
    }

    fn number(self) -> f64 {
        let (report, _) = self.report.join().unwrap();
        match report.values[0] {
            Some(Value::Number(number)) => number,
            ref other => panic!("no number but {other:?}: {:?}", report.nodes),
        }
    }
}

fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(20), "waited too long until {what}");
        thread::sleep(Duration::from_millis(1));
    }
}

fn count(count: usize) -> (usize, usize) {
    (SLOW[count].0.load(Ordering::SeqCst), SLOW[count].1.load(Ordering::SeqCst))
}

/// A slow node, and `more` than its number.
fn slow(count: usize, millis: i64, number: f64, more: f64) -> (Arc<Graph>, NodeId) {
    let mut bench = Bench::new();
    let params = [
        ("count", ParamValue::Integer(count as i64)),
        ("millis", ParamValue::Integer(millis)),
        ("number", ParamValue::Number(number)),
    ];
    let slow = bench.add("slow", "test.slow", &params, &[]);
    let more = [("more", ParamValue::Number(more))];
    let end = bench.add("end", "test.add", &more, &[("numbers", slow, "number")]);
    (bench.build(), end)
}

#[test]
fn a_node_that_another_run_waits_for_outlives_the_run_that_began_it() {
    for jobs in [1, 4] {
        let evaluator = in_memory(jobs);
        thread::scope(|scope| {
            let millis = 1500;
            let before = count(0).0;
            let begun = Instant::now();
            let first = Running::begin(scope, &evaluator, &slow(0, millis, jobs as f64, 1.0));
            first.hears();
            let second = Running::begin(scope, &evaluator, &slow(0, millis, jobs as f64, 2.0));
            second.hears();
            let heard = Arc::clone(&first.ear);
            let report = first.cancelled();
            assert!(begun.elapsed() < Duration::from_millis(millis as u64), "the node was to run on");
            assert_eq!(report.counts().computed, 0);
            assert_eq!(
                *heard.finished.lock().unwrap(),
                [
                    ("slow".to_owned(), Outcome::Failed(Error::Cancelled)),
                    ("end".to_owned(), Outcome::Skipped { because: "slow".into() }),
                ]
            );
            thread::sleep(Duration::from_millis(20));
            let told = heard.progress.load(Ordering::SeqCst);
            // A third one may come, and go.
            let third = Running::begin(scope, &evaluator, &slow(0, millis, jobs as f64, 3.0));
            third.hears();
            third.cancelled();
            assert_eq!(second.number(), jobs as f64 + 2.0);
            assert_eq!(count(0).0 - before, 1, "it ran once");
            assert_eq!(heard.progress.load(Ordering::SeqCst), told, "who left hears no more of it");
            let again = Running::begin(scope, &evaluator, &slow(0, millis, jobs as f64, 1.0));
            assert_eq!(again.number(), jobs as f64 + 1.0);
            assert_eq!(count(0).0 - before, 1, "what came of it was kept");
        });
    }
}

#[test]
fn a_node_stops_when_every_run_that_wants_it_is_cancelled() {
    for first_goes_first in [true, false] {
        let evaluator = in_memory(2);
        thread::scope(|scope| {
            let graph = slow(1, 600_000, 0.0, 0.0);
            let before = count(1).0;
            let first = Running::begin(scope, &evaluator, &graph);
            first.hears();
            let second = Running::begin(scope, &evaluator, &graph);
            second.hears();
            let (one, other) = if first_goes_first { (first, second) } else { (second, first) };
            one.cancelled();
            thread::sleep(Duration::from_millis(50));
            assert_eq!((count(1).0 - before, count(1).1), (1, 1), "one run wants it still");
            let asked = Instant::now();
            other.cancelled();
            wait_until("the node has stopped", || count(1).1 == 0);
            assert!(asked.elapsed() < SOON, "{:?}", asked.elapsed());
        });
    }
}

#[test]
fn the_work_of_others_holds_no_cancelled_run_up() {
    // Its only thread is busy with what another run wants, and more of its nodes could run.
    let evaluator = in_memory(1);
    thread::scope(|scope| {
        let mut bench = Bench::new();
        let mut inputs = Vec::new();
        for number in [2.0, 1.0] {
            let params = [
                ("count", ParamValue::Integer(2)),
                ("millis", ParamValue::Integer(1000)),
                ("number", ParamValue::Number(number)),
            ];
            inputs.push((
                "numbers",
                bench.add(&format!("slow{number}"), "test.slow", &params, &[]),
                "number",
            ));
        }
        let end = bench.add("end", "test.add", &[], &inputs);
        let first = Running::begin(scope, &evaluator, &(bench.build(), end));
        first.hears();
        // The last node that became ready runs first.
        let second = Running::begin(scope, &evaluator, &slow(2, 1000, 1.0, 0.0));
        let third = Running::begin(scope, &evaluator, &slow(2, 1000, 2.0, 0.0));
        wait_until("one of them hears", || {
            [&second, &third].iter().any(|run| run.ear.progress.load(Ordering::SeqCst) > 0)
        });
        first.cancelled();
        assert_eq!((second.number(), third.number()), (1.0, 2.0));
        assert_eq!(count(2).0, 2);
    });
}

/// The sum of two slow nodes, and `more`.
fn two_slow(number: f64, more: f64) -> (Arc<Graph>, NodeId) {
    let mut bench = Bench::new();
    let mut inputs = Vec::new();
    for (name, millis, number) in [("long", 5, number), ("short", 2, number + 1e6)] {
        let params = [
            ("count", ParamValue::Integer(3)),
            ("millis", ParamValue::Integer(millis)),
            ("number", ParamValue::Number(number)),
        ];
        inputs.push(("numbers", bench.add(name, "test.slow", &params, &[]), "number"));
    }
    let end = bench.add("end", "test.add", &[("more", ParamValue::Number(more))], &inputs);
    (bench.build(), end)
}

#[test]
fn a_run_that_no_thread_has_come_to_is_over_as_soon() {
    let evaluator = in_memory(1);
    thread::scope(|scope| {
        let busy = Running::begin(scope, &evaluator, &slow(4, 600_000, 1.0, 0.0));
        busy.hears();
        let waiting = Running::begin(scope, &evaluator, &slow(4, 0, 2.0, 0.0));
        thread::sleep(Duration::from_millis(50));
        waiting.cancelled();
        busy.cancelled();
        assert_eq!(count(4).0, 1);
        // The thread serves others again.
        assert_eq!(Running::begin(scope, &evaluator, &slow(4, 0, 3.0, 0.0)).number(), 3.0);
    });
}

#[test]
fn no_order_of_cancellations_loses_a_value_or_hangs() {
    // Which runs are cancelled, and when, in an order that is the same each time.
    let mut state = 1_u64;
    let mut next = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    let evaluators = [1, 2, 4].map(in_memory);
    for round in 0..180 {
        let number = f64::from(round);
        let plan: Vec<_> = (0..5).map(|_| (next(6), next(3) > 0, next(10))).collect();
        let (evaluator, plan) = (&evaluators[round as usize % 3], &plan);
        thread::scope(|scope| {
            let runs: Vec<_> = plan
                .iter()
                .enumerate()
                .map(|(run, &(delay, is_cancelled, after))| {
                    scope.spawn(move || {
                        thread::sleep(Duration::from_millis(delay));
                        let (graph, end) = two_slow(number, run as f64);
                        let request = Request::values(graph, vec![OutputRef { node: end, output: 0 }]);
                        let cancel = CancelToken::new();
                        thread::scope(|scope| {
                            if is_cancelled {
                                scope.spawn(|| {
                                    thread::sleep(Duration::from_millis(after));
                                    cancel.cancel();
                                });
                            }
                            evaluator.run(request, Arc::new(Ear::default()), &cancel)
                        })
                    })
                })
                .collect();
            for (run, handle) in runs.into_iter().enumerate() {
                let report = handle.join().unwrap();
                match &report.values[0] {
                    Some(Value::Number(value)) => assert_eq!(*value, 2.0 * number + 1e6 + run as f64),
                    None if plan[run].1 => assert!(report.was_cancelled()),
                    other => panic!("run {run} of round {round} gives {other:?}"),
                }
            }
        });
    }
    wait_until("nothing runs", || count(3).1 == 0);
}
