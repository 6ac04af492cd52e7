//! What a run tells when it is over.

use std::sync::Arc;

use super::Run;
use crate::{
    cache::Tier,
    eval::{
        explain::Print,
        report::{NodeReport, Outcome, Report},
    },
    graph::NodeId,
};

impl Run {
    pub(crate) fn report(&self) -> Report {
        let state = self.lock();
        let mut report = Report::default();
        let mut prints = Vec::new();
        for &id in &self.wanted {
            let stand_in = NodeId(self.stand_in[id.index()]);
            let line = &state.lines[self.task(id) as usize];
            let Some(mut outcome) = line.outcome.clone() else { continue };
            let node = self.request.graph.node(id);
            let (mut record, mut micros) = (line.record().cloned(), line.micros);
            if let Some(part) = self.streams.part(stand_in) {
                outcome = part.section.outcome(part.member, &outcome);
                record = record.map(|task| Arc::new(part.section.record(part.member, &task)));
                micros = record.as_ref().filter(|_| outcome == Outcome::Streamed).map_or(0, |own| own.micros);
            }
            if outcome.is_run() && stand_in != id {
                // Another node with the same recipe ran for both.
                outcome = Outcome::Hit(Tier::Memory);
                micros = 0;
            }
            let mut reason = None;
            if self.request.history.is_some() {
                let print = Print::of(node, self.request.context, &self.keys, &self.shared.cache);
                if outcome.is_run() {
                    reason = Some(self.history.reason(node, &print, &self.request.graph));
                }
                if record.is_some() {
                    prints.push((node.name.clone(), print));
                }
            }
            let names = node.spec().map(|spec| spec.outputs.as_slice()).unwrap_or_default();
            let outputs = record.as_ref().map(|record| {
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
                micros,
                outputs: outputs.unwrap_or_default(),
                bytes: record
                    .as_ref()
                    .map_or(0, |record| record.outputs.iter().map(|output| output.bytes).sum()),
                files: record.as_ref().map(|record| record.files.clone()).unwrap_or_default(),
                warnings: record.as_ref().map(|record| record.warnings.clone()).unwrap_or_default(),
            });
            if let Some(record) = record {
                report.records.insert(id, record);
            }
        }
        drop(state);
        self.history.save(self.request.history.as_deref(), prints, &self.shared.cache);
        report
    }
}
