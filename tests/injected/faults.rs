//! What becomes of a run, and of what a user keeps, whichever call fails.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::{
        LazyLock,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use crate::support::{CHAIN, Ended, Place};
use orograph_session::Settings;

/// The faults: what the system says, and its number. Short writes have none.
const FAULTS: [(&str, u32); 3] =
    [("No space left on device", 28), ("Permission denied", 13), ("Input/output error", 5)];
const SHORT: u32 = 0;

/// The library that makes calls fail.
static SHIM: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("failing_calls.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shim/failing_calls.rs");
    let mut compiler = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    compiler.args([
        "--edition",
        "2024",
        "--crate-type",
        "cdylib",
        "-D",
        "warnings",
        "-C",
        "opt-level=1",
        "-o",
    ]);
    let built = compiler.arg(&library).arg(source).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    (folder, library)
});

/// What is to fail: of the calls on paths with `word` in them, number `at`, or with `and_on` all from that one on.
#[derive(Clone, Copy, Debug)]
struct Fault {
    word: &'static str,
    at: usize,
    and_on: bool,
    with: u32,
}

/// A call that counted: its name, whether it was made to fail, and its path.
#[derive(Clone, Debug)]
struct Call {
    name: String,
    faulty: bool,
    path: String,
}

/// Lets a command meet a fault; its output, and the calls that counted.
fn meet(command: &mut Command, log: &Path, fault: Fault) -> (std::process::Output, Vec<Call>) {
    let at = format!("{}{}", fault.at, if fault.and_on { "-" } else { "" });
    command.env("LD_PRELOAD", &SHIM.1).env("FAULT_WHERE", fault.word).env("FAULT_AT", at);
    command.env("FAULT_WITH", fault.with.to_string()).env("FAULT_LOG", log);
    let output = command.output().unwrap();
    assert_ne!(output.status.code(), Some(99), "this system does not let a process hand over its own calls");
    let text = fs::read(log).unwrap_or_default();
    let _ = fs::remove_file(log);
    let calls = String::from_utf8_lossy(&text)
        .lines()
        .map(|line| {
            let mut words = line.splitn(3, ' ').map(str::to_owned);
            let mut next = || words.next().unwrap();
            Call { name: next(), faulty: next() == "faulty", path: next() }
        })
        .collect();
    (output, calls)
}

/// Runs the program with a fault.
fn run(place: &Place, line: &str, fault: Fault) -> (Ended, Vec<Call>) {
    static N: AtomicUsize = AtomicUsize::new(0);
    let log = place.path(&format!("log{}", N.fetch_add(1, Ordering::Relaxed)));
    let (output, calls) = meet(&mut place.command(line), &log, fault);
    (Ended::new(&format!("{line} with {fault:?}"), output), calls)
}

/// Whether all that failed was the making of folders, which may have been there.
fn is_harmless(calls: &[Call]) -> bool {
    calls.iter().filter(|call| call.faulty).all(|call| call.name == "mkdir")
}

/// Every call that a sound run makes, which are those that can fail.
fn calls_of(place: &Place, line: &str, word: &'static str) -> Vec<Call> {
    let (ended, calls) = run(place, line, Fault { word, at: 0, and_on: false, with: SHORT });
    ended.code(0);
    assert!(calls.iter().all(|call| !call.faulty && call.path.contains(word)), "{calls:?}");
    calls
}

/// How often each kind of call stands among them.
fn kinds(calls: &[Call]) -> BTreeMap<&str, usize> {
    let mut kinds = BTreeMap::new();
    for call in calls {
        *kinds.entry(call.name.as_str()).or_default() += 1;
    }
    kinds
}

/// Each fault at each of `n` calls: alone, and where a disk is full at all that follow, too.
fn faults(word: &'static str, n: usize) -> Vec<Fault> {
    let each = |(_, with): (&str, u32)| (1..=n).map(move |at| Fault { word, at, and_on: with == 28, with });
    FAULTS.into_iter().flat_map(each).collect()
}

