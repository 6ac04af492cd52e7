//! What the formats of meshes share: checks that no reader would forgive, and long lists written in pieces.

use std::io::Write;

use orograph_core::{Mesh, prelude::*};

/// Refuses a mesh that breaks its own rules, or that has no place for the texture.
pub(crate) fn check(mesh: &Mesh, texture: Option<&Texture>, job: &Job) -> Result<()> {
    job.check()?;
    if mesh.vertices.is_empty() || mesh.triangles.is_empty() {
        return Err(Error::EmptyInput { what: "mesh".into() });
    }
    let broken = |what: String| Err(Error::invalid(what, "report it to the author of the node that made it"));
    let vertices = mesh.vertices.len();
    for (name, count) in [("normals", mesh.normals.len()), ("texture coordinates", mesh.uvs.len())] {
        if count != 0 && count != vertices {
            return broken(format!("the mesh has {count} {name} for {vertices} vertices"));
        }
    }
    if let Some(at) = mesh.vertices.iter().position(|vertex| vertex.iter().any(|x| !x.is_finite())) {
        return broken(format!("vertex {at} of the mesh lies nowhere"));
    }
    job.check()?;
    if mesh.triangles.as_flattened().iter().any(|&corner| corner as usize >= vertices) {
        return broken("the mesh has a triangle between vertices that it has not".into());
    }
    let Some(texture) = texture else { return Ok(()) };
    super::file::refuse_empty(texture, "texture")?;
    if mesh.uvs.is_empty() {
        return Err(Error::invalid(
            "the mesh has no texture coordinates to lay the texture by",
            "leave `texture` unconnected, or make the mesh by mesh.triangulate",
        ));
    }
    Ok(())
}

/// Writes the bytes of a long list, asking between pieces whether to stop.
pub(crate) fn stream<T>(
    out: &mut impl Write,
    items: &[T],
    name: &str,
    job: &Job,
    bytes: impl Fn(&T, &mut Vec<u8>),
) -> Result<()> {
    let mut piece = Vec::new();
    for items in items.chunks(1 << 12) {
        job.check()?;
        piece.clear();
        items.iter().for_each(|item| bytes(item, &mut piece));
        out.write_all(&piece).map_err(|reason| Error::writing(name, reason))?;
    }
    Ok(())
}
