//! How long every node goes on after it was told to stop: `cargo bench -p orograph-nodes --bench cancel`.
//!
//! Each node that needs no file runs once to its end, with its default settings on terrain of 1024² cells, and then
//! again, stopped at several shares of that time. The longest that it went on is told, the slowest nodes first. A word
//! on the command line that names nodes limits it to them, a number sets the terrain's cells on a side.

#![expect(clippy::print_stdout, reason = "a benchmark's whole purpose")]

mod host;

use std::{
    env,
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use host::Nowhere;
use orograph_contract::inputs_of;
use orograph_core::{Context, Error, Job, NodeType, ParamKind};

const SHARES: [f64; 8] = [0.05, 0.15, 0.3, 0.45, 0.6, 0.75, 0.88, 0.96];
/// Nodes that take less than this are not stopped by a hand.
const SHORT: Duration = Duration::from_millis(50);
/// What the design promises.
const BAR: Duration = Duration::from_millis(100);

fn main() {
    let words: Vec<String> = env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let side = words.iter().find_map(|word| word.parse().ok()).unwrap_or(1024);
    let names: Vec<&String> = words.iter().filter(|word| word.parse::<usize>().is_err()).collect();
    let mut rows = Vec::new();
    for node in orograph_nodes::all() {
        let id = node.spec().id.to_string();
        let reads = node.spec().params.iter().any(|param| matches!(param.kind, ParamKind::InputPath));
        if reads || !(names.is_empty() || names.iter().any(|name| id.contains(name.as_str()))) {
            continue;
        }
        if let Some((whole, latency)) = stopped(&node, side) {
            rows.push((latency, whole, id));
        }
    }
    rows.sort_by(|a, b| b.cmp(a));
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    println!("{:<36} {:>12} {:>14}", format!("node at {side}²"), "whole run", "goes on for");
    for (latency, whole, id) in &rows {
        let late = if *latency > BAR { "  over 100 ms" } else { "" };
        println!("{id:<36} {:>9.0} ms {:>11.1} ms{late}", ms(*whole), ms(*latency));
    }
}

/// How long the node takes, and the longest that it went on when it was stopped.
fn stopped(node: &NodeType, side: usize) -> Option<(Duration, Duration)> {
    let values: Vec<_> = node.spec().params.iter().map(|param| param.default.clone()).collect();
    let instance = node.instantiate(&values).ok()?;
    let slots = inputs_of(node.spec(), side, side);
    let context = Context { seed: 1, resolution: u32::try_from(side).ok() };
    let run = |after: Option<Duration>| {
        let host = Nowhere::default();
        let job = Job::new(&host, context);
        let begun = Instant::now();
        std::thread::scope(|scope| {
            let hand = after.map(|after| {
                let host = &host;
                scope.spawn(move || {
                    std::thread::sleep(after);
                    host.cancelled.store(true, Ordering::Relaxed);
                    Instant::now()
                })
            });
            let result = instance.run(&slots, &job);
            let ended = Instant::now();
            let told = hand.map(|hand| hand.join().unwrap_or(ended));
            (result.err(), ended - begun, told.map(|told| ended.saturating_duration_since(told)))
        })
    };
    let (_, whole, _) = run(None);
    if whole < SHORT {
        return None;
    }
    let latencies = SHARES.iter().filter_map(|share| {
        let (error, _, latency) = run(Some(whole.mul_f64(*share)));
        // One that was done before is none that was stopped, but may have ended late all the same.
        latency.filter(|latency| matches!(error, Some(Error::Cancelled)) || *latency > Duration::ZERO)
    });
    Some((whole, latencies.max().unwrap_or_default()))
}
