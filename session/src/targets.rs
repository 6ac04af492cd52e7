//! What a run is to make of a graph.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use indexmap::IndexSet;
use orograph_core::{Context, ParamKind, ParamValue, ValueType};
use orograph_engine::{Compiled, Graph, GraphError, NodeId, OutputRef, Registry, Request};

use crate::Error;

/// What a run is to make of a graph: files, and values to be shown.
pub struct Targets {
    /// The graph, with a writer added for each raster that was asked for and has none.
    pub graph: Graph,
    /// The writers to run.
    pub writers: Vec<NodeId>,
    /// Tables and scalars with the names that they were asked for by.
    pub values: Vec<(String, OutputRef)>,
}

impl Targets {
    /// The outputs asked for, or every writer and every named table; a raster without a writer gets one.
    ///
    /// # Errors
    /// [`Error::Graph`] for an output that there is none of or that needs a placeholder, and [`Error::Refused`] when
    /// there is nothing to make, nothing writes such a value, or two writers would write one file.
    pub fn choose(compiled: Compiled, asked: &[String], registry: &Registry) -> Result<Self, Error> {
        let mut writers = Vec::new();
        let mut wanted: Vec<(String, OutputRef)> = Vec::new();
        if asked.is_empty() {
            writers.extend(compiled.graph.writers());
            let alone = writers.is_empty();
            wanted.extend(
                compiled
                    .outputs
                    .iter()
                    .filter(|(_, output)| alone || is_shown(&compiled.graph, **output))
                    .map(|(name, output)| (name.clone(), *output)),
            );
            if alone && wanted.is_empty() {
                return Err(Error::refused(
                    "the graph writes nothing and names no outputs",
                    "ask for an output, such as `node.port`, or add a node that writes a file",
                ));
            }
        }
        let asked: IndexSet<_> = asked.iter().collect();
        for name in asked {
            match compiled.graph.find(name) {
                Some(id) if compiled.graph.node(id).spec().is_some_and(|spec| spec.writes) => {
                    writers.push(id)
                }
                _ => wanted.push((name.clone(), compiled.output(name)?)),
            }
        }
        let roots = writers.iter().copied().chain(wanted.iter().map(|(_, output)| output.node));
        refuse_missing(&compiled, roots, |_| false)?;
        let (values, rasters): (Vec<_>, Vec<_>) =
            wanted.into_iter().partition(|(_, output)| is_shown(&compiled.graph, *output));
        let mut targets = Self { graph: compiled.graph, writers, values };
        for (name, output) in rasters {
            targets.add_writer(&name, output, registry)?;
        }
        targets.refuse_clash()?;
        Ok(targets)
    }

    fn add_writer(&mut self, name: &str, output: OutputRef, registry: &Registry) -> Result<(), Error> {
        // Nodes of unknown type were refused before.
        let Some(value_type) = self.graph.value_type(output) else { return Ok(()) };
        let writer = registry.iter().find(|node_type| {
            let spec = node_type.spec();
            spec.default_writer && spec.inputs.first().is_some_and(|port| port.value_type == value_type)
        });
        let Some(writer) = writer else {
            return Err(Error::refused(
                format!("`{name}` is a {value_type}, which no node writes by default"),
                "add a node that turns it into something to write",
            ));
        };
        let spec = writer.spec();
        let values = spec
            .params
            .iter()
            .map(|param| match (&param.kind, &param.default) {
                (ParamKind::OutputPath, ParamValue::Text(file)) => {
                    let extension = file.rsplit_once('.').map_or("bin", |(_, extension)| extension);
                    ParamValue::Text(format!("{}.{extension}", name.replace('/', "-")))
                }
                (_, default) => default.clone(),
            })
            .collect();
        let mut builder = std::mem::take(&mut self.graph).into_builder();
        let wrong = |error: GraphError| Error::Failed(error.to_string());
        let id = builder.add(&format!("write {name}"), writer, values).map_err(wrong)?;
        builder.wire(output, id, &spec.inputs[0].name).map_err(wrong)?;
        self.graph = builder.build().map_err(wrong)?;
        self.writers.push(id);
        Ok(())
    }

    fn refuse_clash(&self) -> Result<(), Error> {
        let Some((first, second, file)) = self.graph.clash(&self.writers) else { return Ok(()) };
        let name = |id: NodeId| &self.graph.node(id).name;
        Err(Error::refused(
            format!("`{}` and `{}` would both write {file}", name(first), name(second)),
            "give one of them another `file`",
        ))
    }

    /// The request for all this, whose report gives [`values`](Self::values) in their order. `history` names the graph's
    /// history; see [`history`].
    #[must_use]
    pub fn into_request(self, context: Context, out_dir: PathBuf, history: Option<String>) -> Request {
        Request {
            graph: Arc::new(self.graph),
            outputs: self.values.iter().map(|(_, output)| *output).collect(),
            writers: self.writers,
            context,
            out_dir,
            history,
        }
    }
}

/// The name of the history of the graph file at `path`, the same from whichever folder and program it is run.
#[must_use]
pub fn history(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

/// Whether an output is shown as text, and not written to a file.
#[must_use]
pub fn is_shown(graph: &Graph, output: OutputRef) -> bool {
    graph.value_type(output).is_some_and(|value_type| {
        matches!(
            value_type,
            ValueType::Table | ValueType::Number | ValueType::Integer | ValueType::Boolean | ValueType::Text
        )
    })
}

/// Refuses a graph in which one of `roots` needs a placeholder, unless its name is excused.
///
/// # Errors
/// [`Error::Graph`], with the placeholder's place in the file.
pub fn refuse_missing(
    compiled: &Compiled,
    roots: impl IntoIterator<Item = NodeId>,
    excused: impl Fn(&str) -> bool,
) -> Result<(), Error> {
    let graph = &compiled.graph;
    let mut stack: Vec<_> = roots.into_iter().collect();
    let mut seen = vec![false; graph.nodes().len()];
    while let Some(id) = stack.pop() {
        if std::mem::replace(&mut seen[id.index()], true) {
            continue;
        }
        if let Some(error) = compiled.missing.get(&id).filter(|_| !excused(&graph.node(id).name)) {
            return Err(error.clone().into());
        }
        stack.extend(graph.node(id).inputs.iter().flatten().map(|wire| wire.node));
    }
    Ok(())
}
