//! The node editor: a view of the documents that the command line runs.
//!
//! The document, its history and its evaluation live in `orograph-edit`; here are the window's parts. The canvas
//! knows the widget library for graphs and no document, the inspector knows specs alone, panes know values alone;
//! [`App`] brings them together.

mod app;
pub mod canvas;
mod clicks;
pub mod inspector;
pub mod theme;
pub mod views;

pub use app::{App, Command, Dialogs, NoDialogs, PluginLoader, Question, Start};
