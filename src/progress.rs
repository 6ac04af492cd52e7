//! Progress: a bar on a terminal, plain lines otherwise.

use std::{
    collections::BTreeSet,
    io::IsTerminal,
    sync::{Arc, Mutex, PoisonError},
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use orograph_core::Error;
use orograph_engine::{
    Observer, Outcome,
    eval::{Event, Silent},
};

use crate::console;

/// The observer for a run, and the bar to clear after it.
pub(crate) fn observer(quiet: bool) -> (Arc<dyn Observer>, Option<ProgressBar>) {
    if quiet {
        return (Arc::new(Silent), None);
    }
    if !std::io::stderr().is_terminal() {
        return (Arc::new(Lines), None);
    }
    const STEPS: u64 = 1000;
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(15));
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3}% {elapsed} eta {eta}  {wide_msg}")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    (Arc::new(Bar { bar: bar.clone(), running: Mutex::default() }), Some(bar))
}

/// One line for each node that ran or failed.
struct Lines;

impl Observer for Lines {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Note { node, message } => console::note(&format!("{node}: {message}")),
            Event::Finished { node, outcome: Outcome::Computed | Outcome::Streamed, .. } => {
                console::note(&format!("computed {node}"));
            }
            Event::Finished { node, outcome: Outcome::Failed(error), .. } if *error != Error::Cancelled => {
                console::note(&format!("failed   {node}"));
            }
            _ => {}
        }
    }
}

struct Bar {
    bar: ProgressBar,
    running: Mutex<BTreeSet<String>>,
}

impl Observer for Bar {
    fn event(&self, event: &Event<'_>) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let overall = match event {
            Event::Started { node } => {
                running.insert((*node).to_owned());
                None
            }
            Event::Finished { node, overall, .. } => {
                running.remove(*node);
                Some(*overall)
            }
            Event::Progress { overall, .. } => Some(*overall),
            Event::Note { node, message } => {
                self.bar.println(format!("{node}: {message}"));
                None
            }
        };
        if let Some(overall) = overall {
            self.bar.set_position((overall * 1000.0) as u64);
        }
        self.bar.set_message(running.iter().cloned().collect::<Vec<_>>().join(", "));
    }
}
