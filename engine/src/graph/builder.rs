//! Putting a graph together: names, ports, wires, and the order without cycles.

use std::{path::Path, sync::Arc};

use indexmap::IndexMap;
use orograph_core::{Arity, Digest, Hasher, NodeType, ParamKind, ParamValue, PortSpec};
use petgraph::{
    algo::{kosaraju_scc, toposort},
    graph::{DiGraph, NodeIndex},
};

use super::{Action, Graph, GraphError, GraphNode, Missing, NodeId, OutputRef};

/// Puts a [`Graph`] together, refusing each part that does not fit as it comes.
#[derive(Default)]
pub struct GraphBuilder {
    pub(super) nodes: Vec<GraphNode>,
    pub(super) names: IndexMap<String, NodeId>,
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
        let fixed = fixed_key(node_type, &values);
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

fn fixed_key(node_type: &NodeType, values: &[ParamValue]) -> Digest {
    let spec = node_type.spec();
    let mut hasher = Hasher::new("orograph settings 1");
    hasher.text(&spec.id).number(u64::from(spec.version));
    if let Some(code) = node_type.code() {
        hasher.digest(code);
    }
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
