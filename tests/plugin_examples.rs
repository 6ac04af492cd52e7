//! The example plugins, built as their authors would, tested, checked and run.

#![cfg(unix)]
// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::LazyLock,
};

use support::Place;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn succeed(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{command:?}\n{}{}", text(&output.stdout), text(&output.stderr));
}

/// Cargo for a crate of its own, with a target folder that these crates share.
fn cargo(verb: &str, folder: &Path, target: &Path) -> Command {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.arg(verb).current_dir(folder).env("CARGO_TARGET_DIR", target);
    cargo
}

/// The library of a crate of that name in a folder.
fn library(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX))
}

/// What links Rust programs, as the examples' makefiles call it; `make` itself need not be there.
fn compiler(folder: &Path) -> Command {
    let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.current_dir(folder).args([
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-ffp-contract=off",
    ]);
    compiler.args(["-fPIC", "-O2", "-I"]).arg(root().join("plugins"));
    compiler
}

/// All example plugins in one folder, built once for all tests.
static PLUGINS: LazyLock<PathBuf> = LazyLock::new(|| {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("examples");
    let plugins = target.join("plugins");
    fs::create_dir_all(&plugins).unwrap();
    for (example, name) in [("hydraulic-erosion", "hydraulic_erosion"), ("biomes", "biomes")] {
        let folder = root().join("plugins/examples").join(example);
        succeed(cargo("build", &folder, &target).arg("--locked"));
        fs::copy(library(&target.join("debug"), name), library(&plugins, name)).unwrap();
    }
    let thermal = root().join("plugins/examples/thermal-erosion");
    succeed(
        compiler(&thermal)
            .args(["-shared", "thermal_erosion.c", "-lm", "-o"])
            .arg(library(&plugins, "thermal_erosion")),
    );
    plugins
});

#[test]
fn their_own_tests_pass() {
    let target = PLUGINS.parent().unwrap();
    for example in ["hydraulic-erosion", "biomes"] {
        let folder = root().join("plugins/examples").join(example);
        succeed(cargo("test", &folder, target).arg("--locked"));
    }
    let thermal = root().join("plugins/examples/thermal-erosion");
    let test = target.join("test_thermal_erosion");
    let sources = ["test_thermal_erosion.c", "thermal_erosion.c", "-lm", "-o"];
    succeed(compiler(&thermal).args(sources).arg(&test));
    succeed(&mut Command::new(test));
}

#[test]
fn they_stand_every_check() {
    let place = Place::nodes("");
    let mut libraries: Vec<_> = fs::read_dir(&*PLUGINS).unwrap().map(|entry| entry.unwrap().path()).collect();
    libraries.retain(|path| {
        path.extension().is_some_and(|extension| extension == std::env::consts::DLL_EXTENSION)
    });
    assert_eq!(libraries.len(), 3, "{libraries:?}");
    for library in libraries {
        place.ok(&format!("plugin check {}", library.display()));
    }
}

#[test]
fn their_graphs_run_here_and_apart_with_the_same_bytes() {
    let graphs = root().join("graphs/plugins");
    for graph in ["hydraulic.ron", "thermal.ron", "biomes.ron"] {
        let place = Place::nodes("");
        let line =
            format!("run {} --plugins {} --cache none", graphs.join(graph).display(), PLUGINS.display());
        place.ok(&format!("{line} --out here"));
        place.ok(&format!("{line} --out apart --isolate"));
        place.ok(&format!("{line} --out alone --jobs 1"));
        let here = place.files("here");
        assert!(!here.is_empty(), "{graph} writes nothing");
        assert_eq!(here, place.files("apart"), "{graph}");
        assert_eq!(here, place.files("alone"), "{graph}");
    }
}

#[test]
fn a_new_plugin_builds_and_its_node_runs() {
    let place = Place::nodes("");
    place.ok("plugin new coast-lines --lang c");
    let folder = place.path("coast-lines");
    fs::create_dir(folder.join("build")).unwrap();
    let built = library(&folder.join("build"), "coast_lines");
    succeed(compiler(&folder).args(["-shared", "coast_lines.c", "-lm", "-o"]).arg(built));
    place.run("plugin new coast-lines").code(2).tells(&["there is a `coast-lines` here already"]);
    place.run("plugin new Coast").code(2).tells(&["`Coast` is no name for a plugin"]);
    place.ok("plugin new dune-fields");
    let target = PLUGINS.parent().unwrap();
    // The versions that are here: a new plugin has no lock file, and a test is not to look for newer ones.
    let lock = root().join("plugins/examples/biomes/Cargo.lock");
    let lock = fs::read_to_string(lock)
        .unwrap()
        .replace("name = \"biomes\"\nversion = \"1.0.0\"", "name = \"dune-fields\"\nversion = \"0.1.0\"");
    place.write("dune-fields/Cargo.lock", lock);
    succeed(cargo("build", &place.path("dune-fields"), target).arg("--offline"));
    let folder = place.path("dune-fields/build");
    fs::create_dir(&folder).unwrap();
    fs::copy(library(&target.join("debug"), "dune_fields"), library(&folder, "dune_fields")).unwrap();
    for (plugin, name) in [("coast-lines", "coast_lines"), ("dune-fields", "dune_fields")] {
        let built = library(&place.path(plugin).join("build"), name);
        place.ok(&format!("plugin check {}", built.display()));
        place.ok(&format!("run {plugin}/graph.ron --plugins {plugin}/build --out {plugin}/out"));
        assert!(!place.files(&format!("{plugin}/out")).is_empty(), "{plugin} writes nothing");
    }
}
