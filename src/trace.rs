//! What ran when, as a file that `chrome://tracing` and Perfetto show: the Trace Event Format of Chrome.

use std::{
    collections::BTreeMap,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use orograph_engine::{
    Observer, Report,
    eval::{Event, NodeReport},
    save_whole,
};
use serde_json::{Value as Json, json};

use crate::failure::Failure;

/// Notes when nodes begin and end, and hands every event on.
pub(crate) struct Trace {
    inner: Arc<dyn Observer>,
    begun: Instant,
    spans: Mutex<Spans>,
}

#[derive(Default)]
struct Spans {
    running: BTreeMap<String, Duration>,
    /// Name, begin and end, in the order of their ends.
    over: Vec<(String, Duration, Duration)>,
}

impl Trace {
    pub(crate) fn new(inner: Arc<dyn Observer>) -> Self {
        Self { inner, begun: Instant::now(), spans: Mutex::default() }
    }

    fn spans(&self) -> MutexGuard<'_, Spans> {
        self.spans.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what was noted, with what the report tells of each node.
    pub(crate) fn save(&self, path: &Path, report: &Report) -> Result<(), Failure> {
        let text = self.document(report).to_string();
        save_whole(path, text.as_bytes())
            .map_err(|error| Failure::Other(format!("writing the trace {}: {error}", path.display())))
    }

    fn document(&self, report: &Report) -> Json {
        let mut spans = self.spans().over.clone();
        spans.sort_by_key(|(_, begun, _)| *begun);
        // Each row of the picture holds spans that follow each other.
        let mut rows: Vec<Duration> = Vec::new();
        let mut events = Vec::new();
        for (name, begun, ended) in spans {
            let row = rows.iter().position(|free| *free <= begun).unwrap_or(rows.len());
            rows.resize(rows.len().max(row + 1), Duration::ZERO);
            rows[row] = ended;
            let node = report.nodes.iter().find(|node| node.name == name);
            events.push(json!({
                "name": name,
                "cat": node.and_then(|node| node.id.split('.').next()).unwrap_or_default(),
                "ph": "X",
                "ts": micros(begun),
                "dur": micros(ended.saturating_sub(begun)),
                "pid": 1,
                "tid": row + 1,
                "args": node.map(arguments),
            }));
        }
        json!({"displayTimeUnit": "ms", "traceEvents": events})
    }
}

/// Thousandths of a millisecond, with fractions.
fn micros(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1e3
}

fn arguments(node: &NodeReport) -> Json {
    json!({
        "node": node.id,
        "outcome": node.outcome.word(),
        "key": node.key.map(|key| key.to_string()),
        // Of a node that ran together with others, its own share of their time.
        "seconds": node.micros as f64 / 1e6,
        "bytes": node.bytes,
        "reason": node.reason,
    })
}

impl Observer for Trace {
    fn event(&self, event: &Event<'_>) {
        let now = self.begun.elapsed();
        match event {
            Event::Started { node } => {
                self.spans().running.insert((*node).to_owned(), now);
            }
            Event::Finished { node, .. } => {
                let mut spans = self.spans();
                if let Some(begun) = spans.running.remove(*node) {
                    spans.over.push(((*node).to_owned(), begun, now));
                }
            }
            _ => {}
        }
        self.inner.event(event);
    }
}
