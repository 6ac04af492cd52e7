//! Every shipped graph, run headless through the program itself.
//!
//! A graph is run on one thread and on eight with empty caches, then on two threads with the first run's cache:
//! into another folder, where its writers alone may work, and into the same one, where nothing may. Last it is
//! run twice in one process on a cache in memory. Files, keys and digests must be the same every time, and equal
//! to `graphs/golden.json`, which `UPDATE_GOLDEN=1` writes anew; of a graph that shows one node for the manual, that node
//! alone is remembered. Graphs that have inputs
//! run as nodes of those that use them; one that none uses is an error.
//!
//! Graphs that read from the DEM folder need it (`OROGRAPH_DEM_DIR`, by default `../shared/dem` beside the
//! workspace). Without it the run says in its closing lines what it left out, unless `OROGRAPH_DEM_REQUIRED=1`
//! forbids that.

#![expect(clippy::print_stdout, reason = "a test runner reports on standard output")]

use std::{
    collections::BTreeMap,
    env, fs,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
    time::{Duration, Instant},
};

use orograph_core::Context;
use orograph_engine::{
    Cache, CancelToken, CompileOptions, Document, Evaluator, Registry, Report, Request, compile,
    document::{Body, read_file},
    eval::Silent,
};
use rayon::prelude::*;
use serde_json::Value as Json;
use tempfile::TempDir;

type Result<T, E = String> = std::result::Result<T, E>;

/// What is remembered of each node of a graph: its id, version and outputs, by the node's name.
type Golden = BTreeMap<String, BTreeMap<String, Json>>;

/// A shipped graph.
struct Case {
    /// Its path below `graphs`, without the extension.
    name: String,
    file: PathBuf,
    document: Document,
    needs_dem: bool,
}

impl Case {
    fn load(folder: &Path, file: PathBuf) -> Result<Self> {
        let text = fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let document = Document::load(&file).map_err(|errors| errors.to_string())?;
        let relative = file.strip_prefix(folder).unwrap_or(&file).with_extension("");
        let name = relative.to_string_lossy().replace('\\', "/");
        let needs_dem = text.contains("OROGRAPH_DEM_DIR");
        if !text.starts_with("//") || document.doc.is_empty() {
            return Err(format!("{name}: a shipped graph begins with a comment and has a `doc`"));
        }
        Ok(Self { name, file, document, needs_dem })
    }

    /// Runs the graph in every way and returns what to remember of it; nothing when it needs inputs.
    fn test(&self, all: &[Self]) -> Result<Option<BTreeMap<String, Json>>> {
        let registry = Registry::new(orograph_nodes::all()).map_err(|clash| clash.to_string())?;
        if !self.document.inputs.is_empty() {
            let used = all.iter().any(|case| case.uses(&self.file));
            return if used { Ok(None) } else { Err("it has inputs, and no shipped graph uses it".into()) };
        }
        let folder = TempDir::new().map_err(|error| error.to_string())?;
        let at = |name: &str| folder.path().join(name);
        let cold = Run::new(self, "1", &at("cache"), &at("cold"))?;
        cold.expect_files(self)?;
        let eight = Run::new(self, "8", &at("cache-8"), &at("eight"))?;
        cold.expect_equal(&eight, "8 threads")?;
        let warm = Run::new(self, "2", &at("cache"), &at("warm"))?;
        cold.expect_equal(&warm, "a warm disk cache")?;
        let worked = warm.computed().filter(|node| !cold.writes(node)).collect::<Vec<_>>();
        if !worked.is_empty() {
            return Err(format!("with a warm disk cache these ran again: {}", worked.join(", ")));
        }
        let again = Run::new(self, "2", &at("cache"), &at("cold"))?;
        cold.expect_equal(&again, "a second run")?;
        if let Some(node) = again.computed().next() {
            return Err(format!("a second run into the same folder ran `{node}` again"));
        }
        self.expect_equal_in_memory(&registry, &cold, &at("memory"))?;
        let mut golden = cold.golden();
        if let Some(id) = self.name.strip_prefix("nodes/") {
            // One node is what such a graph is about; what the others give is remembered where they are shown.
            golden.retain(|_, node| {
                node["version"].as_str().is_some_and(|version| version.split('@').next() == Some(id))
            });
        }
        Ok(Some(golden))
    }

