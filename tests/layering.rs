//! Dependencies run one way, and each crate keeps to what it may do.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The folders of the workspace's crates, the root package left out.
fn members() -> Vec<String> {
    let manifest = read(&root().join("Cargo.toml"));
    let list = manifest.split("members = [").nth(1).and_then(|rest| rest.split(']').next()).expect("members");
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The names in a manifest's tables of dependencies, those for tests only where asked.
fn dependencies(folder: &str, with_tests: bool) -> BTreeSet<String> {
    let mut inside = false;
    let mut names = BTreeSet::new();
    for line in read(&root().join(folder).join("Cargo.toml")).lines() {
        if let Some(table) = line.strip_prefix('[') {
            let table = table.trim_end_matches(']');
            inside = table.ends_with("dependencies")
                && table != "workspace.dependencies"
                && (with_tests || !table.ends_with("dev-dependencies"));
        } else if inside && let Some((name, _)) = line.split_once(['.', '=', ' ']) {
            names.insert(name.trim().to_owned());
        }
    }
    names
}

/// The Rust files under a folder.
fn sources(folder: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    assert!(!files.is_empty(), "{folder} has no sources");
    files.sort();
    files
}

/// A file's code without its comments.
fn code(path: &Path) -> String {
    read(path).lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// The places under `folder` where one of `words` stands in code, files that `may` say so left out.
fn uses(folder: &str, words: &[&str], may: impl Fn(&Path) -> bool) -> Vec<String> {
    let files = sources(folder).into_iter().filter(|path| !may(path));
    let found = files.filter_map(|path| {
        let code = code(&path);
        words.iter().find(|word| code.contains(*word)).map(|word| format!("{}: {word}", path.display()))
    });
    found.collect()
}

#[test]
fn dependencies_run_one_way() {
    for (folder, never) in [
        ("engine/derive", &["orograph-core", "orograph-engine", "orograph-nodes", "orograph"] as &[_]),
        ("engine/core", &["orograph-abi", "orograph-engine", "orograph-nodes", "orograph"]),
        ("engine/contract", &["orograph-abi", "orograph-engine", "orograph-nodes", "orograph"]),
        ("plugins/abi", &["orograph-engine", "orograph-nodes", "orograph"]),
        ("plugins/sdk", &["orograph-engine", "orograph-nodes", "orograph"]),
        ("engine", &["orograph-nodes", "orograph-plugin", "orograph-session", "orograph"]),
        ("nodes", &["orograph-abi", "orograph-engine", "orograph-session", "orograph"]),
        ("session", &["orograph-abi", "orograph-contract", "orograph", "clap", "indicatif", "notify"]),
    ] {
        let found = dependencies(folder, true);
        assert!(!found.is_empty(), "{folder} depends on nothing, it seems");
        for name in never {
            assert!(!found.contains(*name), "{folder} depends on {name}");
        }
    }
    assert!(dependencies("", false).contains("orograph-nodes"));
}

#[test]
fn what_front_ends_share_prints_nothing() {
    let found =
        uses("session/src", &["println!", "eprintln!", "print!", "io::stdout", "io::stderr"], |_| false);
    assert_eq!(found, [""; 0]);
}

#[test]
fn windows_live_in_the_editor_alone() {
    for folder in members().into_iter().chain([String::new()]).filter(|folder| folder != "editor") {
        for name in dependencies(&folder, true) {
            let window = ["egui", "eframe", "winit", "wgpu"].iter().any(|part| name.contains(part));
            assert!(!window, "{folder} depends on {name}");
        }
    }
}

#[test]
fn nothing_but_the_plugin_loader_is_unsafe() {
    let folders = [
        "engine/core/src",
        "engine/contract/src",
        "engine/derive/src",
        "engine/src",
        "nodes/src",
        "session/src",
        "src",
    ];
    let words = ["unsafe ", "unsafe{", "allow(unsafe_code)"];
    for folder in folders {
        let loader = |path: &Path| path.starts_with(root().join("engine/src/plugin"));
        let found = uses(folder, &words, loader);
        assert!(found.is_empty(), "{found:?}");
    }
    // Tests load a library into the program that makes the system fail under it, and this file names the words.
    let shim = |path: &Path| path.starts_with(root().join("tests/shim")) || path.ends_with("layering.rs");
    for folder in ["tests", "fuzz/src", "fuzz/fuzz_targets"] {
        let found = uses(folder, &words, shim);
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn nodes_depend_on_nothing_but_their_inputs() {
    let clocks =
        ["std::time", "Instant::now", "SystemTime", "std::env", "env::var", "thread_rng", "process::id"];
    for folder in ["engine/core/src", "nodes/src"] {
        let found = uses(folder, &clocks, |path| path.ends_with("io/tests.rs"));
        assert!(found.is_empty(), "{found:?}");
    }
    let io = root().join("nodes/src/io");
    let files = ["std::fs", "fs::read", "fs::write", "File::open", "File::create"];
    let found = uses("nodes/src", &files, |path| path.starts_with(&io));
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(uses("engine/core/src", &files, |_| false), [""; 0]);
}

#[test]
fn the_engine_names_no_node() {
    let families: Vec<_> = fs::read_dir(root().join("nodes/src")).unwrap().flatten().collect();
    let families = families.iter().filter(|entry| entry.path().is_dir());
    let names: Vec<_> = families.map(|entry| format!("\"{}.", entry.file_name().to_string_lossy())).collect();
    assert!(names.len() >= 10, "{names:?}");
    let words: Vec<_> = names.iter().map(String::as_str).collect();
    // Tests beside the code may name what they like.
    for path in sources("engine/src") {
        let code = code(&path);
        let code = code.split("#[cfg(test)]").next().unwrap_or("");
        let named = words.iter().find(|word| code.contains(**word));
        assert!(named.is_none(), "{} names {named:?}", path.display());
    }
}

#[test]
fn every_node_file_is_registered() {
    let ids: BTreeSet<_> =
        orograph_nodes::all().iter().map(|node_type| node_type.spec().id.to_string()).collect();
    let mut declared = BTreeSet::new();
    for path in sources("nodes/src") {
        for part in code(&path).split("const ID: &'static str = \"").skip(1) {
            let id = part.split('"').next().unwrap_or("").to_owned();
            assert!(ids.contains(&id), "{id} of {} is not registered", path.display());
            declared.insert(id);
        }
    }
    assert_eq!(declared, ids);
}

#[test]
fn the_map_names_every_crate() {
    let map = read(&root().join("ARCHITECTURE.md"));
    for member in members() {
        assert!(map.contains(&member), "ARCHITECTURE.md does not name {member}");
    }
}
