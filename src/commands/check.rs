//! `orograph check`: everything that can be known of a graph without running it.

use std::path::Path;

use orograph_engine::{Compiled, NodeId, document::GRAPH};
use orograph_session::targets::refuse_missing;

use crate::{
    arguments::{CheckOptions, GraphSettings},
    console,
    failure::Failure,
    session,
};

pub(crate) fn run(options: &CheckOptions) -> Result<(), Failure> {
    let registry = session::registry(&options.plugins, None)?;
    let mut first = None;
    for graph in &options.graphs {
        let settings = GraphSettings { graph: graph.clone(), set: options.set.clone(), vars: None };
        let checked = session::load(&settings, &registry)
            .and_then(|compiled| needs_nothing_missing(&compiled).map(|()| compiled));
        match checked {
            Ok(compiled) => {
                warn_of_files(graph, &compiled);
                warn_of_placeholders(&compiled);
                console::result(&format!("{}: {} nodes, ok", graph.display(), compiled.graph.nodes().len()));
            }
            // Every graph is looked at; the first failure ends the command.
            Err(failure) => match &first {
                None => first = Some(failure),
                Some(_) => {
                    failure.report();
                }
            },
        }
    }
    first.map_or(Ok(()), Err)
}

/// Placeholders are refused where a writer or a named output needs them. The inputs of a graph that is there to
/// be a node of others are none of them.
fn needs_nothing_missing(compiled: &Compiled) -> Result<(), Failure> {
    let named = compiled.outputs.values().map(|output| output.node);
    Ok(refuse_missing(compiled, compiled.graph.writers().chain(named), is_outer_input)?)
}

fn is_outer_input(name: &str) -> bool {
    name.split('.').next() == Some(GRAPH)
}

/// A file to read may be made later, so its absence is worth a word and no more.
fn warn_of_files(graph: &Path, compiled: &Compiled) {
    let warn = |node: &str, param: &str, what: &str| {
        console::note(&format!("warning: {}: {node}.{param}: {what}", graph.display()));
    };
    for node in compiled.graph.nodes() {
        for (param, text) in node.input_files() {
            match node.input_path(text) {
                Ok(path) if !path.is_file() => {
                    warn(&node.name, &param.name, &format!("there is no file {}", path.display()));
                }
                Ok(_) => {}
                Err(error) => warn(&node.name, &param.name, &error.to_string()),
            }
        }
    }
}

/// A node of unknown type that nothing needs stops no run, and is a slip all the same.
fn warn_of_placeholders(compiled: &Compiled) {
    let within = |id: &NodeId| !is_outer_input(&compiled.graph.node(*id).name);
    for (_, error) in compiled.missing.iter().filter(|(id, _)| within(id)) {
        console::note(&format!("warning: {error}; nothing needs it"));
        console::hint(error.help_text().unwrap_or_default());
    }
}