    /// Whether a node of the graph is the graph in that file.
    fn uses(&self, file: &Path) -> bool {
        let folder = self.file.parent().unwrap_or(&self.file);
        let mut bodies = self.document.nodes.values().map(|node| &node.body);
        bodies.any(|body| matches!(body, Body::Graph { path } if folder.join(path) == file))
    }

    /// Runs the graph twice in this process on a cache in memory.
    fn expect_equal_in_memory(&self, registry: &Registry, cold: &Run, out: &Path) -> Result<()> {
        let base_dir = self.file.parent().map_or_else(PathBuf::new, Path::to_owned);
        let options = CompileOptions { base_dir, overrides: Vec::new(), loader: &|path| read_file(path) };
        let compiled = compile(&self.document, registry, &options).map_err(|errors| errors.to_string())?;
        let request = Request {
            writers: compiled.graph.writers().collect(),
            outputs: compiled.outputs.values().copied().collect(),
            graph: Arc::new(compiled.graph),
            context: Context { seed: 0, resolution: None },
            out_dir: out.to_owned(),
            history: None,
        };
        let evaluator = Evaluator::new(Cache::new(2 << 30, None), 2).map_err(|error| error.to_string())?;
        let run = || evaluator.run(request.clone(), Arc::new(Silent), &CancelToken::new());
        let (first, second) = (run(), run());
        if let Some(node) = second.computed().next() {
            return Err(format!("with a warm memory cache `{}` ran again", node.name));
        }
        expect_report(cold, &first, "in one process")?;
        expect_report(cold, &second, "with a warm memory cache")?;
        same_files(&cold.out, out, "in one process")
    }
}

/// What one run of the program left behind.
struct Run {
    out: PathBuf,
    manifest: Json,
}

impl Run {
    fn new(case: &Case, jobs: &str, cache: &Path, out: &Path) -> Result<Self> {
        let (cache, out_text) = (cache.to_string_lossy(), out.to_string_lossy());
        let more = ["--json", "--quiet", "--jobs", jobs, "--cache", &cache, "--out", &out_text];
        let printed = orograph(&["run"], &case.file, &more)?;
        let manifest = serde_json::from_str(&printed).map_err(|error| format!("manifest: {error}"))?;
        Ok(Self { out: out.to_owned(), manifest })
    }

    fn nodes(&self) -> impl Iterator<Item = &Json> {
        self.manifest["nodes"].as_array().into_iter().flatten()
    }

    fn computed(&self) -> impl Iterator<Item = &str> {
        self.nodes().filter(|node| node["outcome"] == "computed").filter_map(|node| node["name"].as_str())
    }

    /// Whether the node of that name wrote a file.
    fn writes(&self, name: &str) -> bool {
        self.manifest["files"].as_array().into_iter().flatten().any(|file| file["node"] == name)
    }

    fn golden(&self) -> BTreeMap<String, Json> {
        let remembered = |node: &Json| {
            let version = format!("{}@{}", node["node"].as_str().unwrap_or("?"), node["version"]);
            let outputs = node["outputs"].as_object().filter(|outputs| !outputs.is_empty())?;
            let name = node["name"].as_str()?.to_owned();
            Some((name, serde_json::json!({"version": version, "outputs": outputs})))
        };
        self.nodes().filter_map(remembered).collect()
    }

