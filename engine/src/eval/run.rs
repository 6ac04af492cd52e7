//! One run: worker tasks on the pool that take ready nodes from the table until none is left.

mod report;
mod sharing;

use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak},
    time::Instant,
};

use orograph_core::{Digest, Error, Job, NodeSpec, Slot, Value};

use super::{
    CancelToken, Request, Shared,
    call::call,
    explain::History,
    host::TaskHost,
    key::{NodeKey, keys_of, visible_context},
    output::OutputFolder,
    report::{Event, Observer, Outcome},
    state::{Phase, Scheduler, State},
    stream::{Chooser, Section, Streams},
};
use crate::{
    cache::{DigestMap, Record, StoredOutput, Tier},
    graph::{Action, GraphNode, NodeId, OutputRef},
};

/// One run.
pub(crate) struct Run {
    pub(crate) shared: Arc<Shared>,
    pub(crate) request: Request,
    pub(crate) folder: OutputFolder,
    pub(crate) cancel: CancelToken,
    observer: Arc<dyn Observer>,
    /// The nodes that the targets depend on, inputs first.
    wanted: Vec<NodeId>,
    keys: Vec<Option<NodeKey>>,
    /// For each node, the first one with the same recipe: it stands for all of them.
    stand_in: Vec<u32>,
    /// Which nodes run together, band by band.
    streams: Streams,
    history: History,
    state: Mutex<State>,
    quiet: Condvar,
    me: Weak<Self>,
}

impl Run {
    pub(crate) fn new(
        shared: Arc<Shared>,
        request: Request,
        observer: Arc<dyn Observer>,
        cancel: CancelToken,
    ) -> Arc<Self> {
        let wanted = request.wanted();
        let keys = keys_of(&request.graph, &wanted, request.context, &shared.cache);
        let mut first = DigestMap::with_capacity_and_hasher(wanted.len(), Default::default());
        let mut stand_in: Vec<u32> = (0..keys.len() as u32).collect();
        for id in &wanted {
            if let Some(recipe) = keys[id.index()].as_ref().and_then(|key| key.recipe) {
                stand_in[id.index()] = *first.entry(recipe).or_insert(id.0);
            }
        }
        let history = History::load(request.history.as_deref(), &shared.cache);
        let state = Mutex::new(State::new(keys.len()));
        let folder = OutputFolder::new(&request.out_dir);
        let streams = Streams::new(&Chooser {
            request: &request,
            wanted: &wanted,
            keys: &keys,
            stand_in: &stand_in,
            cache: &shared.cache,
            folder: &folder,
        });
        Arc::new_cyclic(|me| Self {
            shared,
            request,
            folder,
            cancel,
            observer,
            wanted,
            keys,
            stand_in,
            streams,
            history,
            state,
            quiet: Condvar::new(),
            me: Weak::clone(me),
        })
    }

    /// Brings every target to its end.
    pub(crate) fn execute(&self) {
        let mut state = self.lock();
        let mut scheduler = Scheduler::new(self, &mut state);
        for output in &self.request.outputs {
            scheduler.request(self.task(output.node), true);
        }
        for writer in &self.request.writers {
            scheduler.request(self.task(*writer), false);
        }
        let ended = scheduler.into_ended();
        for output in &self.request.outputs {
            // The request itself is a user, so that its values stay until it is answered.
            state.lines[self.task(output.node) as usize].users += 1;
        }
        self.call_workers(&mut state, 0);
        drop(state);
        self.tell(&ended, 0.0);
        self.wait();
    }

    /// Starts as many workers as there is work beyond `own`, what the caller will take itself.
    fn call_workers(&self, state: &mut State, own: usize) {
        let mut work = state.ready.len().saturating_sub(own);
        while work > 0 && state.active < self.shared.jobs {
            work -= 1;
            state.active += 1;
            if let Some(run) = self.me.upgrade() {
                self.shared.pool.spawn(move || run.work());
            }
        }
    }

    fn work(&self) {
        self.lock().begun += 1;
        loop {
            let mut state = self.lock();
            if self.cancel.is_cancelled() {
                Scheduler::new(self, &mut state).drop_ready();
            }
            let Some(node) = state.ready.pop() else {
                state.active -= 1;
                state.begun -= 1;
                if state.is_quiet() {
                    self.quiet.notify_all();
                }
                return;
            };
            let line = &mut state.lines[node as usize];
            line.phase = Phase::Running;
            let (action, forced) = (line.action, line.forced);
            let (Some(records), Some(action)) = (self.records(&state, node), action) else {
                // An input lost its value and is being made again.
                if let Some(action) = action {
                    self.forget(node, action);
                }
                Scheduler::new(self, &mut state).retry(node, Phase::Values);
                continue;
            };
            // Under the lock, so that the answer cannot come before the line says that it is awaited.
            if !self.shared.in_flight.claim(action, &self.me, node, &self.cancel) {
                state.lines[node as usize].phase = Phase::Elsewhere;
                state.elsewhere += 1;
                continue;
            }
            drop(state);
            self.perform(node, &records, action, forced);
        }
    }

