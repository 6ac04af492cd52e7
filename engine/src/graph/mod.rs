//! The checked graph: typed, acyclic, flat. What evaluation reads, however it came about.

mod builder;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use indexmap::IndexMap;
use orograph_core::{
    Digest, Error, Instance, NodeSpec, NodeType, ParamKind, ParamSpec, ParamValue, ValueType,
};

pub use builder::GraphBuilder;

use crate::{cache::files::is_there, compile::expand_path};

/// A node of a [`Graph`]: its index in [`Graph::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

impl NodeId {
    /// As an index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// An output of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OutputRef {
    /// The node.
    pub node: NodeId,
    /// Which of its outputs, in its spec's order.
    pub output: u32,
}

/// A node whose type is unknown here, kept as a placeholder: it is refused when an output needs it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The node type's id.
    pub id: String,
    /// Why there is none, as a sentence with its mend.
    pub reason: String,
}

/// What a node does.
#[derive(Clone)]
pub enum Action {
    /// It runs.
    Run {
        /// Its type.
        node_type: Arc<NodeType>,
        /// Its settings, in the spec's order, checked.
        values: Vec<ParamValue>,
        /// It, ready to run.
        instance: Arc<dyn Instance>,
        /// Digest of type, version and settings, files left out: the part of its key that no run changes.
        fixed: Digest,
    },
    /// It cannot run here.
    Missing(Missing),
}

/// One node of a [`Graph`].
#[derive(Clone)]
pub struct GraphNode {
    /// Its name in the document; nodes inside a subgraph are `outer/inner`.
    pub name: String,
    /// What it does.
    pub action: Action,
    /// For each input port, the outputs wired to it.
    pub inputs: Vec<Vec<OutputRef>>,
    /// For each parameter, the folder that a relative input path in it starts from; empty for a graph that
    /// was put together in code.
    pub base_dirs: Vec<Arc<Path>>,
}

impl GraphNode {
    /// The spec, unless the type is missing.
    #[must_use]
    pub fn spec(&self) -> Option<&NodeSpec> {
        match &self.action {
            Action::Run { node_type, .. } => Some(node_type.spec()),
            Action::Missing(_) => None,
        }
    }

    /// The folder that the relative input path `text` among the settings starts from.
    #[must_use]
    pub fn base_dir(&self, text: &str) -> &Path {
        let Action::Run { node_type, values, .. } = &self.action else { return Path::new("") };
        let named = node_type.spec().input_files(values).find(|(_, name)| *name == text);
        named.and_then(|(param, _)| self.base_dirs.get(param)).map_or(Path::new(""), |base_dir| base_dir)
    }

    /// The files that it reads: each parameter that names one, and the name, which
    /// [`input_path`](Self::input_path) takes.
    pub fn input_files(&self) -> impl Iterator<Item = (&ParamSpec, &str)> {
        let run = match &self.action {
            Action::Run { node_type, values, .. } => Some((node_type.spec(), values)),
            Action::Missing(_) => None,
        };
        run.into_iter().flat_map(|(spec, values)| {
            spec.input_files(values).map(|(param, name)| (&spec.params[param], name))
        })
    }

    /// Where the file that `text` among the settings names lies, with variables of the environment filled in.
    ///
    /// # Errors
    /// As [`expand_path`].
    pub fn input_path(&self, text: &str) -> Result<PathBuf, Error> {
        expand_path(text, self.base_dir(text), &|name| std::env::var(name).ok())
            .map_err(|error| Error::invalid(error.to_string(), error.hint()))
    }

    /// Where the file `name` beside the input file that `text` among the settings names lies; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a file that is none of its [`companions`](Self::companions).
    pub(crate) fn companion(&self, text: &str, name: &str) -> Result<Option<PathBuf>, Error> {
        let named = self.companions(&self.input_path(text)?)?.into_iter().find(|(other, _)| other == name);
        let Some((_, path)) = named else {
            let message = format!("the node does not declare that it reads `{name}` beside `{text}`");
            return Err(Error::invalid(message, "report it to the node's author"));
        };
        Ok(is_there(&path)?.then_some(path))
    }

    /// The files that it is to write, relative to the output folder.
    pub fn output_files(&self) -> impl Iterator<Item = &str> {
        let (params, values) = match &self.action {
            Action::Run { node_type, values, .. } => (node_type.spec().params.as_slice(), values.as_slice()),
            Action::Missing(_) => (&[][..], &[][..]),
        };
        params.iter().zip(values).filter_map(|(param, value)| match (&param.kind, value) {
            (ParamKind::OutputPath, ParamValue::Text(file)) => Some(file.as_str()),
            _ => None,
        })
    }

    /// The files beside the input file `path` that the node would read, too: their names, and where each would lie.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a name that leaves the file's folder.
    pub fn companions(&self, path: &Path) -> Result<Vec<(String, PathBuf)>, Error> {
        let Action::Run { instance, .. } = &self.action else { return Ok(Vec::new()) };
        let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let beside = |name: String| {
            if Path::new(&name).file_name() != Some(name.as_ref()) {
                let message = format!("the node names `{name}` as a file beside `{file}`");
                return Err(Error::invalid(message, "report it to the node's author"));
            }
            let path = path.with_file_name(&name);
            Ok((name, path))
        };
        instance.companions(&file).into_iter().map(beside).collect()
    }
}

