//! A folder of its own for each test, and the command run in it.

// Each test file uses its part of this; a helper that fails is a test that fails.
#![allow(dead_code, clippy::unwrap_used)]

pub(crate) mod plugins;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

use serde_json::Value as Json;
use tempfile::TempDir;

/// Noise clamped, measured, and written in two formats.
pub(crate) const CHAIN: &str = r#"(
    format: 1,
    outputs: {"ground": "hills.terrain", "stats": "measured.metrics"},
    nodes: {
        "hills": (node: "generate.fbm", version: 1, params: (cells: 64)),
        "flat": (node: "adjust.clamp", version: 1, params: (lowest: -100.0, highest: 100.0),
            inputs: {"terrain": "hills.terrain"}),
        "measured": (node: "measure.statistics", version: 1, inputs: {"terrain": "flat.terrain"}),
        "tif": (node: "io.write_geotiff", version: 1, params: (file: "flat.tif"),
            inputs: {"terrain": "flat.terrain"}),
        "asc": (node: "io.write_ascii", version: 1, params: (file: "flat.asc"),
            inputs: {"terrain": "flat.terrain"}),
    },
)"#;

/// A folder with graphs in it; its cache lies in it too.
pub(crate) struct Place {
    folder: TempDir,
}

impl Place {
    /// A folder with `graph` as `g.ron`.
    pub(crate) fn with(graph: &str) -> Self {
        let place = Self { folder: TempDir::new().unwrap() };
        place.write("g.ron", graph);
        place
    }

    /// A folder with a graph of these nodes alone as `g.ron`.
    pub(crate) fn nodes(nodes: &str) -> Self {
        Self::with(&format!("(\nformat: 1,\nnodes: {{\n{nodes}\n}},\n)"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    /// The command in this folder, with the words of `line` for arguments.
    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_orograph"));
        command.args(line.split_whitespace());
        self.settle(&mut command);
        command
    }

    /// Gives a command this folder and cache, and no terminal.
    pub(crate) fn settle(&self, command: &mut Command) {
        command.current_dir(self.folder.path()).env("OROGRAPH_CACHE", self.path("cache"));
        // What whoever runs the tests has installed is none of their business.
        for (name, folder) in [("XDG_DATA_HOME", "data"), ("XDG_CONFIG_HOME", "config")] {
            command.env(name, self.path(folder));
        }
        command.env_remove("OROGRAPH_PLUGINS");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    }

    pub(crate) fn run(&self, line: &str) -> Ended {
        Ended::new(line, self.command(line).output().unwrap())
    }

    /// Runs, and expects success.
    pub(crate) fn ok(&self, line: &str) -> Ended {
        self.run(line).code(0)
    }

    /// The manifest of a run that ends with `code`.
    pub(crate) fn manifest(&self, line: &str, code: i32) -> Json {
        self.run(&format!("run {line} --json")).code(code).json()
    }

    /// Every file under a folder with its bytes, by its relative path.
    pub(crate) fn files(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let mut files = BTreeMap::new();
        collect(&self.path(folder), &self.path(folder), &mut files);
        files
    }
}

fn collect(root: &Path, folder: &Path, files: &mut BTreeMap<String, Vec<u8>>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(root, &path, files);
        } else {
            let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
            files.insert(name, fs::read(&path).unwrap());
        }
    }
}

/// How a command ended.
#[derive(Debug)]
pub(crate) struct Ended {
    line: String,
    code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ended {
    pub(crate) fn new(line: &str, output: Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let ended = Self {
            line: line.into(),
            code: output.status.code(),
            out: text(&output.stdout),
            err: text(&output.stderr),
        };
        for word in ["panicked", "RUST_BACKTRACE", "stack backtrace", "\u{1b}["] {
            assert!(!ended.err.contains(word) && !ended.out.contains(word), "{word:?} in {ended:#?}");
        }
        ended
    }

    #[track_caller]
    pub(crate) fn code(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Expects every one of `parts` on standard error.
    #[track_caller]
    pub(crate) fn tells(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.err.contains(part), "no {part:?} in {self:#?}");
        }
        self
    }

    /// Expects every one of `parts` on standard output.
    #[track_caller]
    pub(crate) fn gives(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.out.contains(part), "no {part:?} in {self:#?}");
        }
        self
    }

    #[track_caller]
    pub(crate) fn json(&self) -> Json {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {self:#?}"))
    }
}

/// The manifest's count of nodes that were computed.
pub(crate) fn computed(manifest: &Json) -> u64 {
    manifest["counts"]["computed"].as_u64().unwrap()
}

/// How a node came by its outputs.
pub(crate) fn outcome<'a>(manifest: &'a Json, node: &str) -> &'a str {
    let nodes = manifest["nodes"].as_array().unwrap();
    nodes.iter().find(|each| each["name"] == node).and_then(|each| each["outcome"].as_str()).unwrap_or("none")
}
