//! The checked graph: typed, acyclic, flat. What evaluation reads, however it came about.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use indexmap::IndexMap;
use orograph_core::{
    Arity, Digest, Error, Hasher, Instance, NodeSpec, NodeType, ParamKind, ParamValue, PortSpec, ValueType,
};
use petgraph::{
    algo::{kosaraju_scc, toposort},
    graph::{DiGraph, NodeIndex},
};

use crate::compile::expand_path;

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
        let params = node_type.spec().params.iter().zip(values).zip(&self.base_dirs);
        params
            .filter(|((spec, _), _)| spec.kind == ParamKind::InputPath)
            .find(|((_, value), _)| matches!(value, ParamValue::Text(path) if path == text))
            .map_or(Path::new(""), |(_, base_dir)| base_dir)
    }

    /// Where the file that `text` among the settings names lies, with variables of the environment filled in.
    ///
    /// # Errors
    /// As [`expand_path`].
    pub fn input_path(&self, text: &str) -> Result<PathBuf, Error> {
        expand_path(text, self.base_dir(text), &|name| std::env::var(name).ok())
            .map_err(|error| Error::invalid(error.to_string(), error.hint()))
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

    /// The files that a writer is to write, relative to the output folder.
    pub fn files_of(&self, writer: NodeId) -> impl Iterator<Item = &str> {
        let (params, values) = match &self.node(writer).action {
            Action::Run { node_type, values, .. } => (node_type.spec().params.as_slice(), values.as_slice()),
            Action::Missing(_) => (&[][..], &[][..]),
        };
        params.iter().zip(values).filter_map(|(param, value)| match (&param.kind, value) {
            (ParamKind::OutputPath, ParamValue::Text(file)) => Some(file.as_str()),
            _ => None,
        })
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

/// Puts a [`Graph`] together, refusing each part that does not fit as it comes.
#[derive(Default)]
pub struct GraphBuilder {
    nodes: Vec<GraphNode>,
    names: IndexMap<String, NodeId>,
}

impl GraphBuilder {
    /// An empty builder.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a node with settings in its spec's order.
    ///
    /// # Errors
    /// [`GraphError::DuplicateName`] or [`GraphError::Param`].
    pub fn add(
        &mut self,
        name: &str,
        node_type: &Arc<NodeType>,
        values: Vec<ParamValue>,
    ) -> Result<NodeId, GraphError> {
        let instance =
            node_type.instantiate(&values).map_err(|error| GraphError::Param { node: name.into(), error })?;
        let fixed = fixed_key(node_type.spec(), &values);
        let n_inputs = node_type.spec().inputs.len();
        self.push(name, Action::Run { node_type: Arc::clone(node_type), values, instance, fixed }, n_inputs)
    }

    /// Tells, for each parameter of `node`, the folder that relative input paths start from.
    pub fn set_base_dirs(&mut self, node: NodeId, base_dirs: Vec<Arc<Path>>) {
        self.nodes[node.index()].base_dirs = base_dirs;
    }

    /// The name of a node.
    #[must_use]
    pub fn name(&self, node: NodeId) -> &str {
        &self.nodes[node.index()].name
    }

    /// Adds all of `graph`, its nodes named `prefix/name`. Its node `i` becomes the builder's `first + i`, where
    /// `first` is what this returns.
    ///
    /// # Errors
    /// [`GraphError::DuplicateName`].
    pub fn absorb(&mut self, graph: Graph, prefix: &str) -> Result<u32, GraphError> {
        let first = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        for mut node in graph.nodes {
            node.name = format!("{prefix}/{}", node.name);
            for wire in node.inputs.iter_mut().flatten() {
                wire.node.0 += first;
            }
            let id = NodeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
            if self.names.insert(node.name.clone(), id).is_some() {
                return Err(GraphError::DuplicateName { name: node.name });
            }
            self.nodes.push(node);
        }
        Ok(first)
    }

    /// Adds a placeholder for a node whose type is unknown here.
    ///
    /// # Errors
    /// [`GraphError::DuplicateName`].
    pub fn add_missing(&mut self, name: &str, missing: Missing) -> Result<NodeId, GraphError> {
        self.push(name, Action::Missing(missing), 0)
    }

    fn push(&mut self, name: &str, action: Action, n_inputs: usize) -> Result<NodeId, GraphError> {
        if self.names.contains_key(name) {
            return Err(GraphError::DuplicateName { name: name.into() });
        }
        let id = NodeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        self.nodes.push(GraphNode {
            name: name.into(),
            action,
            inputs: vec![Vec::new(); n_inputs],
            base_dirs: Vec::new(),
        });
        self.names.insert(name.into(), id);
        Ok(id)
    }

    /// Wires output port `output` of `from` to input port `input` of `to`, after the wires already there. A
    /// wire from or to a missing node is taken on trust.
    ///
    /// # Errors
    /// [`GraphError::UnknownPort`], [`GraphError::TypeMismatch`] or [`GraphError::TooManyWires`].
    pub fn connect(&mut self, from: NodeId, output: &str, to: NodeId, input: &str) -> Result<(), GraphError> {
        let source = self.output(from, output)?;
        self.wire(source, to, input)
    }

    /// As [`connect`](Self::connect), from an output already found.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub fn wire(&mut self, source: OutputRef, to: NodeId, input: &str) -> Result<(), GraphError> {
        let target = &self.nodes[to.index()];
        let Some(spec) = target.spec() else {
            // A placeholder has no ports, but a cycle through it is still a cycle.
            self.nodes[to.index()].inputs.push(vec![source]);
            return Ok(());
        };
        let port = find(&target.name, "input", &spec.inputs, input)?;
        let (value_type, arity) = (spec.inputs[port].value_type, spec.inputs[port].arity);
        let from = &self.nodes[source.node.index()];
        let given = from.spec().and_then(|spec| spec.outputs.get(source.output as usize));
        if let Some(given) = given.filter(|given| given.value_type != value_type) {
            return Err(GraphError::TypeMismatch {
                from: format!("{}.{}", from.name, given.name),
                from_type: given.value_type,
                to: format!("{}.{input}", target.name),
                to_type: value_type,
            });
        }
        let wires = &self.nodes[to.index()].inputs[port];
        if arity != Arity::Many && !wires.is_empty() {
            return Err(GraphError::TooManyWires {
                to: format!("{}.{input}", self.nodes[to.index()].name),
                count: wires.len() + 1,
            });
        }
        self.nodes[to.index()].inputs[port].push(source);
        Ok(())
    }

    /// The output port of that name.
    ///
    /// # Errors
    /// [`GraphError::UnknownPort`].
    pub fn output(&self, node: NodeId, port: &str) -> Result<OutputRef, GraphError> {
        let source = &self.nodes[node.index()];
        let index = match source.spec() {
            Some(spec) => find(&source.name, "output", &spec.outputs, port)?,
            None => 0,
        };
        Ok(OutputRef { node, output: u32::try_from(index).unwrap_or(u32::MAX) })
    }

    /// The graph, when every needed input is wired and there is no cycle.
    ///
    /// # Errors
    /// [`GraphError::Unconnected`] or [`GraphError::Cycle`].
    pub fn build(self) -> Result<Graph, GraphError> {
        let mut dag = DiGraph::<(), (), u32>::with_capacity(self.nodes.len(), self.nodes.len());
        for _ in &self.nodes {
            dag.add_node(());
        }
        for (to, node) in self.nodes.iter().enumerate() {
            if let Some(spec) = node.spec() {
                for (port, wires) in spec.inputs.iter().zip(&node.inputs) {
                    if port.arity == Arity::One && wires.is_empty() {
                        return Err(GraphError::Unconnected {
                            to: format!("{}.{}", node.name, port.name),
                            value_type: port.value_type,
                        });
                    }
                }
            }
            for wire in node.inputs.iter().flatten() {
                dag.add_edge(NodeIndex::new(wire.node.index()), NodeIndex::new(to), ());
            }
        }
        let Ok(order) = toposort(&dag, None) else {
            return Err(GraphError::Cycle { path: self.cycle(&dag) });
        };
        let order = order.into_iter().map(|index| NodeId(index.index() as u32)).collect();
        Ok(Graph { nodes: self.nodes, order, names: self.names })
    }

    /// Names along one cycle, along the wires, starting at its first node in the document.
    fn cycle(&self, dag: &DiGraph<(), (), u32>) -> Vec<String> {
        let on_cycle = |component: &Vec<NodeIndex>| {
            component.len() > 1 || component.iter().any(|&node| dag.contains_edge(node, node))
        };
        // Unlike Tarjan's, this one does not recurse, so a long cycle cannot exhaust the stack.
        let components = kosaraju_scc(dag);
        let Some(component) =
            components.iter().filter(|c| on_cycle(c)).min_by_key(|c| c.iter().min().copied())
        else {
            return Vec::new();
        };
        let Some(&start) = component.iter().min() else { return Vec::new() };
        let mut inside = vec![false; self.nodes.len()];
        component.iter().for_each(|node| inside[node.index()] = true);
        // Breadth first from the start back to itself, inside the component: a shortest cycle.
        let mut previous = vec![None; self.nodes.len()];
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(node) = queue.pop_front() {
            let mut next: Vec<_> = dag.neighbors(node).filter(|n| inside[n.index()]).collect();
            next.sort_unstable();
            for target in next {
                if target == start {
                    let mut path = vec![start];
                    let mut at = Some(node);
                    while let Some(step) = at.filter(|step| *step != start) {
                        path.push(step);
                        at = previous[step.index()];
                    }
                    path.push(start);
                    path.reverse();
                    return path.iter().map(|index| self.nodes[index.index()].name.clone()).collect();
                }
                if previous[target.index()].is_none() {
                    previous[target.index()] = Some(node);
                    queue.push_back(target);
                }
            }
        }
        Vec::new()
    }
}

fn fixed_key(spec: &NodeSpec, values: &[ParamValue]) -> Digest {
    let mut hasher = Hasher::new("orograph settings 1");
    hasher.text(&spec.id).number(u64::from(spec.version));
    for (_, value) in spec.params.iter().zip(values).filter(|(param, _)| param.kind != ParamKind::InputPath) {
        value.feed(&mut hasher);
    }
    hasher.finish()
}

fn find(node: &str, side: &'static str, ports: &[PortSpec], name: &str) -> Result<usize, GraphError> {
    ports.iter().position(|port| port.name == name).ok_or_else(|| GraphError::UnknownPort {
        node: node.into(),
        side,
        port: name.into(),
        known: ports.iter().map(|port| port.name.to_string()).collect(),
    })
}