/// Does something with each of `items` on two threads.
fn for_each<T: Sync>(items: &[T], work: impl Fn(usize, &T) + Sync) {
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((n, item)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|n| Some((n, items.get(n)?)))
                {
                    work(n, item);
                }
            });
        }
    });
}

fn said(fault: Fault) -> &'static str {
    FAULTS.iter().find(|(_, number)| *number == fault.with).unwrap().0
}

#[test]
fn outputs_are_whole_or_missing_whichever_call_fails() {
    let place = Place::with(&CHAIN.replace("\"flat.asc\"", "\"maps/flat.asc\""));
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    let line = |n: usize| format!("run g.ron --cache none --jobs 1 --out outputs{n}");
    let calls = calls_of(&place, &line(0), "outputs");
    let kinds = kinds(&calls);
    // Folders, temporary files, their bytes, their permissions, their names.
    for kind in ["mkdir", "open", "write", "fchmod", "rename"] {
        assert!(kinds.contains_key(kind), "{kinds:?}");
    }
    let faults = faults("outputs", calls.len());
    for_each(&faults, |n, fault| {
        let n = n + 1;
        let (ended, calls) = run(&place, &line(n), *fault);
        let out = format!("outputs{n}");
        let files = place.files(&out);
        assert!(calls.iter().any(|call| call.faulty), "{ended:?}");
        for (name, bytes) in &files {
            assert!(expected.get(name) == Some(bytes), "{name} is torn, or should not be there: {ended:?}");
        }
        // Every file that is missing is told by its name.
        let missing: Vec<_> = expected.keys().filter(|name| !files.contains_key(*name)).collect();
        assert!(!missing.is_empty() || is_harmless(&calls), "{ended:?} {calls:?}");
        for name in &missing {
            let told = ended.err.contains(&format!("writing {out}/{name}: "));
            assert!(told && ended.err.contains(said(*fault)), "{name}: {ended:?}");
        }
        let mend: &[&str] = match missing.is_empty() {
            true => &[],
            false => &["hint: check that you may write there and that the disk has room"],
        };
        ended.code(i32::from(!missing.is_empty())).tells(mend).gives(&["stats:"]);
        // The next run there makes up for it.
        place.ok(&line(n));
        assert!(place.files(&out) == expected);
    });
    println!("{} runs with a fault of outputs: {kinds:?}", faults.len());
}

#[test]
fn a_cache_that_fails_costs_one_warning_whichever_call_fails() {
    let place = Place::with(CHAIN);
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    let line = |n: usize| format!("run g.ron --cache kept{n} --jobs 1 --out out{n}");
    let calls = calls_of(&place, &line(0), "kept");
    let kinds = kinds(&calls);
    for kind in ["mkdir", "open", "write", "rename"] {
        assert!(kinds.contains_key(kind), "{kinds:?}");
    }
    let faults = faults("kept", calls.len());
    for_each(&faults, |n, fault| {
        let n = n + 1;
        let (ended, calls) = run(&place, &line(n), *fault);
        let warnings = ended.err.matches("warning: ").count();
        let harmless = is_harmless(&calls);
        assert!(warnings == 1 || (warnings == 0 && harmless), "{ended:?} {calls:?}");
        if warnings == 1 {
            assert!(ended.err.contains(said(*fault)), "{ended:?}");
        }
        ended.code(0).gives(&["stats:"]);
        assert!(place.files(&format!("out{n}")) == expected);
        // Nothing half-written is left.
        let left = place.files(&format!("kept{n}"));
        let is_torn = |(name, bytes): (&String, &Vec<u8>)| name.starts_with("v1/tmp") || bytes.is_empty();
        assert!(!left.iter().any(is_torn), "{:?}", left.keys());
        // What is there is good: the next run builds on it, elsewhere.
        let _ = fs::remove_dir_all(place.path(&format!("out{n}")));
        place.ok(&line(n));
        assert!(place.files(&format!("out{n}")) == expected);
    });
    println!("{} runs with a fault of the cache: {kinds:?}", faults.len());
}

