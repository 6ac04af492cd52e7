//! Target connection: neighbouring candidates joined.
//!
//! Chang, Song, Hsu (1998), second step. Every pair of the eight-neighbourhood is joined; where two diagonals cross,
//! the less important one goes, and of equals the one from south-west to north-east.

use orograph_core::prelude::*;
use rayon::prelude::*;

use super::{
    forest::{Forest, Frame},
    lattice::{Blocks, Lattice, block_means},
    settings::{Importance, WorkingCells, crest},
};

/// Joins neighbouring candidates by segments. The second of the four steps of `feature.ppa`.
#[derive(Params, Clone, Debug)]
pub struct TargetConnection {
    /// The working cells, as in `feature.profile_recognition`.
    #[param(flatten)]
    pub cells: WorkingCells,
    /// Which of two crossing diagonals matters more.
    #[param(default = Importance::MeanEndpoint)]
    pub importance: Importance,
}

/// Inputs of [`TargetConnection`].
#[derive(Inputs)]
pub struct TargetConnectionIn<'a> {
    /// Terrain that the candidates come from.
    pub terrain: &'a Heightfield,
    /// Cells that may lie on a line.
    pub candidates: &'a Mask,
}

/// Outputs of [`TargetConnection`].
#[derive(Outputs)]
pub struct TargetConnectionOut {
    /// Every joined working cell a point, every segment a line; full of closed polygons.
    pub segments: Features,
}

impl Node for TargetConnection {
    const ID: &'static str = "feature.target_connection";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = TargetConnectionIn<'a>;
    type Outputs = TargetConnectionOut;

    fn cost(&self) -> f64 {
        4.0
    }

    fn run(&self, inputs: TargetConnectionIn<'_>, job: &Job) -> Result<TargetConnectionOut> {
        let TargetConnectionIn { terrain, candidates } = inputs;
        let grid = terrain.grid();
        grid.match_size("terrain", candidates.grid(), "candidates")?;
        let kind = self.cells.kind.into();
        let blocks = Blocks::square(grid.cell, self.cells.working_cell as usize);
        let heights = block_means(terrain, blocks, job)?.into_cells();
        let lattice = blocks.lattice(grid);
        // A block is a candidate if its first cell is: `feature.profile_recognition` marks whole blocks.
        let marked: Vec<bool> = (0..lattice.len())
            .map(|cell| {
                let (row, col) = lattice.place(cell);
                candidates.at(row * blocks.down, col * blocks.across) >= 0.5 && !heights[cell].is_nan()
            })
            .collect();
        let crests: Vec<f32> = heights.iter().map(|height| crest(*height, kind)).collect();
        let mut network = Forest::new(lattice);
        for segment in connect(lattice, &crests, &marked, self.importance, job)? {
            segment.join(&mut network);
        }
        let frame = Frame { grid, blocks, heights: &heights, kind };
        Ok(TargetConnectionOut { segments: network.to_features(&frame, job)? })
    }
}

/// A link between two neighbouring working cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// How much it matters, first what decides, then what decides between equals.
    pub importance: [f64; 2],
    /// The cell with the lower number.
    pub from: u32,
    /// The other.
    pub to: u32,
}

impl Segment {
    /// The segment between two cells of the given heights.
    #[must_use]
    pub fn new(crests: &[f32], a: usize, b: usize, by: Importance) -> Self {
        let (za, zb) = (f64::from(crests[a]), f64::from(crests[b]));
        let (sum, low) = (za + zb, za.min(zb));
        let importance = match by {
            Importance::MeanEndpoint => [sum, low],
            Importance::MinEndpoint => [low, sum],
        };
        Self { importance, from: a.min(b) as u32, to: a.max(b) as u32 }
    }

    /// Adds the link to a network.
    pub fn join(&self, network: &mut Forest) {
        let (from, to) = (self.from as usize, self.to as usize);
        // East, south-east, south and south-west are the directions to a higher number.
        let cols = network.lattice.cols;
        let direction = match to - from {
            1 if cols != 1 => 0,
            n if n == cols => 2,
            n if n == cols + 1 => 1,
            _ => 3,
        };
        network.join(from, direction);
    }
}

/// All segments between neighbouring candidates, less the weaker of two crossing diagonals; row by row.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::Cancelled`].
pub fn connect(
    lattice: Lattice,
    crests: &[f32],
    marked: &[bool],
    by: Importance,
    job: &Job,
) -> Result<Vec<Segment>> {
    let n = marked.iter().filter(|marked| **marked).count() as u64;
    // At most four segments for each candidate, once as they are found and once as they are sorted.
    job.admit(n.saturating_mul(8 * size_of::<Segment>() as u64), || format!("segments between {n} cells"))?;
    let rows: Vec<Vec<Segment>> = (0..lattice.rows)
        .into_par_iter()
        .with_min_len(16)
        .map(|row| {
            job.check()?;
            Ok(segments_of_row(lattice, crests, marked, by, row))
        })
        .collect::<Result<_>>()?;
    Ok(rows.concat())
}

/// The segments from a row's candidates to the east and to the row below.
fn segments_of_row(
    lattice: Lattice,
    crests: &[f32],
    marked: &[bool],
    by: Importance,
    row: usize,
) -> Vec<Segment> {
    let mut out = Vec::new();
    let at = |row: usize, col: usize| row * lattice.cols + col;
    let segment = |a: usize, b: usize| (marked[a] && marked[b]).then(|| Segment::new(crests, a, b, by));
    let below = row + 1 < lattice.rows;
    for col in 0..lattice.cols {
        let cell = at(row, col);
        let east = col + 1 < lattice.cols;
        if east {
            out.extend(segment(cell, cell + 1));
        }
        if below {
            out.extend(segment(cell, at(row + 1, col)));
        }
        if east && below {
            let falling = segment(cell, at(row + 1, col + 1));
            let rising = segment(cell + 1, at(row + 1, col));
            match (falling, rising) {
                (Some(a), Some(b)) => out.push(if b.importance > a.importance { b } else { a }),
                (one, other) => out.extend(one.or(other)),
            }
        }
    }
    out
}
