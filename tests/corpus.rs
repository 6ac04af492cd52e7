//! The functions that are fuzzed, over their seeds and over everything that fuzzing ever found.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

#[path = "../fuzz/src/lib.rs"]
#[allow(unreachable_pub)]
mod fuzz;

use std::{
    fs,
    panic::catch_unwind,
    path::{Path, PathBuf},
};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

/// The seeds of a target by name; what fuzzing found has names that begin with `found`.
fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = folder().join("seeds").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut seeds: Vec<_> = entries
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
        .collect();
    seeds.sort();
    seeds
}

#[test]
fn every_seed_of_every_target_keeps_the_promises() {
    let mut broken = Vec::new();
    let mut n_seeds = 0;
    for (target, try_on) in fuzz::TARGETS {
        for (name, bytes) in seeds(target) {
            n_seeds += 1;
            if catch_unwind(|| try_on(&bytes)).is_err() {
                broken.push(format!("{target}/{name}"));
            }
        }
    }
    println!("{n_seeds} seeds of {} targets", fuzz::TARGETS.len());
    assert!(broken.is_empty(), "what was printed above comes of {broken:?}");
}

/// What a fuzzer tries first, without one: cut short, a byte of it changed, a piece of it twice.
#[test]
fn spoiled_seeds_keep_the_promises_too() {
    let mut broken = Vec::new();
    for (target, try_on) in fuzz::TARGETS {
        for (name, bytes) in seeds(target).into_iter().filter(|(_, bytes)| bytes.len() < 4096) {
            let len = bytes.len();
            let step = (len / 12).max(1);
            let mut all: Vec<Vec<u8>> = (0..len).step_by(step).map(|end| bytes[..end].to_vec()).collect();
            for at in (0..len).step_by(step) {
                for value in [0, 0x7f, 0xff] {
                    let mut changed = bytes.clone();
                    changed[at] = value;
                    all.push(changed);
                }
                all.push([&bytes[..at], &bytes[at / 2..]].concat());
            }
            for spoiled in all {
                if catch_unwind(|| try_on(&spoiled)).is_err() {
                    broken.push(format!("{target}/{name}: {}", spoiled.escape_ascii()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_target_has_its_fuzzer_and_seeds_and_they_are_small() {
    let manifest = fs::read_to_string(folder().join("Cargo.toml")).unwrap();
    let fuzzers: Vec<_> =
        manifest.split("[[bin]]\nname = \"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    let targets: Vec<_> = fuzz::TARGETS.iter().map(|target| target.0).collect();
    assert_eq!(fuzzers, targets);
    let mut total = 0;
    for target in &targets {
        let seeds = seeds(target);
        assert!(seeds.len() >= 2, "{target} has {} seeds", seeds.len());
        total += seeds.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    }
    assert!(total < 1 << 20, "the seeds take {total} bytes");
    let folders = fs::read_dir(folder().join("seeds")).unwrap();
    for folder in folders.map(|entry| entry.unwrap().file_name().into_string().unwrap()) {
        assert!(targets.contains(&folder.as_str()), "no target is named {folder}");
    }
}

#[test]
fn a_target_that_there_is_not_is_told() {
    assert!(catch_unwind(|| fuzz::run("no such target", b"")).is_err());
}
