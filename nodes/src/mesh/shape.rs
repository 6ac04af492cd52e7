//! From triangles over cells to a mesh in metres: positions, normals, texture coordinates.

use glam::{DVec2, DVec3};
use orograph_core::{Mesh, prelude::*};
use rayon::prelude::*;

use crate::surface::gradient;

/// Where the mesh's zero lies on the ground. Heights stay as they are.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// In the middle of the terrain.
    Middle,
    /// At the outer corner of its south-western cell.
    SouthWest,
    /// Where the terrain's own world has it, so that parts of one terrain fit together.
    World,
}

impl Origin {
    /// The world position that becomes zero.
    fn position(self, grid: &Grid) -> DVec2 {
        let (north_west, south_east) = (grid.position(0, 0), grid.position(grid.rows - 1, grid.cols - 1));
        match self {
            Self::Middle => (north_west + south_east) / 2.0,
            Self::SouthWest => DVec2::new(north_west.x - grid.cell.x / 2.0, south_east.y - grid.cell.y / 2.0),
            Self::World => DVec2::ZERO,
        }
    }

    /// The mesh's zero in the terrain's coordinate system, in words; `None` without one.
    pub(super) fn told(self, grid: &Grid) -> Option<String> {
        let georef = grid.georef_here()?;
        let (row, col) = grid.locate(self.position(grid));
        // Transforms start at a cell's corner, places at its centre.
        let (row, col) = (row + 0.5, col + 0.5);
        let [x0, x_col, x_row, y0, y_col, y_row] = georef.transform;
        let (x, y) = (x0 + x_col * col + x_row * row, y0 + y_col * col + y_row * row);
        let crs = if georef.crs.is_empty() { "the terrain's coordinates" } else { &georef.crs };
        Some(format!("the mesh's origin lies at x {x}, y {y} in {crs}"))
    }
}

/// The mesh of triangles whose corners are numbers of cells, row by row. Its vertices are those cells in their order.
///
/// # Errors
/// [`Error::TooLarge`]; [`Error::Cancelled`].
pub(super) fn shaped(
    terrain: &Heightfield,
    mut triangles: Vec<[u32; 3]>,
    origin: Origin,
    job: &Job,
) -> Result<Mesh> {
    let grid = terrain.grid();
    let mut used = vec![0_u64; grid.len().div_ceil(64)];
    for corner in triangles.as_flattened() {
        used[*corner as usize / 64] |= 1 << (corner % 64);
    }
    job.check()?;
    // How many used cells come before each word: with them a cell knows its vertex.
    let mut before = Vec::with_capacity(used.len());
    let mut count = 0_u32;
    for word in &used {
        before.push(count);
        count += word.count_ones();
    }
    job.admit(u64::from(count) * 32 + triangles.len() as u64 * 12, || format!("a mesh of {count} vertices"))?;
    triangles.par_iter_mut().for_each(|corners| {
        *corners = corners.map(|cell| {
            let (word, bit) = (cell as usize / 64, cell % 64);
            before[word] + (used[word] & ((1 << bit) - 1)).count_ones()
        });
    });
    let cells: Vec<u32> = (0..)
        .zip(&used)
        .flat_map(|(word, &bits)| {
            (0..64_u32).filter(move |bit| (bits >> bit) & 1 == 1).map(move |bit| word * 64 + bit)
        })
        .collect();
    job.check()?;
    let zero = origin.position(grid);
    let place = |cell: u32| (cell as usize / grid.cols, cell as usize % grid.cols);
    let vertex = |&cell: &u32| {
        let (row, col) = place(cell);
        let flat = grid.position(row, col) - zero;
        [flat.x as f32, flat.y as f32, terrain.at(row, col)]
    };
    let normal = |&cell: &u32| {
        let (row, col) = place(cell);
        let rise = gradient(terrain, row, col).unwrap_or(DVec2::ZERO);
        DVec3::new(-rise.x, -rise.y, 1.0).normalize().as_vec3().to_array()
    };
    let uv = |&cell: &u32| {
        let (row, col) = place(cell);
        let (east, north) = (col as f64 + 0.5, (grid.rows - row) as f64 - 0.5);
        [(east / grid.cols as f64) as f32, (north / grid.rows as f64) as f32]
    };
    let vertices = cells.par_iter().map(vertex).collect();
    job.check()?;
    let normals = cells.par_iter().map(normal).collect();
    job.check()?;
    let uvs = cells.par_iter().map(uv).collect();
    Ok(Mesh { vertices, triangles, normals, uvs })
}