/// A graph ready to evaluate: every wire joins ports of one type, and there is no cycle.
#[derive(Clone, Default)]
pub struct Graph {
    nodes: Vec<GraphNode>,
    order: Vec<NodeId>,
    names: IndexMap<String, NodeId>,
}

/// Why nodes and wires make no graph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GraphError {
    /// Two nodes share a name.
    #[error("two nodes are named `{name}`")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A parameter is refused.
    #[error("node `{node}`: {error}")]
    Param {
        /// The node's name.
        node: String,
        /// Why.
        error: Error,
    },
    /// A node has no such port.
    #[error("node `{node}` has no {side} `{port}`")]
    UnknownPort {
        /// The node's name.
        node: String,
        /// `input` or `output`.
        side: &'static str,
        /// The port asked for.
        port: String,
        /// The ports that it has.
        known: Vec<String>,
    },
    /// A wire joins ports of different types.
    #[error("`{from}` gives a {from_type}, but `{to}` takes a {to_type}")]
    TypeMismatch {
        /// `node.port` where the wire starts.
        from: String,
        /// Its type.
        from_type: ValueType,
        /// `node.port` where the wire ends.
        to: String,
        /// Its type.
        to_type: ValueType,
    },
    /// An input that takes one wire was given more.
    #[error("`{to}` takes one wire, but has {count}")]
    TooManyWires {
        /// `node.port`.
        to: String,
        /// How many.
        count: usize,
    },
    /// An input that is needed has no wire.
    #[error("`{to}` is not connected, but needs a {value_type}")]
    Unconnected {
        /// `node.port`.
        to: String,
        /// The type that it takes.
        value_type: ValueType,
    },
    /// Nodes depend on themselves.
    #[error("a cycle: {}", around(.path))]
    Cycle {
        /// Names along the cycle; the last is the first again.
        path: Vec<String>,
    },
}

/// A path in a message; a long one without its middle.
fn around(path: &[String]) -> String {
    const ENDS: usize = 8;
    if path.len() <= 2 * ENDS + 1 {
        return path.join(" → ");
    }
    let (first, last) = (&path[..ENDS], &path[path.len() - ENDS..]);
    let left_out = path.len() - 2 * ENDS;
    format!("{} → ({left_out} more) → {}", first.join(" → "), last.join(" → "))
}

impl Graph {
    /// The nodes; their order means nothing.
    #[must_use]
    pub fn nodes(&self) -> &[GraphNode] {
        &self.nodes
    }

    /// One node.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &GraphNode {
        &self.nodes[id.index()]
    }

    /// Every node after all that it depends on; among independent ones, as they were added.
    #[must_use]
    pub fn order(&self) -> &[NodeId] {
        &self.order
    }

    /// The node of that name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<NodeId> {
        self.names.get(name).copied()
    }

    /// All names, in the order in which the nodes were added.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.keys().map(String::as_str)
    }

    /// The nodes that write files, in the order in which they were added.
    pub fn writers(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.names.values().copied().filter(|id| self.node(*id).spec().is_some_and(|spec| spec.writes))
    }

    /// Takes the graph apart again, to add to it.
    #[must_use]
    pub fn into_builder(self) -> GraphBuilder {
        GraphBuilder { nodes: self.nodes, names: self.names }
    }

    /// The same graph with other nodes in the places of its own, which keep their names.
    pub(crate) fn with_nodes(&self, nodes: Vec<GraphNode>) -> Self {
        Self { nodes, order: self.order.clone(), names: self.names.clone() }
    }

    /// The files that a writer is to write, relative to the output folder.
    pub fn files_of(&self, writer: NodeId) -> impl Iterator<Item = &str> {
        self.node(writer).output_files()
    }

    /// Two of `writers` that would write one file, and its name.
    #[must_use]
    pub fn clash(&self, writers: &[NodeId]) -> Option<(NodeId, NodeId, String)> {
        let mut files: IndexMap<&str, NodeId> = IndexMap::new();
        for &writer in writers {
            for file in self.files_of(writer) {
                if let Some(first) = files.insert(file, writer).filter(|first| *first != writer) {
                    return Some((first, writer, file.to_owned()));
                }
            }
        }
        None
    }

    /// The type of an output; none when its node's type is missing.
    #[must_use]
    pub fn value_type(&self, output: OutputRef) -> Option<ValueType> {
        Some(self.node(output.node).spec()?.outputs.get(output.output as usize)?.value_type)
    }

    /// `node.port` of an output.
    #[must_use]
    pub fn output_name(&self, output: OutputRef) -> String {
        let node = self.node(output.node);
        match node.spec().and_then(|spec| spec.outputs.get(output.output as usize)) {
            Some(port) => format!("{}.{}", node.name, port.name),
            None => format!("{}.{}", node.name, output.output),
        }
    }
}
