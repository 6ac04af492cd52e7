//! A look ahead: what a run would find and what it would have to compute.

use super::{Evaluator, Request, key::keys_of, output::OutputFolder};
use crate::{cache::Tier, graph::NodeId};

/// What a run would do with a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planned {
    /// Its outputs are known.
    Hit(Tier),
    /// It would run, unless its inputs turn out as in an earlier computation.
    Run,
    /// Its key cannot be made: a file that it needs cannot be read, or its type is unknown.
    Blocked,
}

impl Evaluator {
    /// What a run of `request` would look at, inputs first. Nothing is computed.
    #[must_use]
    pub fn plan(&self, request: &Request) -> Vec<(NodeId, Planned)> {
        let graph = &request.graph;
        let wanted = request.wanted();
        let keys = keys_of(graph, &wanted, request.context, self.cache());
        let folder = OutputFolder::new(&request.out_dir);
        let mut needed = vec![false; graph.nodes().len()];
        for id in request.outputs.iter().map(|output| output.node).chain(request.writers.iter().copied()) {
            needed[id.index()] = true;
        }
        let mut plan = Vec::new();
        for &id in wanted.iter().rev() {
            if !needed[id.index()] {
                continue;
            }
            let writes = graph.node(id).spec().is_some_and(|spec| spec.writes);
            let recipe = keys[id.index()].as_ref().and_then(|key| key.recipe);
            let known = recipe.and_then(|recipe| self.cache().record(&recipe));
            let hit = known.filter(|(record, _)| !writes || folder.holds(&record.files));
            let planned = match (recipe, hit) {
                (None, _) => Planned::Blocked,
                (Some(_), Some((_, tier))) => Planned::Hit(tier),
                (Some(_), None) => Planned::Run,
            };
            if !matches!(planned, Planned::Hit(_)) {
                for wire in graph.node(id).inputs.iter().flatten() {
                    needed[wire.node.index()] = true;
                }
            }
            plan.push((id, planned));
        }
        plan.reverse();
        plan
    }
}
