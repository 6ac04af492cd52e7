//! What a run has to do with others that want the same: it waits for them, works for them, and leaves work to them.

use std::{sync::PoisonError, time::Duration};

use orograph_core::{Digest, Error};

use super::Run;
use crate::eval::state::Scheduler;

impl Run {
    /// Waits until nothing is left to do, or, once the run was cancelled, until the rest is the business of others.
    pub(super) fn wait(&self) {
        const POLL: Duration = Duration::from_millis(20);
        let mut state = self.lock();
        while !state.is_quiet() {
            if self.cancel.is_cancelled() {
                let mut scheduler = Scheduler::new(self, &mut state);
                scheduler.leave();
                let ended = scheduler.into_ended();
                if !ended.is_empty() {
                    let overall = self.overall(&state);
                    drop(state);
                    self.tell(&ended, overall);
                    state = self.lock();
                    continue;
                }
            }
            state = self.quiet.wait_timeout(state, POLL).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Notes that a node wants its action; whether that is under way, so that the node need only wait.
    pub(crate) fn want(&self, node: u32, action: Digest) -> bool {
        self.shared.in_flight.want(action, &self.me, node, &self.cancel)
    }

    /// Takes back what [`want`](Self::want) noted of a node that was not told to wait.
    pub(crate) fn forget(&self, node: u32, action: Digest) {
        self.shared.in_flight.forget(action, &self.me, node);
    }

    /// Whether a node that runs here is wanted by another run, too, that was not cancelled. A writer writes into the folder
    /// of this run alone.
    pub(crate) fn goes_on_for_others(&self, node: u32, action: &Digest) -> bool {
        !self.node(node).spec().is_some_and(|spec| spec.writes) && self.shared.in_flight.is_wanted(action)
    }

    /// Goes on with a node whose action another run has computed, or has not.
    pub(super) fn resume(&self, node: u32, result: &Result<(), Error>) {
        self.change(|scheduler| scheduler.resume(node, result));
        let mut state = self.lock();
        self.call_workers(&mut state, 0);
        if state.is_quiet() {
            self.quiet.notify_all();
        }
    }
}
