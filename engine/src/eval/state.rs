//! The table of a run: where each node stands, and what follows when one moves on.
//!
//! A node goes from [`Phase::Idle`] through waiting for its inputs' digests, waiting for their values, and
//! running, to done or failed; a cache hit leaves the road early. Steps are kept on a list instead of the call
//! stack, so a chain may be of any length.

mod leaving;

use std::sync::Arc;

use orograph_core::{Digest, Error};

use super::{key::action_key, report::Outcome, run::Run};
use crate::cache::{Record, Tier};

/// Where a node stands.
#[derive(Clone, Debug)]
pub(crate) enum Phase {
    /// Nobody asked for it.
    Idle,
    /// It waits for the digests of its inputs.
    Records,
    /// It waits for the values of its inputs.
    Values,
    /// It can run.
    Queued,
    /// It runs.
    Running,
    /// The same computation is under way elsewhere in this process.
    Elsewhere,
    /// Its outputs are known.
    Done(Arc<Record>),
    /// It will have none.
    Failed,
}

/// A node's line in the table.
pub(crate) struct Line {
    pub(crate) phase: Phase,
    /// What it still waits for, in its present phase.
    waiting: u32,
    /// Nodes that wait for it.
    dependents: Vec<u32>,
    /// Wires and requests that still want its values.
    pub(crate) users: u32,
    /// Its values are pinned in memory for them.
    pub(crate) pinned: bool,
    /// Its cached value proved lost, so that it must run whatever the cache says.
    pub(crate) forced: bool,
    /// Its inputs count it as a user.
    counted: bool,
    pub(crate) action: Option<Digest>,
    pub(crate) outcome: Option<Outcome>,
    pub(crate) micros: u64,
    pub(crate) progress: f64,
}

impl Line {
    fn new() -> Self {
        Self {
            phase: Phase::Idle,
            waiting: 0,
            dependents: Vec::new(),
            users: 0,
            pinned: false,
            forced: false,
            counted: false,
            action: None,
            outcome: None,
            micros: 0,
            progress: 0.0,
        }
    }

    pub(crate) fn record(&self) -> Option<&Arc<Record>> {
        match &self.phase {
            Phase::Done(record) => Some(record),
            _ => None,
        }
    }
}

/// The table.
pub(crate) struct State {
    pub(crate) lines: Vec<Line>,
    /// Nodes that can run; the latest first, so that a branch is finished before the next is begun.
    pub(crate) ready: Vec<u32>,
    /// Worker tasks on the pool, or waiting there for a thread.
    pub(crate) active: usize,
    /// Those that have a thread. The others hold nobody up: they will find nothing to do.
    pub(crate) begun: usize,
    /// Nodes that wait for another run.
    pub(crate) elsewhere: usize,
    /// Nodes that run on for other runs alone, each on a worker of this one, for which they are over.
    left: Vec<u32>,
    /// What came of such nodes; its values are pinned for as long as the run.
    pub(crate) kept: Vec<Arc<Record>>,
    /// Cost of the nodes that were not known at once.
    pub(crate) cost: f64,
    /// The part of it that is done.
    pub(crate) done_cost: f64,
}

impl State {
    pub(crate) fn new(n_nodes: usize) -> Self {
        Self {
            lines: std::iter::repeat_with(Line::new).take(n_nodes).collect(),
            ready: Vec::new(),
            active: 0,
            begun: 0,
            elsewhere: 0,
            left: Vec::new(),
            kept: Vec::new(),
            cost: 0.0,
            done_cost: 0.0,
        }
    }

    /// Notes how much of a running node is done.
    pub(crate) fn advance(&mut self, node: u32, done: f64, cost: f64) {
        let line = &mut self.lines[node as usize];
        let step = done.clamp(0.0, 1.0) - line.progress;
        if step > 0.0 {
            line.progress += step;
            self.done_cost += step * cost;
        }
    }

    /// Whether a node runs or is about to, here or elsewhere, and is not over for this run.
    pub(crate) fn is_under_way(&self, node: u32) -> bool {
        matches!(self.lines[node as usize].phase, Phase::Queued | Phase::Running | Phase::Elsewhere)
    }

    /// Whether nothing is left to wait for.
    pub(crate) fn is_quiet(&self) -> bool {
        self.begun == self.left.len() && self.elsewhere == 0 && self.ready.is_empty()
    }
}

