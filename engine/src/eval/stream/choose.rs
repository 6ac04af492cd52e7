//! Which nodes run band by band.

use std::collections::BTreeMap;

use orograph_core::{Extent, Job, NodeSpec};

use super::{
    host::Asking,
    section::{Member, Role, Section, Wire},
};
use crate::{
    cache::Cache,
    eval::{
        Request,
        key::{NodeKey, visible_context},
        output::OutputFolder,
    },
    graph::{Action, GraphNode, NodeId, OutputRef},
};

/// Looks for sections in what a run has to do.
pub(crate) struct Chooser<'a> {
    pub(crate) request: &'a Request,
    /// The nodes that the run depends on, inputs first.
    pub(crate) wanted: &'a [NodeId],
    pub(crate) keys: &'a [Option<NodeKey>],
    /// For each node, the first one with the same recipe.
    pub(crate) stand_in: &'a [u32],
    pub(crate) cache: &'a Cache,
    pub(crate) folder: &'a OutputFolder,
}

/// What is known of a node before it runs.
#[derive(Clone, Default)]
struct Outlook {
    /// It will run.
    runs: bool,
    /// Its part in a section; none for a node that needs or makes whole values.
    role: Option<Role>,
    /// How often, on the way to it, rows became wholes or wholes rows. Members of a section are on one level, so that no
    /// way leads out of a section and back into it.
    level: u32,
    /// Cells of its rasters, as far as can be told.
    cells: u64,
    /// The first node of its group, for now.
    group: usize,
}

