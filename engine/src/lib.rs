//! Orograph's engine: the graph, its evaluation, the cache, documents and the registry.
//!
//! The engine never names a node: it learns node types from a [`Registry`] that its caller fills.

pub mod cache;
pub mod eval;
pub mod graph;
pub mod registry;

pub use cache::{Cache, DiskTier};
pub use eval::{CancelToken, Evaluator, Observer, Outcome, Report, Request};
pub use graph::{Graph, GraphBuilder, GraphError, GraphNode, NodeId, OutputRef};
pub use registry::Registry;
