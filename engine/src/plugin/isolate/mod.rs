//! Plugins in processes of their own: what goes wrong there is a node's error here.
//!
//! Values cross through two files of shared memory, everything else as messages. A worker serves one node after
//! another; one that ends, falls silent or is cancelled is replaced by the next.

#[cfg(unix)]
mod client;
#[cfg(unix)]
mod message;
#[cfg(unix)]
mod server;
#[cfg(unix)]
mod shared;

use std::time::Duration;

#[cfg(unix)]
pub(super) use client::Workers;
#[cfg(unix)]
pub(super) use server::serve;

/// What a plugin that runs apart may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// How long it may neither ask whether to stop nor report progress before it counts as hung.
    pub silence: Duration,
    /// How long one run of a node may take at most, when there is such a limit.
    pub time: Option<Duration>,
    /// Bytes that it may take beyond its inputs.
    pub memory: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { silence: Duration::from_secs(60), time: None, memory: 8 << 30 }
    }
}

#[cfg(not(unix))]
mod elsewhere;
#[cfg(not(unix))]
pub(super) use elsewhere::{Workers, serve};