#[test]
fn short_writes_are_not_seen() {
    let place = Place::with(&CHAIN.replace("cells: 64", "cells: 128"));
    place.ok("run g.ron --cache none --out expected");
    let expected = place.files("expected");
    for word in ["outputs", "kept"] {
        let all = Fault { word, at: 1, and_on: true, with: SHORT };
        let line = format!("run g.ron --cache kept-{word} --out outputs-{word}");
        let (ended, calls) = run(&place, &line, all);
        let short = calls.iter().filter(|call| call.faulty).count();
        assert!(short > 20, "{short} short writes");
        assert!(!ended.err.contains("warning"), "{ended:?}");
        ended.code(0);
        assert!(place.files(&format!("outputs-{word}")) == expected);
        // What was kept is whole, too.
        let again = place.manifest(&format!("g.ron --cache kept-{word} --out again-{word}"), 0);
        let count = |what: &str| again["counts"][what].as_u64().unwrap();
        assert_eq!(count("computed"), 2, "the writers alone: {again}");
        assert!(place.files(&format!("again-{word}")) == expected);
    }
}

/// The program that meets faults while it saves. Run by the test below alone.
#[test]
#[ignore = "runs as the child of another test"]
fn saves_what_a_user_keeps() {
    let folder = PathBuf::from(std::env::var_os("OROGRAPH_TEST_SAVES").unwrap());
    let settings = Settings { memory: Some(2), ..Settings::default() };
    let graph = orograph_engine::save_whole(&folder.join("graph.ron"), b"new graph");
    println!("graph: {}", graph.map_or_else(|error| error.to_string(), |()| "saved".into()));
    let settings = settings.save_to(&folder.join("deep/settings.ron"));
    println!("settings: {}", settings.map_or_else(|error| error.to_string(), |()| "saved".into()));
}

/// Graphs, the editor's journal and pictures, and settings are all written by `save_whole`.
#[test]
fn what_a_user_keeps_is_as_it_was_or_new_whichever_call_fails() {
    let root = tempfile::tempdir().unwrap();
    let save = |n: usize, fault: Fault| {
        let folder = root.path().join(format!("precious{n}"));
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("graph.ron"), "old graph").unwrap();
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "faults::saves_what_a_user_keeps", "--ignored", "--nocapture"]);
        command.env("OROGRAPH_TEST_SAVES", &folder);
        let (output, calls) = meet(&mut command, &root.path().join(format!("log{n}")), fault);
        (folder, String::from_utf8_lossy(&output.stdout).into_owned(), calls)
    };
    let (_, told, calls) = save(0, Fault { word: "precious", at: 0, and_on: false, with: SHORT });
    assert!(told.contains("graph: saved") && told.contains("settings: saved"), "{told}");
    let kinds = kinds(&calls);
    for kind in ["mkdir", "open", "write", "fsync", "rename"] {
        assert!(kinds.contains_key(kind), "{kinds:?}");
    }
    let all = faults("precious", calls.len()).into_iter().map(Some).chain([None]);
    for (n, fault) in all.enumerate() {
        let short = Fault { word: "precious", at: 1, and_on: true, with: SHORT };
        let (folder, told, calls) = save(n + 1, fault.unwrap_or(short));
        let graph = fs::read_to_string(folder.join("graph.ron")).unwrap();
        let saved = told.contains("graph: saved");
        assert_eq!(graph, if saved { "new graph" } else { "old graph" }, "{fault:?} {told}");
        let settings = Settings::load_from(&folder.join("deep/settings.ron")).unwrap();
        let kept = told.contains("settings: saved");
        assert_eq!(settings.memory, kept.then_some(2), "{fault:?} {told}");
        match fault {
            Some(_) if saved && kept => assert!(is_harmless(&calls), "{fault:?} {told} {calls:?}"),
            Some(fault) => assert!(told.contains(said(fault)), "{fault:?} {told}"),
            None => assert!(saved && kept, "short writes: {told}"),
        }
        let mut left = Vec::new();
        for folder in [folder.clone(), folder.join("deep")] {
            left.extend(fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().file_name()));
        }
        let known = ["graph.ron", "deep", "settings.ron"];
        assert!(left.iter().all(|name| known.iter().any(|known| name == known)), "{fault:?} {left:?}");
    }
}
