//! `orograph run`: the outputs of a graph, as files, tables and a manifest.

use std::sync::Arc;

use orograph_core::Value;
use orograph_engine::{
    CancelToken, Compiled, Evaluator, Observer, Outcome, Registry, Report, Request,
    cache::Tier,
    eval::{OutputFolder, Planned},
};
use orograph_session::{Targets, memory, targets::history};

use super::{
    each::{self, Item},
    watch,
};
use crate::{
    arguments::RunOptions,
    console,
    failure::Failure,
    manifest::{manifest, value_text},
    progress, session,
    trace::Trace,
};

pub(crate) fn run(options: &RunOptions) -> Result<(), Failure> {
    if options.watch {
        return watch::run(options);
    }
    let registry = session::registry(&options.evaluation.plugins, options.evaluation.cache.as_deref())?;
    let items = each::items(options)?;
    let cancel = session::cancel_on_signal();
    // A graph that is wrong is refused before any folder is made.
    let mut evaluator = None;
    let (n, mut failed) = (items.len(), 0);
    for Item { file, options } in items {
        if let Some(file) = file.filter(|_| !options.evaluation.quiet) {
            console::note(&format!("{}:", file.display()));
        }
        let run = session::load(&options.settings, &registry)
            .and_then(|compiled| once(compiled, &options, &registry, &mut evaluator, &cancel));
        match run {
            // The other files may do.
            Err(Failure::Node) if n > 1 => failed += 1,
            other => other?,
        }
    }
    if failed > 0 {
        console::error(&format!("{failed} of {n} files failed"));
        return Err(Failure::Node);
    }
    Ok(())
}

/// Runs a graph once; the evaluator is started when the graph proves sound.
pub(super) fn once(
    compiled: Compiled,
    options: &RunOptions,
    registry: &Registry,
    evaluator: &mut Option<Evaluator>,
    cancel: &CancelToken,
) -> Result<(), Failure> {
    let targets = Targets::choose(compiled, &options.outputs, registry)?;
    let evaluator = match evaluator {
        Some(evaluator) => evaluator,
        None => evaluator.insert(session::evaluator(&options.evaluation)?),
    };
    let names: Vec<String> = targets.values.iter().map(|(name, _)| name.clone()).collect();
    let evaluation = &options.evaluation;
    let history = history(&options.settings.graph);
    let request = targets.into_request(session::context(evaluation), evaluation.out.clone(), Some(history));
    if options.dry_run {
        tell_plan(evaluator, &request, options.json);
        return Ok(());
    }
    if !request.writers.is_empty() {
        OutputFolder::new(&evaluation.out).look().map_err(|why| {
            let message = format!("nothing can be written into {}: {why}", evaluation.out.display());
            Failure::usage(message, "name another folder with --out")
        })?;
    }
    let (observer, bar) = progress::observer(options.evaluation.quiet);
    let trace = options.trace.is_some().then(|| Arc::new(Trace::new(Arc::clone(&observer))));
    let observer = trace.clone().map_or(observer, |trace| trace as Arc<dyn Observer>);
    let report = evaluator.run(request, observer, cancel);
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    evaluator.flush();
    if let Some(reason) = evaluator.cache().take_disk_failure() {
        console::note(&format!("warning: results are kept in memory alone from here on: {reason}"));
    }
    let results: Vec<_> = names.into_iter().zip(report.values.iter().cloned()).collect();
    if let (Some(trace), Some(file)) = (trace, &options.trace) {
        trace.save(file, &report)?;
    }
    tell_report(&report, options);
    tell_results(&report, &results, options);
    if report.was_cancelled() {
        return Err(Failure::Cancelled);
    }
    if report.counts().failed > 0 { Err(Failure::Node) } else { Ok(()) }
}

fn tell_plan(evaluator: &Evaluator, request: &Request, json: bool) {
    let rows: Vec<[String; 3]> = evaluator
        .plan(request)
        .into_iter()
        .map(|(id, planned)| {
            let node = request.graph.node(id);
            let word = match planned {
                Planned::Hit(Tier::Memory) => "in memory",
                Planned::Hit(Tier::Disk) => "in the cache",
                Planned::Run => "to compute",
                Planned::Blocked => "blocked",
            };
            [node.name.clone(), node.spec().map_or("", |spec| spec.id.as_ref()).to_owned(), word.to_owned()]
        })
        .collect();
    if json {
        let nodes: Vec<_> = rows
            .iter()
            .map(|[name, node, plan]| serde_json::json!({"name": name, "node": node, "plan": plan}))
            .collect();
        console::result(&serde_json::json!({"status": "planned", "nodes": nodes}).to_string());
        return;
    }
    console::result(&console::columns(&rows.into_iter().map(Vec::from).collect::<Vec<_>>()));
}

/// Failures, warnings, and what `--explain` and `--timings` ask for.
fn tell_report(report: &Report, options: &RunOptions) {
    for node in &report.nodes {
        for warning in node.warnings.iter().filter(|_| !options.evaluation.quiet) {
            console::note(&format!("{}: {warning}", node.name));
        }
    }
    console::failures(report);
    if options.explain {
        let rows: Vec<_> = report
            .nodes
            .iter()
            .map(|node| {
                let why = match &node.outcome {
                    Outcome::Computed | Outcome::Streamed => node.reason.clone().unwrap_or_default(),
                    Outcome::Hit(_) if node.files.is_empty() => "its recipe is known".into(),
                    Outcome::Hit(_) => "its files are in place".into(),
                    Outcome::Cutoff(_) => "its inputs turned out as in an earlier run".into(),
                    Outcome::Failed(error) => error.to_string(),
                    Outcome::Skipped { because } => format!("`{because}` failed"),
                };
                vec![node.outcome.word().to_owned(), node.name.clone(), why]
            })
            .collect();
        console::note(&console::columns(&rows));
    }
    if options.timings {
        let mut nodes: Vec<_> = report.computed().collect();
        nodes.sort_by(|a, b| b.micros.cmp(&a.micros).then_with(|| a.name.cmp(&b.name)));
        let rows: Vec<_> = nodes
            .iter()
            .map(|node| {
                let time = format!("{:9.3} ms", node.micros as f64 / 1e3);
                vec![time, memory::text(node.bytes), node.name.clone(), node.id.clone()]
            })
            .collect();
        if !rows.is_empty() {
            console::note(&console::columns(&rows));
        }
    }
}

fn tell_results(report: &Report, results: &[(String, Option<Value>)], options: &RunOptions) {
    if options.json {
        let manifest = manifest(report, results);
        let text = match options.each {
            Some(_) => serde_json::to_string(&manifest),
            None => serde_json::to_string_pretty(&manifest),
        };
        let text = text.unwrap_or_default();
        console::result(&text);
        return;
    }
    for (name, value) in results {
        if let Some(text) = value.as_ref().and_then(value_text) {
            console::result(&format!("{name}:"));
            for line in text.lines() {
                console::result(&format!("  {line}"));
            }
        }
    }
    for file in report.nodes.iter().flat_map(|node| &node.files) {
        console::result(&options.evaluation.out.join(&file.name).display().to_string());
    }
    if !options.evaluation.quiet {
        let counts = report.counts();
        console::note(&format!(
            "{} computed, {} found in the cache{}{}",
            counts.computed,
            counts.hits,
            if counts.failed > 0 { format!(", {} failed", counts.failed) } else { String::new() },
            if counts.skipped > 0 { format!(", {} skipped", counts.skipped) } else { String::new() },
        ));
    }
}