enum Step {
    Demand { node: u32, value: bool, by: Option<u32> },
    Arrive(u32),
}

/// Moves nodes on, under the table's lock.
pub(crate) struct Scheduler<'a> {
    run: &'a Run,
    state: &'a mut State,
    steps: Vec<Step>,
    ended: Vec<(u32, Outcome)>,
}

impl<'a> Scheduler<'a> {
    pub(crate) fn new(run: &'a Run, state: &'a mut State) -> Self {
        Self { run, state, steps: Vec::new(), ended: Vec::new() }
    }

    /// The nodes that came to their end, to be told to the observer after the lock is gone.
    pub(crate) fn into_ended(self) -> Vec<(u32, Outcome)> {
        self.ended
    }

    /// Asks for a node's outputs on behalf of the caller.
    pub(crate) fn request(&mut self, node: u32, value: bool) {
        self.steps.push(Step::Demand { node, value, by: None });
        self.settle();
    }

    /// Sends a node back to wait for its inputs' values, or for their digests.
    pub(crate) fn retry(&mut self, node: u32, phase: Phase) {
        self.line(node).phase = phase;
        self.line(node).waiting = 1;
        self.steps.push(Step::Arrive(node));
        self.settle();
    }

    /// Ends a node that ran. Its values were pinned, and stay so while someone wants them.
    pub(crate) fn complete(&mut self, node: u32, record: Arc<Record>, micros: u64) {
        let line = self.line(node);
        line.micros += micros;
        line.pinned = line.users > 0;
        if !line.pinned {
            self.run.shared.cache.unpin(&record);
        }
        self.finish(node, record, Outcome::Computed);
    }

    pub(crate) fn finish(&mut self, node: u32, record: Arc<Record>, outcome: Outcome) {
        self.end(node, Phase::Done(record), outcome);
        self.settle();
    }

    pub(crate) fn fail(&mut self, node: u32, error: Error) {
        self.end(node, Phase::Failed, Outcome::Failed(error));
        self.settle();
    }

    fn settle(&mut self) {
        while let Some(step) = self.steps.pop() {
            match step {
                Step::Demand { node, value, by } => self.demand(node, value, by),
                Step::Arrive(node) => self.arrive(node),
            }
        }
    }

    fn line(&mut self, node: u32) -> &mut Line {
        &mut self.state.lines[node as usize]
    }

    fn demand(&mut self, node: u32, value: bool, by: Option<u32>) {
        match self.line(node).phase.clone() {
            Phase::Failed => return,
            Phase::Done(record) => {
                if !value || self.run.has_values(&record) {
                    return;
                }
                self.line(node).forced = true;
                self.begin(node);
            }
            Phase::Idle => {
                if let Some(error) = self.run.key(node).error.clone() {
                    self.end(node, Phase::Failed, Outcome::Failed(error));
                    return;
                }
                if let Some((record, tier)) = self.lookup(node, self.run.key(node).recipe)
                    && (!value || self.run.has_values(&record))
                {
                    self.end(node, Phase::Done(record), Outcome::Hit(tier));
                    return;
                }
                self.begin(node);
            }
            _ => {}
        }
        if let Some(by) = by {
            self.line(by).waiting += 1;
            self.line(node).dependents.push(by);
        }
    }

    fn lookup(&mut self, node: u32, key: Option<Digest>) -> Option<(Arc<Record>, Tier)> {
        if self.line(node).forced {
            return None;
        }
        self.run.lookup(node, &key?)
    }

    fn begin(&mut self, node: u32) {
        let run = self.run;
        self.line(node).phase = Phase::Records;
        self.line(node).waiting = 1;
        self.steps.push(Step::Arrive(node));
        let count = !std::mem::replace(&mut self.line(node).counted, true);
        self.line(node).progress = 0.0;
        self.state.cost += run.cost(node);
        for input in run.inputs(node) {
            if count {
                self.line(input).users += 1;
            }
            self.steps.push(Step::Demand { node: input, value: false, by: Some(node) });
        }
    }

    fn arrive(&mut self, node: u32) {
        let line = self.line(node);
        line.waiting = line.waiting.saturating_sub(1);
        if line.waiting > 0 {
            return;
        }
        match line.phase {
            Phase::Records => self.on_records(node),
            Phase::Values => self.on_values(node),
            _ => {}
        }
    }

