//! What stands below the rim of a mesh: skirts that hide gaps between meshes, or walls and a floor for printing.

use orograph_core::{Mesh, prelude::*};
use rayon::prelude::*;

use super::pinch;

/// What a mesh has below its rim and around its holes.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rim {
    /// Nothing: an open surface.
    Open,
    /// Walls that hang down by the depth everywhere, to hide gaps between neighbouring meshes.
    Skirt,
    /// Walls down to a flat floor, the depth below the lowest vertex: a closed body, for printing.
    Body,
}

/// Adds to an open mesh what belongs below its rim.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Cancelled`].
pub(super) fn close(mesh: &mut Mesh, rim: Rim, depth: f64, job: &Job) -> Result<()> {
    if rim == Rim::Open {
        return Ok(());
    }
    let mut edges = rim_edges(mesh, job)?;
    if pinch::part(mesh, &edges, job)? {
        edges = rim_edges(mesh, job)?;
    }
    let (vertices, top) = (mesh.vertices.len(), mesh.triangles.len());
    let twice = vertices as u64 * 64 + (top as u64 * 2 + edges.len() as u64 * 2) * 12;
    job.admit(twice, || format!("a mesh of {} vertices", vertices * 2))?;
    // The vertex below each vertex that has one.
    let mut below = vec![u32::MAX; vertices];
    let floor = mesh.vertices.iter().map(|vertex| f64::from(vertex[2])).fold(f64::INFINITY, f64::min) - depth;
    let mut lower = |mesh: &mut Mesh, vertex: u32| -> u32 {
        let index = vertex as usize;
        if below[index] == u32::MAX {
            below[index] = mesh.vertices.len() as u32;
            let [x, y, z] = mesh.vertices[index];
            let z = if rim == Rim::Body { floor } else { f64::from(z) - depth };
            mesh.vertices.push([x, y, z as f32]);
            mesh.normals.push(if rim == Rim::Body { [0.0, 0.0, -1.0] } else { mesh.normals[index] });
            mesh.uvs.push(mesh.uvs[index]);
        }
        below[index]
    };
    for (done, &[from, to]) in edges.iter().enumerate() {
        if done.is_multiple_of(1 << 14) {
            job.check()?;
        }
        let (lower_from, lower_to) = (lower(mesh, from), lower(mesh, to));
        mesh.triangles.extend([[to, from, lower_from], [to, lower_from, lower_to]]);
    }
    if rim == Rim::Body {
        for triangle in 0..top {
            if triangle.is_multiple_of(1 << 14) {
                job.check()?;
            }
            let [a, b, c] = mesh.triangles[triangle].map(|corner| lower(mesh, corner));
            mesh.triangles.push([a, c, b]);
        }
    }
    Ok(())
}

/// The edges that one triangle alone has, as it runs along them.
fn rim_edges(mesh: &Mesh, job: &Job) -> Result<Vec<[u32; 2]>> {
    job.admit(mesh.triangles.len() as u64 * 36, || "the edges of a mesh".into())?;
    let mut edges: Vec<[u32; 3]> = mesh
        .triangles
        .par_iter()
        .flat_map_iter(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[from, to]| [from.min(to), from.max(to), u32::from(from > to)])
        .collect();
    job.check()?;
    edges.par_sort_unstable();
    job.check()?;
    let alone = edges.chunk_by(|a, b| a[..2] == b[..2]).filter(|same| same.len() == 1);
    Ok(alone
        .map(|same| if same[0][2] == 0 { [same[0][0], same[0][1]] } else { [same[0][1], same[0][0]] })
        .collect())
}
