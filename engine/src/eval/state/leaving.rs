//! What becomes of nodes that other runs compute, or that a cancelled run leaves to them.

use std::sync::Arc;

use orograph_core::Error;

use super::{Phase, Scheduler};
use crate::cache::Record;

impl Scheduler<'_> {
    /// Goes on with a node whose computation was under way in another run.
    pub(crate) fn resume(&mut self, node: u32, result: &Result<(), Error>) {
        if !matches!(self.line(node).phase, Phase::Elsewhere) {
            return;
        }
        self.state.elsewhere -= 1;
        match result {
            // Another run's cancellation is not this run's.
            Ok(()) | Err(Error::Cancelled) => self.retry(node, Phase::Records),
            Err(error) => self.fail(node, error.clone()),
        }
    }

    /// Ends the nodes that could run, in a run that was cancelled.
    pub(crate) fn drop_ready(&mut self) {
        for node in std::mem::take(&mut self.state.ready) {
            if let Some(action) = self.line(node).action {
                self.run.forget(node, action);
            }
            self.fail(node, Error::Cancelled);
        }
    }

    /// Ends, in a run that was cancelled, every node that need not be waited for: those that did not begin, those that
    /// another run computes, and those that run on because another run wants them.
    pub(crate) fn leave(&mut self) {
        self.drop_ready();
        for node in 0..self.state.lines.len() as u32 {
            match self.state.lines[node as usize].phase {
                Phase::Elsewhere => self.state.elsewhere -= 1,
                Phase::Running if self.goes_on(node) => self.state.left.push(node),
                _ => continue,
            }
            self.fail(node, Error::Cancelled);
        }
    }

    fn goes_on(&self, node: u32) -> bool {
        self.state.lines[node as usize]
            .action
            .is_some_and(|action| self.run.goes_on_for_others(node, &action))
    }

    /// Keeps what came of a node that was left to other runs, until they had the time to take it.
    pub(crate) fn keep(&mut self, record: Arc<Record>) {
        self.state.kept.push(record);
    }

    /// Whether a node whose computation is over now was left to other runs.
    pub(crate) fn was_left(&mut self, node: u32) -> bool {
        let place = self.state.left.iter().position(|left| *left == node);
        place.map(|place| self.state.left.swap_remove(place)).is_some()
    }
}
