//! Checks on real elevation data, which does not come with the repository.
//!
//! The folder is named by `OROGRAPH_DEM_DIR`, by default `../shared/dem` beside the workspace. Without it the
//! run passes and says in its closing lines what it left out, unless `OROGRAPH_DEM_REQUIRED=1` forbids that.
//! A family adds its checks in `real_dem/<family>.rs` and one line in [`checks`].

#![expect(clippy::print_stdout, reason = "a test runner reports on standard output")]

mod real_dem {
    pub(crate) mod feature;
    pub(crate) mod io;
    pub(crate) mod mcmd;
    pub(crate) mod measure;
    pub(crate) mod repair;
    pub(crate) mod synthesis;
    pub(crate) mod tiles;
}

use std::{
    env, fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    process::ExitCode,
};

/// What a check does with the DEM folder; an error says what is wrong.
type Run = dyn Fn(&Path) -> Result<(), String>;

/// One check; it gets the DEM folder and says what is wrong.
pub(crate) struct Check {
    /// What is checked, `family: statement`.
    pub(crate) name: String,
    /// Does it.
    pub(crate) run: Box<Run>,
}

impl Check {
    /// A check of that name.
    pub(crate) fn new(name: impl Into<String>, run: impl Fn(&Path) -> Result<(), String> + 'static) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }
}

fn checks() -> Vec<Check> {
    [
        real_dem::feature::checks(),
        real_dem::io::checks(),
        real_dem::mcmd::checks(),
        real_dem::measure::checks(),
        real_dem::repair::checks(),
        real_dem::synthesis::checks(),
        real_dem::tiles::checks(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn main() -> ExitCode {
    let filters: Vec<String> = env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wanted = |check: &Check| filters.is_empty() || filters.iter().any(|text| check.name.contains(text));
    let checks: Vec<Check> = checks().into_iter().filter(wanted).collect();
    if env::args().any(|argument| argument == "--list") {
        checks.iter().for_each(|check| println!("{}: test", check.name));
        return ExitCode::SUCCESS;
    }
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder =
        env::var_os("OROGRAPH_DEM_DIR").map_or_else(|| workspace.join("../shared/dem"), PathBuf::from);
    if !folder.is_dir() {
        return left_out(&checks, &workspace.join("graphs"));
    }
    let mut failed = 0;
    for check in &checks {
        let run = || (check.run)(&folder);
        match catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| Err("panicked".into())) {
            Ok(()) => println!("ok {}", check.name),
            Err(why) => {
                failed += 1;
                println!("FAILED {}: {why}", check.name);
            }
        }
    }
    println!("{} passed, {failed} failed", checks.len() - failed);
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Says what the absence of the folder leaves unchecked: the checks here and the graphs that read from it.
fn left_out(checks: &[Check], graphs: &Path) -> ExitCode {
    let names: Vec<&str> = checks.iter().map(|check| check.name.as_str()).collect();
    let needed = "need the DEM folder (set OROGRAPH_DEM_DIR)";
    println!("left out: {} checks that {needed}: {}", names.len(), names.join(", "));
    let graphs = graphs_that_read_it(graphs);
    if !graphs.is_empty() {
        println!("left out: {} graphs that {needed}: {}", graphs.len(), graphs.join(", "));
    }
    let required = env::var_os("OROGRAPH_DEM_REQUIRED").is_some_and(|value| value == "1");
    let failed = if required { names.len() } else { 0 };
    println!("0 passed, {failed} failed");
    if required { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn graphs_that_read_it(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .filter(|path| fs::read_to_string(path).is_ok_and(|text| text.contains("OROGRAPH_DEM_DIR")))
        .filter_map(|path| Some(format!("graphs/{}", path.file_name()?.to_str()?)))
        .collect();
    names.sort();
    names
}
