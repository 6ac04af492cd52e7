//! Vertices where parts of a mesh touch in a point, such as between two voids with one cell between them.
//!
//! Walls below them would meet in one line, which belongs to no closed body: each part gets a vertex of its own.

use orograph_core::{Mesh, prelude::*};

/// Gives each part of the mesh at a pinched vertex a vertex of its own. The rim is given as its directed edges; returns
/// whether there was anything to do.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn part(mesh: &mut Mesh, rim: &[[u32; 2]], job: &Job) -> Result<bool> {
    // The rim leaves an ordinary vertex once.
    let mut leaving: Vec<u32> = rim.iter().map(|edge| edge[0]).collect();
    leaving.sort_unstable();
    let pinched: Vec<u32> =
        leaving.chunk_by(|a, b| a == b).filter(|same| same.len() > 1).map(|same| same[0]).collect();
    if pinched.is_empty() {
        return Ok(false);
    }
    let mut around: Vec<(u32, u32)> = Vec::new();
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        let at = corners.iter().filter(|corner| pinched.binary_search(corner).is_ok());
        around.extend(at.map(|&corner| (corner, triangle)));
    }
    job.check()?;
    around.sort_unstable();
    for (done, same) in around.chunk_by(|a, b| a.0 == b.0).enumerate() {
        if done.is_multiple_of(1 << 12) {
            job.check()?;
        }
        let vertex = same[0].0;
        let mut left: Vec<u32> = same.iter().map(|&(_, triangle)| triangle).collect();
        // The first part keeps the vertex.
        take_part(mesh, vertex, &mut left);
        while !left.is_empty() {
            let own = mesh.vertices.len() as u32;
            let index = vertex as usize;
            mesh.vertices.push(mesh.vertices[index]);
            mesh.normals.push(mesh.normals[index]);
            mesh.uvs.push(mesh.uvs[index]);
            for triangle in take_part(mesh, vertex, &mut left) {
                let corners = &mut mesh.triangles[triangle as usize];
                *corners = corners.map(|corner| if corner == vertex { own } else { corner });
            }
        }
    }
    Ok(true)
}

/// Takes from the triangles around a vertex the first one and those that hang together with it by edges.
fn take_part(mesh: &Mesh, vertex: u32, left: &mut Vec<u32>) -> Vec<u32> {
    let mut part = Vec::new();
    let mut found: Vec<u32> = if left.is_empty() { Vec::new() } else { vec![left.remove(0)] };
    while let Some(triangle) = found.pop() {
        part.push(triangle);
        let corners = mesh.triangles[triangle as usize];
        let beside = |other: &u32| {
            let others = mesh.triangles[*other as usize];
            others.iter().any(|corner| *corner != vertex && corners.contains(corner))
        };
        let (near, far) = left.iter().partition(|other| beside(other));
        *left = far;
        found.extend::<Vec<u32>>(near);
    }
    part
}
