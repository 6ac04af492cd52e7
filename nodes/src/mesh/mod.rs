//! Triangle meshes of terrain.

mod delaunay;
mod greedy;
mod pinch;
pub mod rim;
pub mod shape;
mod squares;
#[cfg(test)]
mod tests;
pub mod triangulate;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<triangulate::Triangulate>()]
}
