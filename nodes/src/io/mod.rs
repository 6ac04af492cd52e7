//! Reading and writing files: the only family that touches them.
//!
//! Formats are plain functions on bytes; the nodes around them load and save.

mod archive;
pub mod ascii;
mod file;
pub mod geotiff;
pub mod ground;
pub mod hgt;
pub mod read_dem;
pub mod read_png;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![NodeType::of::<read_dem::ReadDem>(), NodeType::of::<read_png::ReadPng>()]
}
