//! What a run tells while it goes on and when it is over.

use std::{collections::HashMap, sync::Arc};

use orograph_core::{Digest, Error, Value};
use serde::Serialize;

use crate::{
    cache::{Record, Tier, WrittenFile},
    graph::NodeId,
};

/// How a node came by its outputs, or why it did not.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Its recipe was known.
    Hit(Tier),
    /// Its recipe was new, but its inputs turned out as in an earlier computation.
    Cutoff(Tier),
    /// It ran.
    Computed,
    /// It ran band by band, together with the nodes around it; its values were never there as a whole, unless others
    /// needed them so.
    Streamed,
    /// It failed.
    Failed(Error),
    /// Something that it needs failed.
    Skipped {
        /// The name of the node that failed.
        because: String,
    },
}

impl Outcome {
    /// Whether the node ran, and came to its end.
    #[must_use]
    pub fn is_run(&self) -> bool {
        matches!(self, Self::Computed | Self::Streamed)
    }

    /// One word for tables and manifests.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Hit(Tier::Memory) => "memory",
            Self::Hit(Tier::Disk) => "disk",
            Self::Cutoff(_) => "cutoff",
            Self::Computed => "computed",
            Self::Streamed => "streamed",
            Self::Failed(Error::Cancelled) => "cancelled",
            Self::Failed(_) => "failed",
            Self::Skipped { .. } => "skipped",
        }
    }
}

/// What happens during a run; times and shares are for display.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// A node began to run, in this run: one that another run computes for both is not told.
    Started {
        /// Its name.
        node: &'a str,
    },
    /// A running node got on, be it that another run computes it for both.
    Progress {
        /// Its name.
        node: &'a str,
        /// Share of its work that is done.
        done: f64,
        /// Share of the run's work that is done, weighted by cost.
        overall: f64,
    },
    /// A running node said something that is not kept.
    Note {
        /// Its name.
        node: &'a str,
        /// What it said.
        message: &'a str,
    },
    /// A node is over.
    Finished {
        /// Its name.
        node: &'a str,
        /// How.
        outcome: &'a Outcome,
        /// Share of the run's work that is done, weighted by cost.
        overall: f64,
    },
}

/// Hears of a run's events, from any thread.
pub trait Observer: Send + Sync {
    /// Hears one event; it should return at once.
    fn event(&self, event: &Event<'_>);
}

/// Hears nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Event<'_>) {}
}

/// One node's part in a run.
#[derive(Clone, Debug)]
pub struct NodeReport {
    /// Which node.
    pub node: NodeId,
    /// Its name.
    pub name: String,
    /// Its type's id.
    pub id: String,
    /// Its type's version.
    pub version: u32,
    /// What became of it.
    pub outcome: Outcome,
    /// Why it ran, when it ran.
    pub reason: Option<String>,
    /// Its recipe key; none when a file that it needs cannot be read.
    pub key: Option<Digest>,
    /// Microseconds that it took in this run; 0 on a hit.
    pub micros: u64,
    /// The digest of each output, by name.
    pub outputs: Vec<(String, Digest)>,
    /// Bytes of all outputs.
    pub bytes: u64,
    /// The files that it wrote, or that were up to date.
    pub files: Vec<WrittenFile>,
    /// What it told the user.
    pub warnings: Vec<String>,
}

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Every node that the run needed to look at, in topological order.
    pub nodes: Vec<NodeReport>,
    /// The values of the outputs asked for, in that order; none where they failed.
    pub values: Vec<Option<Value>>,
    pub(crate) records: HashMap<NodeId, Arc<Record>>,
}

impl Report {
    pub(crate) fn record(&self, node: NodeId) -> Option<&Arc<Record>> {
        self.records.get(&node)
    }

    /// The nodes that ran.
    pub fn computed(&self) -> impl Iterator<Item = &NodeReport> {
        self.nodes.iter().filter(|node| node.outcome.is_run())
    }

    /// The nodes that failed by themselves.
    pub fn failures(&self) -> impl Iterator<Item = (&NodeReport, &Error)> {
        self.nodes.iter().filter_map(|node| match &node.outcome {
            Outcome::Failed(error) => Some((node, error)),
            _ => None,
        })
    }

    /// Whether the run was cancelled before its end.
    #[must_use]
    pub fn was_cancelled(&self) -> bool {
        self.failures().any(|(_, error)| *error == Error::Cancelled)
    }

    /// How many nodes had each kind of outcome.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for node in &self.nodes {
            match &node.outcome {
                Outcome::Hit(_) | Outcome::Cutoff(_) => counts.hits += 1,
                Outcome::Computed | Outcome::Streamed => counts.computed += 1,
                Outcome::Failed(_) => counts.failed += 1,
                Outcome::Skipped { .. } => counts.skipped += 1,
            }
        }
        counts
    }
}

/// Numbers of nodes by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Found in the cache.
    pub hits: usize,
    /// Run.
    pub computed: usize,
    /// Failed by themselves.
    pub failed: usize,
    /// Not run because something before them failed.
    pub skipped: usize,
}
