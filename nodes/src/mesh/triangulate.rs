//! Triangulate: terrain as a mesh, with as few triangles as a chosen error allows.

use orograph_core::{Mesh, Unit, prelude::*};
use rayon::prelude::*;

use super::{
    greedy::{self, Limits},
    rim::{self, Rim},
    shape::{self, Origin},
    squares,
};

/// How triangles are laid.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Large where the ground is even, small where it is not: no cell centre is further from the mesh than the error.
    Adaptive,
    /// Every cell a vertex.
    Regular,
}

/// Turns terrain into a triangle mesh with normals and texture coordinates.
///
/// The adaptive method keeps every height within `max_error` of the mesh, measured straight up or down at the centre of
/// each cell, by greedy insertion into a Delaunay triangulation (Garland and Heckbert 1995). Vertices are cell centres,
/// so the mesh ends half a cell inside the terrain's outer edges, while texture coordinates run from 0 to 1 over those:
/// a texture made from the terrain lies on it exactly. Voids become holes.
#[derive(Params, Clone, Debug)]
pub struct Triangulate {
    /// How triangles are laid.
    #[param(default = Method::Adaptive)]
    pub method: Method,
    /// How far the mesh may be above or below the centre of a cell.
    #[param(default = 1, range = 0.001..=10_000.0, slider = 0.1..=100.0, unit = "m")]
    pub max_error: f64,
    /// Stops the adaptive method at so many triangles, with a remark on the error that is left; 0 is no limit.
    #[param(default = 0u32, range = 0..=1_000_000_000, slider = 0..=1_000_000, unit = "1")]
    pub max_triangles: u32,
    /// Where the mesh's zero lies on the ground.
    #[param(default = Origin::Middle)]
    pub origin: Origin,
    /// What the mesh has below its rim and around its holes.
    #[param(default = Rim::Open)]
    pub rim: Rim,
    /// How far a skirt hangs down, or a body's floor lies below the lowest vertex.
    #[param(default = 50, range = 0.001..=10_000.0, slider = 1.0..=500.0, unit = "m")]
    pub depth: f64,
}

/// Inputs of [`Triangulate`].
#[derive(Inputs)]
pub struct TriangulateIn<'a> {
    /// Terrain to turn into a mesh.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Triangulate`].
#[derive(Outputs)]
pub struct TriangulateOut {
    /// The mesh.
    pub mesh: Mesh,
    /// Its vertices and triangles, the error that it keeps, and its vertices for each known cell.
    pub metrics: Table,
}

impl Node for Triangulate {
    const ID: &'static str = "mesh.triangulate";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = TriangulateIn<'a>;
    type Outputs = TriangulateOut;

    fn cost(&self) -> f64 {
        40.0
    }

    fn run(&self, inputs: TriangulateIn<'_>, job: &Job) -> Result<TriangulateOut> {
        let terrain = inputs.terrain;
        job.check()?;
        check_terrain(terrain)?;
        let (triangles, error) = match self.method {
            Method::Adaptive => self.adaptive(terrain, job)?,
            Method::Regular => (squares::regular(terrain, job)?, 0.0),
        };
        if triangles.is_empty() {
            return Err(Error::invalid(
                "no three neighbouring cells are known, so there is no triangle",
                "fill the voids first",
            ));
        }
        let voids = terrain.void_count();
        let lonely = if voids > 0 { squares::lonely_cells(terrain) } else { 0 };
        if lonely > 0 {
            job.warn(format!("{lonely} cells that stand alone among voids are in no triangle"));
        }
        let mut mesh = shape::shaped(terrain, triangles, self.origin, job)?;
        rim::close(&mut mesh, self.rim, self.depth, job)?;
        if let Some(told) = self.origin.told(terrain.grid()) {
            job.warn(told);
        }
        let (vertices, triangles) = (mesh.vertices.len() as f64, mesh.triangles.len() as f64);
        let known = (terrain.grid().len() - voids) as f64;
        let metrics = Table::metrics([
            ("vertices", Unit::One, vertices),
            ("triangles", Unit::One, triangles),
            ("greatest_error", Unit::Metre, error),
            ("vertices_per_cell", Unit::One, vertices / known),
        ])?;
        Ok(TriangulateOut { mesh, metrics })
    }
}

impl Triangulate {
    /// The triangles, by cells, and the most by which a cell is missed.
    fn adaptive(&self, terrain: &Heightfield, job: &Job) -> Result<(Vec<[u32; 3]>, f64)> {
        let most = if self.max_triangles == 0 { usize::MAX } else { self.max_triangles as usize };
        let limits = Limits { error: self.max_error, triangles: most };
        let approximation = greedy::approximate(terrain, limits, job)?;
        let triangles = squares::adaptive(terrain, &approximation, job)?;
        if approximation.error > self.max_error {
            job.warn(format!(
                "{} triangles leave cells that are {} m off, more than the {} m asked for",
                triangles.len(),
                approximation.error,
                self.max_error
            ));
        }
        Ok((triangles, approximation.error))
    }
}

/// Refuses what has no triangles, or too many cells to number.
fn check_terrain(terrain: &Heightfield) -> Result<()> {
    let (rows, cols) = terrain.grid().size();
    terrain.known_range("terrain")?;
    if rows < 2 || cols < 2 {
        return Err(Error::BadSize { what: "terrain".into(), rows, cols, min: 2 });
    }
    /// Rows and columns up to here keep the arithmetic of circles exact, cells up to there have numbers.
    const MOST: (usize, usize) = (1 << 24, u32::MAX as usize);
    if rows.max(cols) > MOST.0 || terrain.grid().len() > MOST.1 {
        return Err(Error::invalid(
            format!("{rows} × {cols} cells are too many for one mesh"),
            "crop the terrain, or make a mesh of each part with `origin` world",
        ));
    }
    let infinite = terrain.cells().par_iter().position_first(|height| height.is_infinite());
    infinite
        .map_or(Ok(()), |at| Err(Error::NonFinite { what: "terrain".into(), row: at / cols, col: at % cols }))
}