    /// Every writer has written, and there is something to show.
    fn expect_files(&self, case: &Case) -> Result<()> {
        let files = self.manifest["files"].as_array().map_or(0, Vec::len);
        let results = self.manifest["results"].as_object().map_or(0, serde_json::Map::len);
        if files + results == 0 {
            return Err("it makes neither a file nor a table".into());
        }
        let writers = case.document.nodes.values().filter(|node| writes(&node.body)).count();
        if files < writers {
            return Err(format!("{writers} writers wrote {files} files"));
        }
        for file in self.manifest["files"].as_array().into_iter().flatten() {
            let name = file["name"].as_str().unwrap_or("?");
            let length = fs::metadata(self.out.join(name)).map_or(0, |metadata| metadata.len());
            if length == 0 || Some(length) != file["bytes"].as_u64() {
                return Err(format!("{name} has {length} bytes, the manifest says {}", file["bytes"]));
            }
        }
        Ok(())
    }

    fn expect_equal(&self, other: &Self, how: &str) -> Result<()> {
        let by_name: BTreeMap<_, _> = self.nodes().map(|node| (node["name"].as_str(), node)).collect();
        for node in other.nodes() {
            let Some(first) = by_name.get(&node["name"].as_str()) else {
                return Err(format!("{how}: another node ran: {}", node["name"]));
            };
            if first["outputs"] != node["outputs"] || first["key"] != node["key"] {
                return Err(format!("{how}: {} {} gives something else", node["node"], node["name"]));
            }
        }
        for part in ["files", "results"] {
            if self.manifest[part] != other.manifest[part] {
                return Err(format!("{how}: other {part}"));
            }
        }
        same_files(&self.out, &other.out, how)
    }
}

/// Whether nodes of that type write files.
fn writes(body: &Body) -> bool {
    let Body::Type { id, .. } = body else { return false };
    orograph_nodes::all().iter().any(|node_type| node_type.spec().id == *id && node_type.spec().writes)
}

fn expect_report(cold: &Run, report: &Report, how: &str) -> Result<()> {
    if let Some((node, error)) = report.failures().next() {
        return Err(format!("{how}: `{}` failed: {error}", node.name));
    }
    for node in &report.nodes {
        let Some(first) = cold.nodes().find(|first| first["name"] == node.name.as_str()) else { continue };
        let outputs = node.outputs.iter().map(|(name, digest)| (name.clone(), digest.to_string().into()));
        if first["outputs"] != Json::Object(outputs.collect()) {
            return Err(format!("{how}: {} `{}` gives something else", node.id, node.name));
        }
    }
    Ok(())
}

/// Runs the program and returns what it printed.
fn orograph(command: &[&str], graph: &Path, more: &[&str]) -> Result<String> {
    /// Longer than any graph takes on a busy machine: a run that hangs is to fail under its name.
    const PATIENCE: Duration = Duration::from_secs(600);
    let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_orograph"))
        .timeout(PATIENCE)
        .args(command)
        .arg(graph)
        .args(more)
        .output()
        .map_err(|error| error.to_string())?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)))
}

fn same_files(one: &Path, other: &Path, how: &str) -> Result<()> {
    let (first, second) = (files_below(one)?, files_below(other)?);
    if first.keys().ne(second.keys()) {
        return Err(format!("{how}: other files: {:?}, {:?}", first.keys(), second.keys()));
    }
    match first.iter().find(|(name, bytes)| second.get(*name) != Some(bytes)) {
        Some((name, _)) => Err(format!("{how}: other bytes in {}", name.display())),
        None => Ok(()),
    }
}

/// The bytes of all files in a folder and in those in it, by path; a folder that is missing has none.
fn files_below(folder: &Path) -> Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        let Ok(entries) = fs::read_dir(&next) else { continue };
        for entry in entries {
            let path = entry.map_err(|error| error.to_string())?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let bytes = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
                files.insert(path.strip_prefix(folder).unwrap_or(&path).to_owned(), bytes);
            }
        }
    }
    Ok(files)
}

/// The graphs in a folder and in those in it, by name.
fn cases(folder: &Path) -> Result<Vec<Case>> {
    // Those in `plugins` need plugins; `plugin_examples.rs` runs them.
    let is_graph = |path: &Path| {
        path.extension().is_some_and(|extension| extension == "ron") && !path.starts_with("plugins")
    };
    let files = files_below(folder)?.into_keys().filter(|path| is_graph(path));
    files.map(|path| Case::load(folder, folder.join(path))).collect()
}

