//! Orograph's engine: the graph, its evaluation, the cache, documents and the registry.
//!
//! The engine never names a node: it learns node types from a [`Registry`] that its caller fills.

pub mod cache;
pub mod compile;
pub mod document;
pub mod eval;
pub mod graph;
pub mod manual;
pub mod plugin;
pub mod registry;
mod suggest;
#[doc(hidden)]
pub mod untrusted;
mod whole;

pub use cache::{Cache, DiskTier};
pub use compile::{CompileOptions, Compiled, ExposedParam, compile, expand_path};
pub use document::{Document, DocumentError, DocumentErrors};
pub use eval::{CancelToken, Evaluator, Observer, Outcome, Report, Request};
pub use graph::{Graph, GraphBuilder, GraphError, GraphNode, NodeId, OutputRef};
pub use registry::Registry;
pub use whole::{save_whole, write_whole};
