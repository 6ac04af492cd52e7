//! Triangle meshes.

use serde::{Deserialize, Serialize};

/// A triangle mesh in metres, x east, y north, z up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<[f32; 3]>,
    /// Vertex indices, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals, one per vertex, or none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates in 0..=1, one per vertex, or none: from west to east, and from south to north.
    pub uvs: Vec<[f32; 2]>,
}
