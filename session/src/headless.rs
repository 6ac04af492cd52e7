//! A graph file run whole by a program, for what it wrote and the tables that it names.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use orograph_core::{Context, Table, Value};
use orograph_engine::{
    CancelToken, CompileOptions, Document, Evaluator, Registry, Report, compile, document::read_file,
    eval::Silent,
};

use crate::{Error, Targets};

/// What a run of a graph file gave.
pub struct Ran {
    /// The graph.
    pub document: Document,
    /// The tables among its named outputs, in their order.
    pub tables: Vec<(String, Arc<Table>)>,
    /// What became of each node.
    pub report: Report,
}

/// Runs the graph in `file` into `out`, with `overrides` as `--set` has them, and waits for its end.
///
/// # Errors
/// When the graph is wrong or a node failed.
pub fn run(
    file: &Path,
    overrides: Vec<(String, String)>,
    out: &Path,
    registry: &Registry,
    evaluator: &Evaluator,
) -> Result<Ran, Error> {
    let document = Document::load(file)?;
    let base_dir = file.parent().map_or_else(PathBuf::new, Path::to_owned);
    let compiled = compile(
        &document,
        registry,
        &CompileOptions { base_dir, overrides, loader: &|path| read_file(path) },
    )?;
    let targets = Targets::choose(compiled, &[], registry)?;
    let names: Vec<String> = targets.values.iter().map(|(name, _)| name.clone()).collect();
    let request = targets.into_request(Context::default(), out.to_owned(), None);
    let report = evaluator.run(request, Arc::new(Silent), &CancelToken::new());
    if let Some((node, error)) = report.failures().next() {
        return Err(Error::Failed(format!("{}: node `{}`: {error}", file.display(), node.name)));
    }
    let tables = names.into_iter().zip(&report.values).filter_map(|(name, value)| match value {
        Some(Value::Table(table)) => Some((name, table.clone())),
        _ => None,
    });
    Ok(Ran { document, tables: tables.collect(), report })
}