    /// All inputs have records, or failed.
    fn on_records(&mut self, node: u32) {
        if self.failed_by_input(node) {
            return;
        }
        let run = self.run;
        if !run.inputs(node).all(|input| self.state.lines[input as usize].record().is_some()) {
            // One that was done lost its value to someone else and is being made again.
            self.await_inputs(node, Phase::Records, false);
            return;
        }
        let inputs: Option<Vec<Vec<Digest>>> = self
            .run
            .wires(node)
            .map(|wires| {
                wires
                    .iter()
                    .map(|&(input, output)| {
                        let record = self.state.lines[input as usize].record()?;
                        record.outputs.get(output as usize).map(|output| output.digest)
                    })
                    .collect()
            })
            .collect();
        let Some(inputs) = inputs else {
            let error = Error::invalid(
                "an input gave fewer outputs than its spec declares",
                "report it to its author",
            );
            self.end(node, Phase::Failed, Outcome::Failed(error));
            return;
        };
        let action = action_key(&self.run.key(node).settings, &inputs);
        self.line(node).action = Some(action);
        if let Some((record, tier)) = self.lookup(node, Some(action)) {
            if let Some(recipe) = self.run.key(node).recipe {
                self.run.alias(recipe, &record, tier);
            }
            self.end(node, Phase::Done(record), Outcome::Cutoff(tier));
            return;
        }
        self.await_inputs(node, Phase::Values, true);
    }

    /// Lets a node wait in `phase` until its inputs have their digests, and their values too where `value` says so.
    fn await_inputs(&mut self, node: u32, phase: Phase, value: bool) {
        let run = self.run;
        self.line(node).phase = phase;
        self.line(node).waiting = 1;
        self.steps.push(Step::Arrive(node));
        for input in run.inputs(node) {
            self.steps.push(Step::Demand { node: input, value, by: Some(node) });
        }
    }

    /// All inputs had their values a moment ago, or failed.
    fn on_values(&mut self, node: u32) {
        if self.failed_by_input(node) {
            return;
        }
        let run = self.run;
        let complete = run.inputs(node).all(|input| {
            self.state.lines[input as usize].record().is_some_and(|record| run.has_values(record))
        });
        if !complete {
            self.await_inputs(node, Phase::Values, true);
            return;
        }
        if self.line(node).action.is_some_and(|action| run.want(node, action)) {
            self.line(node).phase = Phase::Elsewhere;
            self.state.elsewhere += 1;
            return;
        }
        self.line(node).phase = Phase::Queued;
        self.state.ready.push(node);
    }

    fn failed_by_input(&mut self, node: u32) -> bool {
        let run = self.run;
        let failed =
            run.inputs(node).find(|&input| matches!(self.state.lines[input as usize].phase, Phase::Failed));
        let Some(input) = failed else { return false };
        let because = match &self.line(input).outcome {
            Some(Outcome::Skipped { because }) => because.clone(),
            _ => run.name(input).to_owned(),
        };
        self.end(node, Phase::Failed, Outcome::Skipped { because });
        true
    }

    fn end(&mut self, node: u32, phase: Phase, outcome: Outcome) {
        let run = self.run;
        if self.line(node).counted {
            // Whatever became of it, nothing is left to do.
            self.state.advance(node, 1.0, run.cost(node));
        }
        let line = self.line(node);
        line.phase = phase;
        line.forced = false;
        // A node that ran once in this run is reported as such, however often its value is asked for again.
        if line.outcome != Some(Outcome::Computed) || matches!(outcome, Outcome::Failed(_)) {
            line.outcome = Some(outcome.clone());
        }
        let counted = std::mem::take(&mut line.counted);
        let dependents = std::mem::take(&mut line.dependents);
        self.steps.extend(dependents.into_iter().map(Step::Arrive));
        if counted {
            for input in run.inputs(node) {
                self.drop_user(input);
            }
        }
        self.ended.push((node, outcome));
    }

    /// One user less; the last one lets the values go.
    fn drop_user(&mut self, node: u32) {
        let line = self.line(node);
        line.users = line.users.saturating_sub(1);
        if line.users == 0 && line.pinned {
            line.pinned = false;
            if let Some(record) = line.record().cloned() {
                self.run.shared.cache.unpin(&record);
            }
        }
    }
}

#[cfg(test)]
mod tests;
