//! A section: its nodes, how they are wired, and what became of them.

use std::{
    path::Path,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use orograph_core::{CellSize, Context, Digest, Hasher, Instance, Job, Result, Slot, Value, ValueType};

use super::tracks::Tracks;
use crate::{
    cache::Record,
    eval::{key::NodeKey, report::Outcome},
    graph::{GraphNode, NodeId, OutputRef},
};

/// What a member does with rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It makes them.
    Source,
    /// It turns some into others.
    Local,
    /// It writes them.
    Sink,
}

/// Where a wire of a member comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wire {
    /// A wire that comes into the section.
    Outside(usize),
    /// An output of a member.
    Member {
        /// Which one.
        member: usize,
        /// Which of its outputs.
        output: usize,
    },
}

/// A node of a section.
pub(crate) struct Member {
    pub(crate) id: NodeId,
    pub(crate) node: GraphNode,
    pub(crate) instance: Arc<dyn Instance>,
    pub(crate) role: Role,
    /// What it sees of the run's context.
    pub(crate) context: Context,
    /// For each input port, its wires.
    pub(crate) inputs: Vec<Vec<Wire>>,
    /// The types of its outputs.
    pub(crate) outputs: Vec<ValueType>,
    /// Nodes outside, or the request, want its outputs whole.
    pub(crate) collected: bool,
}

/// What a member's part in the task was.
#[derive(Clone, Debug, Default)]
struct Account {
    time: Duration,
    warnings: Vec<String>,
    /// What became of it, once that is known.
    outcome: Option<Outcome>,
}

/// Nodes that run as one task; see the module above.
pub(crate) struct Section {
    /// Inputs first; the last one lends its place in the graph to the task.
    members: Vec<Member>,
    /// The outputs of other nodes that come into the section.
    outside: Vec<OutputRef>,
    key: NodeKey,
    accounts: Mutex<Vec<Account>>,
    /// The member at work.
    at: AtomicUsize,
}

impl Section {
    /// A section of `members`, inputs first, whose nodes have these keys.
    pub(super) fn new(members: Vec<Member>, outside: Vec<OutputRef>, keys: &[Option<NodeKey>]) -> Self {
        let key = key_of(&members, keys);
        let accounts = Mutex::new(vec![Account::default(); members.len()]);
        Self { members, outside, key, accounts, at: AtomicUsize::new(0) }
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.members.iter().map(|member| member.id)
    }