impl Chooser<'_> {
    /// The sections that are worth it.
    pub(crate) fn sections(&self) -> Vec<Section> {
        // Most runs end here: what is known already is looked up only where there may be something to gain.
        let all = vec![true; self.stand_in.len()];
        if self.groups(&self.outlooks(&all)).is_empty() {
            return Vec::new();
        }
        let outlooks = self.outlooks(&self.unknown());
        let groups = self.groups(&outlooks);
        let asked = self.asked_from_outside(&outlooks);
        groups.into_values().filter_map(|group| self.section(&group, &outlooks, &asked)).collect()
    }

    fn node(&self, id: NodeId) -> &GraphNode {
        self.request.graph.node(id)
    }

    /// The node that stands for the one that a wire comes from, and the output.
    fn source(&self, wire: &OutputRef) -> OutputRef {
        OutputRef { node: NodeId(self.stand_in[wire.node.index()]), output: wire.output }
    }

    fn sources(&self, id: NodeId) -> impl Iterator<Item = OutputRef> + '_ {
        self.node(id).inputs.iter().flatten().map(|wire| self.source(wire))
    }

    /// The nodes that the request names.
    fn targets(&self) -> impl Iterator<Item = NodeId> + '_ {
        let named =
            self.request.outputs.iter().map(|output| output.node).chain(self.request.writers.iter().copied());
        named.map(|id| NodeId(self.stand_in[id.index()]))
    }

    /// Which nodes a run computes: those that nothing is known of, on the ways from the targets that begin with such.
    fn unknown(&self) -> Vec<bool> {
        let mut runs = vec![false; self.stand_in.len()];
        let mut seen = runs.clone();
        let mut stack: Vec<NodeId> = self.targets().collect();
        while let Some(id) = stack.pop() {
            if !std::mem::replace(&mut seen[id.index()], true) && !self.is_known(id) {
                runs[id.index()] = true;
                stack.extend(self.sources(id).map(|wire| wire.node));
            }
        }
        runs
    }

    fn is_known(&self, id: NodeId) -> bool {
        let recipe = self.keys[id.index()].as_ref().and_then(|key| key.recipe);
        let Some(record) = recipe.and_then(|recipe| self.cache.peek(&recipe)) else { return false };
        let Some(spec) = self.node(id).spec() else { return false };
        record.outputs.len() == spec.outputs.len()
            && record.outputs.iter().all(|output| self.cache.has_value(output))
            && (!spec.writes || self.folder.holds(&record.files))
    }

    /// What can be told of each node, of which some run.
    fn outlooks(&self, runs: &[bool]) -> Vec<Outlook> {
        let mut outlooks = vec![Outlook::default(); runs.len()];
        for &id in self.wanted {
            let at = id.index();
            if !runs[at] || self.stand_in[at] != id.0 {
                continue;
            }
            let (role, own_cells) = self.role(id).map_or((None, 0), |(role, cells)| (Some(role), cells));
            let (mut level, mut cells) = (0, own_cells);
            for wire in self.sources(id) {
                let from = &outlooks[wire.node.index()];
                let turns = u32::from(from.runs && (from.role.is_none() || role.is_none()));
                level = level.max(from.level + turns);
                cells = cells.max(from.cells);
            }
            outlooks[at] = Outlook { runs: true, role, level, cells, group: at };
            if role.is_some() {
                self.join(id, &mut outlooks);
            }
        }
        outlooks
    }

    /// Puts a node and those that it takes rows from into one group.
    fn join(&self, id: NodeId, outlooks: &mut [Outlook]) {
        let level = outlooks[id.index()].level;
        for wire in self.sources(id) {
            let from = wire.node.index();
            if outlooks[from].role.is_some() && outlooks[from].level == level {
                let (a, b) = (first_of(outlooks, from), first_of(outlooks, id.index()));
                outlooks[a.max(b)].group = a.min(b);
            }
        }
    }

    /// The part that a node can have in a section, and the cells of a source.
    fn role(&self, id: NodeId) -> Option<(Role, u64)> {
        let node = self.node(id);
        let Action::Run { node_type, instance, .. } = &node.action else { return None };
        let spec = node_type.spec();
        self.keys[id.index()].as_ref()?.recipe?;
        let rasters = self.rasters_into(node, spec);
        let makes_rasters =
            !spec.outputs.is_empty() && spec.outputs.iter().all(|port| port.value_type.is_raster());
        if spec.writes {
            let alone = node.inputs.iter().flatten().count() == 1 && rasters == 1 && spec.outputs.is_empty();
            return (alone && instance.takes_bands()).then_some((Role::Sink, 0));
        }
        if rasters > 0 {
            return (spec.extent == Extent::Local && makes_rasters).then_some((Role::Local, 0));
        }
        if !makes_rasters || spec.outputs.len() > 1 || node.inputs.iter().flatten().next().is_some() {
            return None;
        }
        let host = Asking { node, memory: self.cache.memory_budget() };
        let job = Job::new(&host, visible_context(node, self.request.context));
        // One that fails tells why when it runs.
        let source = instance.source(&job).ok().flatten()?;
        Some((Role::Source, source.grid().len() as u64))
    }

    /// How many wires bring a raster to the node.
    fn rasters_into(&self, node: &GraphNode, spec: &NodeSpec) -> usize {
        let ports = spec.inputs.iter().zip(&node.inputs).filter(|(port, _)| port.value_type.is_raster());
        ports.map(|(_, wires)| wires.len()).sum()
    }

    /// The groups whose values are too much for the memory there is, by their first node.
    fn groups(&self, outlooks: &[Outlook]) -> BTreeMap<usize, Vec<NodeId>> {
        let mut groups: BTreeMap<usize, Vec<NodeId>> = BTreeMap::new();
        for &id in self.wanted {
            let outlook = &outlooks[id.index()];
            if outlook.role.is_some() {
                groups.entry(first_of(outlooks, id.index())).or_default().push(id);
            }
        }
        groups.retain(|_, group| group.len() > 1);
        if !groups.is_empty() {
            let asked = self.asked_from_outside(outlooks);
            groups.retain(|_, group| self.is_worth_it(group, outlooks, &asked));
        }
        groups
    }

    /// Whether whole values of each node are needed, by a node that takes no rows from it or by the request.
    fn asked_from_outside(&self, outlooks: &[Outlook]) -> Vec<bool> {
        let mut asked = vec![false; outlooks.len()];
        for output in &self.request.outputs {
            asked[self.source(output).node.index()] = true;
        }
        for &id in self.wanted.iter().filter(|id| outlooks[id.index()].runs) {
            let taker = &outlooks[id.index()];
            for wire in self.sources(id) {
                let from = wire.node.index();
                let together = taker.role.is_some()
                    && outlooks[from].role.is_some()
                    && first_of(outlooks, from) == first_of(outlooks, id.index());
                asked[from] |= !together;
            }
        }
        asked
    }

    fn is_worth_it(&self, group: &[NodeId], outlooks: &[Outlook], asked: &[bool]) -> bool {
        const CELL_BYTES: u64 = 4;
        // However much memory there is, a run should not fill it with what is cheap to make again.
        const MOST: u64 = 1 << 30;
        let budget = self.cache.memory_budget();
        let cells = group.iter().map(|id| outlooks[id.index()].cells).max().unwrap_or(0);
        let spared = group.iter().filter(|id| !asked[id.index()]);
        let spared: usize = spared.map(|&id| self.node(id).spec().map_or(0, |spec| spec.outputs.len())).sum();
        let one = cells.saturating_mul(CELL_BYTES);
        // A node that runs has two or three values in hand; and what a run makes should not drive out the rest.
        spared > 0 && (one > budget / 4 || one.saturating_mul(spared as u64) >= MOST.min(budget / 2))
    }

    fn section(&self, group: &[NodeId], outlooks: &[Outlook], asked: &[bool]) -> Option<Section> {
        let (mut members, mut outside): (Vec<Member>, Vec<OutputRef>) = Default::default();
        for &id in group {
            let node = self.node(id).clone();
            let Action::Run { node_type, instance, .. } = &node.action else { return None };
            let mut place = |wire: &OutputRef| {
                let wire = self.source(wire);
                let within = members.iter().position(|member| member.id == wire.node);
                match within {
                    Some(member) => Wire::Member { member, output: wire.output as usize },
                    None => {
                        Wire::Outside(outside.iter().position(|known| *known == wire).unwrap_or_else(|| {
                            outside.push(wire);
                            outside.len() - 1
                        }))
                    }
                }
            };
            let inputs = node.inputs.iter().map(|wires| wires.iter().map(&mut place).collect()).collect();
            members.push(Member {
                id,
                instance: instance.clone(),
                role: outlooks[id.index()].role?,
                context: visible_context(&node, self.request.context),
                inputs,
                outputs: node_type.spec().outputs.iter().map(|port| port.value_type).collect(),
                collected: asked[id.index()] && !node_type.spec().outputs.is_empty(),
                node,
            });
        }
        Some(Section::new(members, outside, self.keys))
    }
}

/// The first node of the group that a node is in.
fn first_of(outlooks: &[Outlook], mut node: usize) -> usize {
    while outlooks[node].group != node {
        node = outlooks[node].group;
    }
    node
}
