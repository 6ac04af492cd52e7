//! What a run tells when it is over.

use std::sync::Arc;

use super::Run;
use crate::{
    cache::Tier,
    eval::{
        explain::Print,
        report::{NodeReport, Outcome, Report},
    },
};

impl Run {
    pub(crate) fn report(&self) -> Report {
        let state = self.lock();
        let mut report = Report::default();
        let mut prints = Vec::new();
        for &id in &self.wanted {
            let line = &state.lines[self.stand_in[id.index()] as usize];
            let Some(mut outcome) = line.outcome.clone() else { continue };
            let node = self.request.graph.node(id);
            let record = line.record();
            if outcome == Outcome::Computed && self.stand_in[id.index()] != id.0 {
                // Another node with the same recipe ran for both.
                outcome = Outcome::Hit(Tier::Memory);
            }
            let mut reason = None;
            if self.request.history.is_some() {
                let print = Print::of(node, self.request.context, &self.keys, &self.shared.cache);
                if outcome == Outcome::Computed {
                    reason = Some(self.history.reason(node, &print, &self.request.graph));
                }
                if record.is_some() {
                    prints.push((node.name.clone(), print));
                }
            }
            let names = node.spec().map(|spec| spec.outputs.as_slice()).unwrap_or_default();
            let outputs = record.map(|record| {
                names
                    .iter()
                    .zip(&record.outputs)
                    .map(|(port, output)| (port.name.to_string(), output.digest))
                    .collect()
            });
            report.nodes.push(NodeReport {
                node: id,
                name: node.name.clone(),
                id: node.spec().map_or_else(String::new, |spec| spec.id.to_string()),
                version: node.spec().map_or(0, |spec| spec.version),
                outcome,
                reason,
                key: self.keys[id.index()].as_ref().and_then(|key| key.recipe),
                micros: if self.stand_in[id.index()] == id.0 { line.micros } else { 0 },
                outputs: outputs.unwrap_or_default(),
                bytes: record.map_or(0, |record| record.outputs.iter().map(|output| output.bytes).sum()),
                files: record.map(|record| record.files.clone()).unwrap_or_default(),
                warnings: record.map(|record| record.warnings.clone()).unwrap_or_default(),
            });
            if let Some(record) = record {
                report.records.insert(id, Arc::clone(record));
            }
        }
        drop(state);
        self.history.save(self.request.history.as_deref(), prints, &self.shared.cache);
        report
    }
}