    /// The records that a node's wires come from, one for each wire.
    fn records(&self, state: &State, node: u32) -> Option<Vec<Arc<Record>>> {
        self.inputs(node).map(|input| state.lines[input as usize].record().cloned()).collect()
    }

    /// A node's inputs. To be called without the lock: a value from disk is checked on the whole pool, and a thread
    /// that waits there takes up other work, which needs the lock.
    fn slots(&self, node: u32, records: &[Arc<Record>]) -> Option<Vec<Slot>> {
        let mut records = records.iter();
        let mut value = |wire: &OutputRef| {
            let record = records.next()?;
            self.shared.cache.value(record.outputs.get(wire.output as usize)?)
        };
        let mut slots = Vec::with_capacity(self.node(node).inputs.len());
        for wires in &self.node(node).inputs {
            slots.push(match wires.as_slice() {
                [] => Slot::Empty,
                [wire] => Slot::One(value(wire)?),
                wires => Slot::Many(wires.iter().map(&mut value).collect::<Option<_>>()?),
            });
        }
        Some(slots)
    }

    fn perform(&self, node: u32, records: &[Arc<Record>], action: Digest, forced: bool) {
        let known = if forced { None } else { self.lookup(node, &action) };
        let result = match known {
            // Someone finished it since this node looked.
            Some((record, tier)) => {
                self.conclude(node, |scheduler| scheduler.finish(node, record, Outcome::Cutoff(tier)));
                Ok(())
            }
            None => match self.slots(node, records) {
                Some(slots) => self.compute(node, &slots, action),
                None => {
                    // A value was lost between the look and the grasp: have it made again.
                    self.conclude(node, |scheduler| scheduler.retry(node, Phase::Values));
                    // Those who wait for this node try by themselves.
                    Err(Error::Cancelled)
                }
            },
        };
        for (run, node) in self.shared.in_flight.release(&action) {
            if let Some(run) = run.upgrade() {
                run.resume(node, &result);
            }
        }
    }

    fn compute(&self, node: u32, slots: &[Slot], action: Digest) -> Result<(), Error> {
        for name in self.names(node) {
            self.observer.event(&Event::Started { node: name });
        }
        let begun = Instant::now();
        let host = TaskHost::new(self, NodeId(node), action);
        let context = visible_context(self.node(node), self.request.context);
        let result =
            call(self.node(node), slots, &Job::new(&host, context)).map_err(|error| host.located(error));
        let micros = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        let values = match result {
            Ok(values) => values,
            Err(error) => {
                self.conclude(node, |scheduler| scheduler.fail(node, error.clone()));
                return Err(error);
            }
        };
        let (warnings, files) = host.into_traces();
        let outputs = values.iter().map(StoredOutput::of).collect();
        let record = Arc::new(Record { outputs, files, warnings, micros });
        for (output, value) in record.outputs.iter().zip(&values) {
            self.shared.cache.hold(output, value.clone(), 1);
        }
        let mut keys = vec![action];
        keys.extend(self.key(node).recipe);
        for key in &keys {
            self.shared.cache.remember(*key, &record);
        }
        let parts = self.streams.records(NodeId(node), &record, &self.keys);
        for (key, part) in &parts {
            self.shared.cache.remember(*key, part);
        }
        if self.shared.cache.disk().is_some() {
            let record = Arc::clone(&record);
            let bytes = values.iter().map(Value::size_in_memory).sum();
            self.shared.write_behind(bytes, move |cache| {
                cache.persist(&keys, &record, &values);
                parts.iter().for_each(|(key, part)| cache.persist_record(key, part));
            });
        }
        self.change(|scheduler| match scheduler.was_left(node) {
            true => scheduler.keep(record),
            false => scheduler.complete(node, record, micros),
        });
        Ok(())
    }

