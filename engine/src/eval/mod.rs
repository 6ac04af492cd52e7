//! Evaluation: lazy, keyed before valued, cached, parallel, deterministic.
//!
//! A run asks for outputs. Each node has two keys. Its *recipe* key follows from settings, files, context and
//! the recipe keys of its inputs, so it is known before any value; a hit there ends the walk. On a miss the
//! inputs are asked for, and the *action* key follows from their content digests: a hit there is early cutoff.
//! Only then does the node run. No thread ever blocks on a node: one that waits is a line in a table.

mod call;
mod cancel;
mod explain;
mod host;
mod in_flight;
mod key;
mod output;
mod plan;
mod report;
mod run;
mod state;
mod stream;

use std::{
    path::PathBuf,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
};

use orograph_core::{Context, Value};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

pub use cancel::CancelToken;
pub use output::OutputFolder;
pub use plan::Planned;
pub use report::{Event, NodeReport, Observer, Outcome, Report, Silent};

use crate::{
    cache::Cache,
    graph::{Graph, NodeId, OutputRef},
};
use in_flight::InFlight;
use run::Run;

/// Evaluates graphs on one thread pool over one cache; any number of runs may be under way.
pub struct Evaluator {
    shared: Arc<Shared>,
}

/// What the runs of an evaluator share.
pub(crate) struct Shared {
    pub(crate) cache: Cache,
    pub(crate) pool: ThreadPool,
    pub(crate) jobs: usize,
    pub(crate) in_flight: InFlight,
    backlog: Mutex<Backlog>,
    written: Condvar,
}

/// What is still to be written to the cache folder.
#[derive(Default)]
struct Backlog {
    items: usize,
    bytes: u64,
}

/// What a run is asked for.
#[derive(Clone)]
pub struct Request {
    /// The graph.
    pub graph: Arc<Graph>,
    /// Outputs whose values are wanted.
    pub outputs: Vec<OutputRef>,
    /// Writers that are to write their files.
    pub writers: Vec<NodeId>,
    /// Seed and resolution.
    pub context: Context,
    /// Where writers write.
    pub out_dir: PathBuf,
    /// Names this graph's history, so that a later run can tell what changed; no history without it.
    pub history: Option<String>,
}

impl Request {
    /// A request for the values of `outputs`, with nothing written.
    #[must_use]
    pub fn values(graph: Arc<Graph>, outputs: Vec<OutputRef>) -> Self {
        Self {
            graph,
            outputs,
            writers: Vec::new(),
            context: Context::default(),
            out_dir: PathBuf::from("out"),
            history: None,
        }
    }

    /// The nodes that the request depends on, inputs first.
    pub(crate) fn wanted(&self) -> Vec<NodeId> {
        let graph = &self.graph;
        let mut wanted = vec![false; graph.nodes().len()];
        let mut stack: Vec<NodeId> = self.outputs.iter().map(|output| output.node).collect();
        stack.extend(&self.writers);
        while let Some(id) = stack.pop() {
            if !std::mem::replace(&mut wanted[id.index()], true) {
                stack.extend(graph.node(id).inputs.iter().flatten().map(|wire| wire.node));
            }
        }
        graph.order().iter().copied().filter(|id| wanted[id.index()]).collect()
    }
}

impl Evaluator {
    /// An evaluator on `jobs` threads over `cache`; 0 jobs means one for each core.
    ///
    /// # Errors
    /// When the threads cannot be started.
    pub fn new(cache: Cache, jobs: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(jobs)
            .thread_name(|index| format!("node-{index}"))
            // Node tasks may nest as deep as there are jobs; rayon's default stack is the platform's.
            .stack_size(8 << 20)
            .build()?;
        let jobs = pool.current_num_threads();
        let shared = Shared {
            cache,
            pool,
            jobs,
            in_flight: InFlight::default(),
            backlog: Mutex::default(),
            written: Condvar::new(),
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// The cache.
    #[must_use]
    pub fn cache(&self) -> &Cache {
        &self.shared.cache
    }

    /// Runs a request to its end, or until it is cancelled. Must not be called from inside a node.
    ///
    /// Runs that want the same computation share it. A node stops when every run that wants it was cancelled; a run that
    /// was cancelled does not wait for a node that goes on for others.
    pub fn run(&self, request: Request, observer: Arc<dyn Observer>, cancel: &CancelToken) -> Report {
        const ATTEMPTS: usize = 3;
        let outputs = request.outputs.clone();
        let run = Run::new(Arc::clone(&self.shared), request, observer, cancel.clone());
        for _ in 1..ATTEMPTS {
            run.execute();
            let report = run.report();
            // A cached value can prove damaged at the very last step; then its node runs again.
            if let Some(report) = self.with_values(report, &outputs) {
                return report;
            }
        }
        run.execute();
        run.report()
    }

    fn with_values(&self, mut report: Report, outputs: &[OutputRef]) -> Option<Report> {
        let mut values: Vec<Option<Value>> = Vec::with_capacity(outputs.len());
        for output in outputs {
            match report.record(output.node) {
                Some(record) => {
                    let stored = record.outputs.get(output.output as usize)?;
                    values.push(Some(self.shared.cache.value(stored)?));
                }
                None => values.push(None),
            }
        }
        report.values = values;
        Some(report)
    }

    /// Waits until everything computed so far lies on disk.
    pub fn flush(&self) {
        self.shared.wait_for_writes();
    }
}

impl Drop for Evaluator {
    fn drop(&mut self) {
        self.flush();
    }
}

impl Shared {
    /// Does some writing on the pool, after the work that is already waiting there. What waits holds its
    /// `bytes` in memory; when that is a quarter of the budget, the caller writes by itself.
    pub(crate) fn write_behind(self: &Arc<Self>, bytes: u64, work: impl FnOnce(&Cache) + Send + 'static) {
        {
            let mut backlog = self.backlog();
            if backlog.bytes + bytes > self.cache.memory_budget() / 4 {
                drop(backlog);
                work(&self.cache);
                return;
            }
            backlog.items += 1;
            backlog.bytes += bytes;
        }
        let shared = Arc::clone(self);
        self.pool.spawn(move || {
            work(&shared.cache);
            let mut backlog = shared.backlog();
            backlog.items -= 1;
            backlog.bytes -= bytes;
            if backlog.items == 0 {
                shared.written.notify_all();
            }
        });
    }

    fn backlog(&self) -> MutexGuard<'_, Backlog> {
        self.backlog.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_for_writes(&self) {
        let mut backlog = self.backlog();
        while backlog.items > 0 {
            backlog = self.written.wait(backlog).unwrap_or_else(PoisonError::into_inner);
        }
    }
}
