//! Editing graph documents: reversible changes, undo without limit, clipboard, recovery.
//!
//! Everything that an editor does to a document below its window. A gesture becomes a function on the document
//! ([`operations`], [`subgraph`], [`clipboard`]), [`Editing`] finds out what it changed, and that [`Delta`] is what
//! undo takes back. The document is the one that the command line runs.

pub mod beside;
mod chain;
pub mod clipboard;
mod delta;
pub mod file;
mod history;
mod interface;
mod journal;
mod keeper;
pub mod looks;
pub mod operations;
mod runner;
pub mod subgraph;
mod teller;
mod time_left;

pub use beside::Beside;
pub use delta::{Change, Delta, Foreign, Swap};
pub use file::OpenFile;
pub use history::Editing;
pub use interface::{Interface, Interfaces, Kind, Offered, Port};
pub use journal::{Journal, Left, Recovery};
pub use keeper::{Change as SettingsChange, Keeper};
pub use operations::Refused;
pub use runner::{Badge, Fault, News, Runner, Scene, Shown, Wish};
pub use time_left::TimeLeft;
