//! Chains of nodes that run band by band, so that no value between them is ever there as a whole.
//!
//! A *section* is a group of nodes that each make or take a raster row by row: sources, local nodes and writers. Where
//! its values together are too much for the memory that a run was given, the section runs as one task: it goes down
//! the rows once, and each member computes the rows that follow those it has. What nodes outside the section need is
//! collected whole. The bits are those of a run node by node; what is given up is that values within are cached.

mod choose;
mod host;
mod section;
mod tracks;

use std::sync::Arc;

use orograph_core::{Arity, Digest, Extent, Instance, NodeSpec, NodeType, PortSpec, ValueType};

use super::{key::NodeKey, report::Outcome};
use crate::{
    cache::Record,
    graph::{Action, Graph, GraphNode, NodeId, OutputRef},
};
pub(super) use choose::Chooser;
pub(super) use section::Section;

/// The sections of a run, and the graph in which each of them is one task.
pub(super) struct Streams {
    sections: Vec<Arc<Section>>,
    /// For each node, its section and its place there.
    parts: Vec<Option<(usize, usize)>>,
    graph: Arc<Graph>,
}

/// A node's place in a section.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    /// The section.
    pub(super) section: &'a Section,
    /// Which of its members the node is.
    pub(super) member: usize,
}

impl Streams {
    /// The sections that are worth it; `stand_in` tells for each node the first one of equal recipe.
    pub(super) fn new(chooser: &Chooser<'_>) -> Self {
        let sections: Vec<_> = chooser.sections().into_iter().map(Arc::new).collect();
        let graph = &chooser.request.graph;
        let mut streams = Self { sections, parts: Vec::new(), graph: Arc::clone(graph) };
        if streams.sections.is_empty() {
            return streams;
        }
        streams.parts = vec![None; graph.nodes().len()];
        for (index, section) in streams.sections.iter().enumerate() {
            for (member, id) in section.ids().enumerate() {
                streams.parts[id.index()] = Some((index, member));
            }
        }
        streams.graph = Arc::new(streams.rewire(graph, chooser.stand_in));
        streams
    }

    /// The graph of the run's tasks.
    pub(super) fn graph(&self) -> &Arc<Graph> {
        &self.graph
    }

    /// The section that runs as the task `leader`.
    pub(super) fn section(&self, leader: NodeId) -> Option<&Section> {
        self.part(leader).map(|part| part.section).filter(|section| section.leader() == leader)
    }

    /// The place of a node in its section, when it is in one.
    pub(super) fn part(&self, node: NodeId) -> Option<Part<'_>> {
        let (section, member) = (*self.parts.get(node.index())?)?;
        Some(Part { section: &self.sections[section], member })
    }

    /// The nodes that a task runs, with what became of each when this became of the task.
    pub(super) fn members_of(&self, task: NodeId, outcome: &Outcome) -> Vec<(NodeId, Outcome)> {
        let Some(section) = self.section(task) else { return vec![(task, outcome.clone())] };
        section.ids().enumerate().map(|(member, id)| (id, section.outcome(member, outcome))).collect()
    }

    /// What is known by recipe of the nodes that a task has run: of those whose values it collected, and of writers.
    pub(super) fn records(
        &self,
        task: NodeId,
        record: &Record,
        keys: &[Option<NodeKey>],
    ) -> Vec<(Digest, Arc<Record>)> {
        let members = self.section(task).into_iter().flat_map(|section| {
            let members = section.ids().enumerate().filter(|(member, _)| section.is_whole(*member));
            members.map(|(member, id)| (id, section.record(member, record)))
        });
        members
            .filter_map(|(id, record)| Some((keys[id.index()].as_ref()?.recipe?, Arc::new(record))))
            .collect()
    }

    /// The graph with each section as one node, in the place of its leader.
    fn rewire(&self, graph: &Graph, stand_in: &[u32]) -> Graph {
        let source = |wire: &OutputRef| {
            let node = NodeId(stand_in[wire.node.index()]);
            match self.part(node) {
                Some(part) => part.section.task_output(part.member, wire.output),
                None => OutputRef { node, output: wire.output },
            }
        };
        let mut nodes = graph.nodes().to_vec();
        for node in &mut nodes {
            for wire in node.inputs.iter_mut().flatten() {
                *wire = source(wire);
            }
        }
        for section in &self.sections {
            let inputs = section.outside().iter().map(|wire| vec![source(wire)]).collect();
            let leader = &mut nodes[section.leader().index()];
            *leader = GraphNode {
                name: leader.name.clone(),
                action: action_of(section, graph),
                inputs,
                base_dirs: Vec::new(),
            };
        }
        graph.with_nodes(nodes)
    }
}

/// A section as what a node does.
fn action_of(section: &Arc<Section>, graph: &Graph) -> Action {
    let port = |wire: OutputRef| PortSpec {
        name: graph.output_name(wire).into(),
        doc: "".into(),
        value_type: graph.value_type(wire).unwrap_or(ValueType::Heightfield),
        arity: Arity::One,
    };
    let spec = NodeSpec {
        id: "section".into(),
        version: 1,
        doc: "".into(),
        inputs: section.outside().iter().map(|&wire| port(wire)).collect(),
        outputs: section.collected().map(port).collect(),
        params: Vec::new(),
        extent: Extent::Global,
        reads: Vec::new(),
        writes: section.writes(),
        default_writer: false,
    };
    let instance: Arc<dyn Instance> = Arc::clone(section) as _;
    let made = Arc::clone(&instance);
    let node_type = NodeType::new(spec, move |_| Ok(Arc::clone(&made)), |_, _| Ok(()));
    Action::Run {
        node_type: Arc::new(node_type),
        values: Vec::new(),
        instance,
        fixed: section.key().settings,
    }
}
