//! Many processes over one cache folder, with collections and clearings in between: no error, and the right bytes.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{
    collections::BTreeMap,
    fs, thread,
    time::{Duration, Instant},
};

use support::{CHAIN, Place};

/// Another graph, with a part in common with [`CHAIN`].
const SLOPES: &str = r#"(
    format: 1,
    outputs: {"ground": "hills.terrain", "stats": "measured.metrics"},
    nodes: {
        "hills": (node: "generate.fbm", version: 1, params: (cells: 64)),
        "flat": (node: "adjust.clamp", version: 1, params: (lowest: -100.0, highest: 100.0),
            inputs: {"terrain": "hills.terrain"}),
        "soft": (node: "filter.gaussian_blur", version: 1, inputs: {"terrain": "flat.terrain"}),
        "measured": (node: "measure.statistics", version: 1, inputs: {"terrain": "soft.terrain"}),
        "png": (node: "io.write_png", version: 1, params: (file: "soft.png"), inputs: {"terrain": "soft.terrain"}),
        "tif": (node: "io.write_geotiff", version: 1, params: (file: "soft.tif"), inputs: {"terrain": "soft.terrain"}),
    },
)"#;

/// What a run makes: what it prints, and its files.
type Made = (String, BTreeMap<String, Vec<u8>>);

/// Numerical Recipes' generator: any spread of choices will do.
fn draw(state: &mut u64, below: u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) % below
}

/// Lets `workers` processes run at once for so long; how many runs there were, and how many clearings, collections and
/// counts.
fn crowd(workers: u64, time: Duration) -> (u64, u64) {
    let place = Place::with(CHAIN);
    place.write("s.ron", SLOPES);
    let lines: Vec<String> = ["g.ron", "s.ron"]
        .iter()
        .flat_map(|graph| {
            (1..=4).map(move |seed| format!("{graph} --seed {seed} --set hills.cells={}", 48 + 40 * seed))
        })
        .collect();
    let make = |line: &str, cache: &str, out: &str| -> Made {
        let ended = place.ok(&format!("run {line} {cache} --out {out}"));
        assert!(!ended.err.contains("warning") && !ended.err.contains("error"), "{ended:?}");
        let made = (ended.out.replace(out, "out"), place.files(out));
        fs::remove_dir_all(place.path(out)).unwrap();
        made
    };
    let expected: Vec<Made> = lines.iter().map(|line| make(line, "--cache none", "expected")).collect();
    let end = Instant::now() + time;
    let worker = |worker: u64| {
        let (mut state, mut runs, mut upkeep) = (worker, 0, 0);
        while Instant::now() < end {
            let n = draw(&mut state, lines.len() as u64) as usize;
            let jobs = 1 + draw(&mut state, 3);
            let made = make(&lines[n], &format!("--jobs {jobs}"), &format!("out{worker}"));
            assert!(made == expected[n], "{} gave other bytes to worker {worker}", lines[n]);
            runs += 1;
            let line = match draw(&mut state, 12) {
                0 => "cache clear".into(),
                1 | 2 => format!("cache gc --max {}KiB", draw(&mut state, 600)),
                3 => "cache stat".into(),
                _ => continue,
            };
            place.ok(&line);
            upkeep += 1;
        }
        (runs, upkeep)
    };
    let worker = &worker;
    let totals: Vec<_> = thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|n| scope.spawn(move || worker(n))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    // Nothing is left of writes and of clearings.
    let left = place.files("cache");
    let is_left = |name: &String| name.starts_with("v1/tmp") || name.starts_with("cleared");
    assert!(!left.keys().any(is_left), "{:?}", left.keys());
    let (runs, upkeep) = totals.iter().fold((0, 0), |sum, total| (sum.0 + total.0, sum.1 + total.1));
    (runs, upkeep)
}

#[test]
fn three_processes_share_a_cache_under_load() {
    let (runs, upkeep) = crowd(3, Duration::from_secs(5));
    println!("{runs} runs and {upkeep} clearings, collections and counts in five seconds");
    assert!(runs >= 6 && upkeep > 0, "{runs} runs, {upkeep} times upkeep");
}

#[test]
#[ignore = "takes a minute"]
fn three_processes_share_a_cache_under_load_for_a_minute() {
    let (runs, upkeep) = crowd(3, Duration::from_secs(60));
    println!("{runs} runs and {upkeep} clearings, collections and counts in a minute");
    assert!(runs >= 100 && upkeep >= 20, "{runs} runs, {upkeep} times upkeep");
}