    /// The names of the members.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.members.iter().map(|member| member.node.name.as_str())
    }

    /// The node in whose place the task stands.
    pub(crate) fn leader(&self) -> NodeId {
        self.members.last().map_or(NodeId(0), |member| member.id)
    }

    pub(super) fn outside(&self) -> &[OutputRef] {
        &self.outside
    }

    /// The keys of the task.
    pub(crate) fn key(&self) -> &NodeKey {
        &self.key
    }

    pub(super) fn writes(&self) -> bool {
        self.members.iter().any(|member| member.role == Role::Sink)
    }

    /// The outputs that the task makes whole, in the order in which it gives them.
    pub(super) fn collected(&self) -> impl Iterator<Item = OutputRef> + '_ {
        let collected = self.members.iter().filter(|member| member.collected);
        collected.flat_map(|member| {
            (0..member.outputs.len() as u32).map(|output| OutputRef { node: member.id, output })
        })
    }

    /// Whether all that a member gives is there when the task is over: its values, or its file.
    pub(super) fn is_whole(&self, member: usize) -> bool {
        self.members[member].collected || self.members[member].role == Role::Sink
    }

    /// Where the task gives an output of a collected member.
    pub(super) fn task_output(&self, member: usize, output: u32) -> OutputRef {
        OutputRef { node: self.leader(), output: self.first_output(member) as u32 + output }
    }

    fn first_output(&self, member: usize) -> usize {
        let before = self.members[..member].iter().filter(|member| member.collected);
        before.map(|member| member.outputs.len()).sum()
    }

    /// What is known of a member once the task has the record `task`.
    pub(crate) fn record(&self, member: usize, task: &Record) -> Record {
        let part = &self.members[member];
        let outputs = if part.collected {
            let first = self.first_output(member);
            task.outputs.iter().skip(first).take(part.outputs.len()).cloned().collect()
        } else {
            Vec::new()
        };
        let account = self.accounts()[member].clone();
        let own = |name: &Path| part.node.output_files().any(|file| Path::new(file) == name);
        Record {
            outputs,
            files: task.files.iter().filter(|file| own(&file.name)).cloned().collect(),
            warnings: account.warnings,
            micros: u64::try_from(account.time.as_micros()).unwrap_or(u64::MAX),
        }
    }

    /// What became of a member when this became of the task.
    pub(crate) fn outcome(&self, member: usize, task: &Outcome) -> Outcome {
        match (task, self.accounts()[member].outcome.clone()) {
            (Outcome::Computed | Outcome::Failed(_), Some(own)) => own,
            // It ended before that was known of each: by a panic, by being cancelled, or at the beginning.
            (Outcome::Failed(_), None) if member != self.at.load(Ordering::Relaxed) => {
                let at = self.members.get(self.at.load(Ordering::Relaxed));
                Outcome::Skipped { because: at.map_or_else(String::new, |at| at.node.name.clone()) }
            }
            _ => task.clone(),
        }
    }

    /// Notes the time that a member took, and what it told the user.
    pub(super) fn note(&self, member: usize, time: Duration, warnings: Vec<String>) {
        let account = &mut self.accounts()[member];
        account.time += time;
        account.warnings.extend(warnings);
        account.warnings.sort_unstable();
        account.warnings.dedup();
    }

    /// Notes what became of a member.
    pub(super) fn ended(&self, member: usize, outcome: Outcome) {
        self.accounts()[member].outcome = Some(outcome);
    }

    /// Notes which member is at work.
    pub(super) fn goes_to(&self, member: usize) -> &Member {
        self.at.store(member, Ordering::Relaxed);
        &self.members[member]
    }

    pub(super) fn members(&self) -> &[Member] {
        &self.members
    }

    fn accounts(&self) -> MutexGuard<'_, Vec<Account>> {
        self.accounts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Instance for Section {
    fn run(&self, slots: &[Slot], job: &Job) -> Result<Vec<Value>> {
        self.accounts().fill(Account::default());
        Tracks::new(self, slots, job)?.run()
    }
    fn halo(&self, _: CellSize) -> usize {
        0
    }
    fn cost(&self) -> f64 {
        self.members.iter().map(|member| member.instance.cost()).sum()
    }
}

/// The keys of a task: what its members are and how they are wired, and, for the recipe, what they are fed.
fn key_of(members: &[Member], keys: &[Option<NodeKey>]) -> NodeKey {
    let (mut settings, mut recipe) =
        (Hasher::new("orograph section 1"), Hasher::new("orograph section recipe 1"));
    let mut complete = true;
    for member in members {
        let key = keys[member.id.index()].as_ref();
        settings
            .digest(key.map_or(&Digest([0; 32]), |key| &key.settings))
            .number(u64::from(member.collected));
        for wires in &member.inputs {
            settings.number(wires.len() as u64);
            for wire in wires {
                let (kind, of, output) = match *wire {
                    Wire::Outside(wire) => (0, wire, 0),
                    Wire::Member { member, output } => (1, member, output),
                };
                settings.number(kind).number(of as u64).number(output as u64);
            }
        }
        match key.and_then(|key| key.recipe) {
            Some(own) => {
                recipe.digest(&own).number(u64::from(member.collected));
            }
            None => complete = false,
        }
    }
    NodeKey { settings: settings.finish(), recipe: complete.then(|| recipe.finish()), error: None }
}
