//! The commands, one a file.

pub(crate) mod cache;
pub(crate) mod check;
pub(crate) mod completions;
mod each;
pub(crate) mod graph;
pub(crate) mod manual;
pub(crate) mod nodes;
pub(crate) mod plugin;
pub(crate) mod run;
pub(crate) mod sweep;
mod watch;