    /// Moves on a node whose computation is over, unless the run was over for it before.
    fn conclude(&self, node: u32, moves: impl FnOnce(&mut Scheduler<'_>)) {
        self.change(|scheduler| {
            if !scheduler.was_left(node) {
                moves(scheduler);
            }
        });
    }

    /// Moves nodes on under the lock, then wakes workers and tells the observer without it.
    fn change(&self, moves: impl FnOnce(&mut Scheduler<'_>)) {
        let mut state = self.lock();
        let mut scheduler = Scheduler::new(self, &mut state);
        moves(&mut scheduler);
        let ended = scheduler.into_ended();
        self.call_workers(&mut state, 1);
        let overall = self.overall(&state);
        drop(state);
        self.tell(&ended, overall);
    }

    fn tell(&self, ended: &[(u32, Outcome)], overall: f64) {
        for (node, outcome) in ended {
            for (node, outcome) in self.streams.members_of(NodeId(*node), outcome) {
                let (node, outcome) = (&self.request.graph.node(node).name, &outcome);
                self.observer.event(&Event::Finished { node, outcome, overall });
            }
        }
    }

    pub(crate) fn progress(&self, node: NodeId, done: f64) {
        let overall = {
            let mut state = self.lock();
            if !state.is_under_way(node.0) {
                return;
            }
            state.advance(node.0, done, self.cost(node.0));
            self.overall(&state)
        };
        for name in self.names(node.0) {
            self.observer.event(&Event::Progress { node: name, done, overall });
        }
    }

    pub(crate) fn note(&self, node: NodeId, message: &str) {
        if self.lock().is_under_way(node.0) {
            self.observer.event(&Event::Note { node: self.name(node.0), message });
        }
    }

    fn overall(&self, state: &State) -> f64 {
        if state.cost > 0.0 { (state.done_cost / state.cost).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nodes run outside the lock and behind a fence, so a poisoned table is still a whole one.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A task's node.
    pub(crate) fn node(&self, node: u32) -> &GraphNode {
        self.streams.graph().node(NodeId(node))
    }

    /// The task that gives a node's outputs: the node itself, one of equal recipe, or a section.
    fn task(&self, node: NodeId) -> u32 {
        let node = NodeId(self.stand_in[node.index()]);
        self.streams.part(node).map_or(node, |part| part.section.leader()).0
    }

    pub(crate) fn name(&self, node: u32) -> &str {
        &self.node(node).name
    }

    /// The names of the nodes that a task runs.
    fn names(&self, node: u32) -> impl Iterator<Item = &str> {
        let section = self.streams.section(NodeId(node));
        let single = section.is_none().then(|| self.name(node));
        section.into_iter().flat_map(Section::names).chain(single)
    }

    pub(crate) fn key(&self, node: u32) -> &NodeKey {
        static NOTHING: NodeKey = NodeKey { settings: Digest([0; 32]), recipe: None, error: None };
        if let Some(section) = self.streams.section(NodeId(node)) {
            return section.key();
        }
        self.keys[node as usize].as_ref().unwrap_or(&NOTHING)
    }

    pub(crate) fn cost(&self, node: u32) -> f64 {
        match &self.node(node).action {
            Action::Run { instance, .. } => instance.cost(),
            Action::Missing(_) => 0.0,
        }
    }

    /// The nodes that stand for a node's inputs, one for each wire.
    pub(crate) fn inputs(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        self.node(node).inputs.iter().flatten().map(|wire| self.stand_in[wire.node.index()])
    }

    /// For each input port, the (stand-in, output) of its wires.
    pub(crate) fn wires(&self, node: u32) -> impl Iterator<Item = Vec<(u32, u32)>> + '_ {
        self.node(node)
            .inputs
            .iter()
            .map(|wires| wires.iter().map(|wire| (self.stand_in[wire.node.index()], wire.output)).collect())
    }

    pub(crate) fn has_values(&self, record: &Arc<Record>) -> bool {
        record.outputs.iter().all(|output| self.shared.cache.has_value(output))
    }

    /// A record that can stand for running the node now: of a writer, only while its files are in place.
    pub(crate) fn lookup(&self, node: u32, key: &Digest) -> Option<(Arc<Record>, Tier)> {
        let (record, tier) = self.shared.cache.record(key)?;
        let spec: &NodeSpec = self.node(node).spec()?;
        if record.outputs.len() != spec.outputs.len() {
            return None;
        }
        if spec.writes {
            if !self.folder.holds(&record.files) {
                return None;
            }
            self.folder.sweep_beside(&record.files);
        }
        Some((record, tier))
    }

    /// Lets a recipe find what its action found.
    pub(crate) fn alias(&self, recipe: Digest, record: &Arc<Record>, tier: Tier) {
        self.shared.cache.remember(recipe, record);
        if tier == Tier::Disk || self.shared.cache.disk().is_some() {
            let record = Arc::clone(record);
            self.shared.write_behind(0, move |cache| cache.persist_record(&recipe, &record));
        }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        for record in &state.kept {
            self.shared.cache.unpin(record);
        }
        for line in &state.lines {
            if let Some(record) = line.record().filter(|_| line.pinned) {
                self.shared.cache.unpin(record);
            }
        }
    }
}