/// What differs first from what is remembered.
fn expect_golden(golden: &Golden, graph: &str, made: &BTreeMap<String, Json>) -> Result<()> {
    let hint = "if that is meant, run again with UPDATE_GOLDEN=1";
    let Some(known) = golden.get(graph) else {
        return Err(format!("it is not in graphs/golden.json; {hint}"));
    };
    for (name, node) in made {
        let Some(before) = known.get(name) else {
            return Err(format!("node `{name}` is not in graphs/golden.json; {hint}"));
        };
        if before == node {
            continue;
        }
        let version = node["version"].as_str().unwrap_or("?");
        return Err(if before["version"] == node["version"] {
            format!("node `{name}` ({version}) or one before it makes something else; {hint}")
        } else {
            format!("node `{name}` was {} and is {version} now; {hint}", before["version"])
        });
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let filters: Vec<&String> = arguments.iter().filter(|argument| !argument.starts_with('-')).collect();
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
    let golden_file = workspace.join("graphs/golden.json");
    let cases = match cases(&workspace.join("graphs")) {
        Ok(cases) => cases,
        Err(why) => {
            println!("FAILED {why}");
            return ExitCode::FAILURE;
        }
    };
    let wanted = |case: &&Case| filters.is_empty() || filters.iter().any(|text| case.name.contains(*text));
    let wanted: Vec<&Case> = cases.iter().filter(wanted).collect();
    if arguments.iter().any(|argument| argument == "--list") {
        wanted.iter().for_each(|case| println!("{}: test", case.name));
        return ExitCode::SUCCESS;
    }
    let dem = env::var_os("OROGRAPH_DEM_DIR").map_or_else(|| workspace.join("../shared/dem"), PathBuf::from);
    let has_dem = dem.is_dir();
    let (run, left_out): (Vec<&Case>, Vec<&Case>) =
        wanted.into_iter().partition(|case| has_dem || !case.needs_dem);
    let text = fs::read_to_string(&golden_file).unwrap_or_default();
    let mut golden: Golden = serde_json::from_str(&text).unwrap_or_default();
    let update = env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1");
    let results: Vec<_> = run
        .par_iter()
        .map(|case| {
            let start = Instant::now();
            let result = case.test(&cases);
            let result = result.and_then(|made| match &made {
                Some(nodes) if !update => expect_golden(&golden, &case.name, nodes).map(|()| made),
                _ => Ok(made),
            });
            match &result {
                Ok(_) => println!("ok {} in {:.1} s", case.name, start.elapsed().as_secs_f64()),
                Err(why) => println!("FAILED {}: {why}", case.name),
            }
            (&case.name, result)
        })
        .collect();
    let mut failed = results.iter().filter(|(_, result)| result.is_err()).count();
    if update {
        let made = results
            .iter()
            .filter_map(|(name, result)| Some(((*name).clone(), result.as_ref().ok()?.clone()?)));
        golden.extend(made);
        golden.retain(|name, _| cases.iter().any(|case| case.name == *name));
        let text = serde_json::to_string_pretty(&golden).unwrap_or_default() + "\n";
        if let Err(error) = fs::write(&golden_file, text) {
            println!("FAILED writing {}: {error}", golden_file.display());
            failed += 1;
        }
    }
    let passed = run.len().saturating_sub(failed);
    let mut required = false;
    if !left_out.is_empty() {
        let names: Vec<&str> = left_out.iter().map(|case| case.name.as_str()).collect();
        println!(
            "left out: {} graphs that need the DEM folder (set OROGRAPH_DEM_DIR): {}",
            names.len(),
            names.join(", ")
        );
        required = env::var_os("OROGRAPH_DEM_REQUIRED").is_some_and(|value| value == "1");
    }
    println!("{passed} passed, {failed} failed");
    if failed == 0 && !required { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
