//! Reading and writing files: the only family that touches them.
//!
//! Formats are plain functions on bytes; the nodes around them load and save.

mod archive;
pub mod ascii;
pub mod exr;
mod file;
pub mod geotiff;
pub mod ground;
pub mod hgt;
mod png;
pub mod raw;
pub mod read_dem;
pub mod read_exr;
pub mod read_mask;
pub mod read_png;
pub mod read_points;
pub mod read_raw;
pub mod read_texture;
pub mod read_tile;
mod solid;
pub mod target;
#[cfg(test)]
mod tests;
mod whole;
pub mod write_ascii;
pub mod write_exr;
pub mod write_geotiff;
pub mod write_geotiff_texture;
pub mod write_gltf;
pub mod write_hgt;
pub mod write_mask;
pub mod write_obj;
pub mod write_png;
pub mod write_raw;
pub mod write_table;
pub mod write_texture;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<read_dem::ReadDem>(),
        NodeType::of::<read_exr::ReadExr>(),
        NodeType::of::<read_mask::ReadMask>(),
        NodeType::of::<read_png::ReadPng>(),
        NodeType::of::<read_points::ReadPoints>(),
        NodeType::of::<read_raw::ReadRaw>(),
        NodeType::of::<read_texture::ReadTexture>(),
        NodeType::of::<read_tile::ReadTile>(),
        NodeType::of::<write_ascii::WriteAscii>(),
        NodeType::of::<write_exr::WriteExr>(),
        NodeType::of::<write_geotiff::WriteGeotiff>(),
        NodeType::of::<write_geotiff_texture::WriteGeotiffTexture>(),
        NodeType::of::<write_gltf::WriteGltf>(),
        NodeType::of::<write_hgt::WriteHgt>(),
        NodeType::of::<write_mask::WriteMask>(),
        NodeType::of::<write_obj::WriteObj>(),
        NodeType::of::<write_png::WritePng>(),
        NodeType::of::<write_raw::WriteRaw>(),
        NodeType::of::<write_table::WriteTable>(),
        NodeType::of::<write_texture::WriteTexture>(),
    ]
}
