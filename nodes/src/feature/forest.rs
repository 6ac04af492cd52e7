//! Networks of 8-connected working cells, compactly: one byte of links a cell.

use orograph_core::{FeatureKind, prelude::*};
use orograph_core::{FeaturePoint, PointKind, Polyline};

use super::lattice::{Blocks, Lattice, opposite};

/// Working cells joined to neighbours. After polygon breaking it is a forest.
#[derive(Clone, Debug)]
pub struct Forest {
    /// The working grid.
    pub lattice: Lattice,
    /// For each working cell a bit for every direction of [`STEPS`](super::lattice::STEPS) in which it is joined.
    pub links: Vec<u8>,
}

impl Forest {
    /// Nothing joined yet.
    #[must_use]
    pub fn new(lattice: Lattice) -> Self {
        Self { lattice, links: vec![0; lattice.len()] }
    }

    /// How many neighbours a cell is joined to.
    #[must_use]
    pub fn degree(&self, cell: usize) -> u32 {
        self.links[cell].count_ones()
    }

    /// The directions in which a cell is joined, in the order of the directions.
    pub fn directions(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let links = self.links[cell];
        (0..8).filter(move |direction| links >> direction & 1 == 1)
    }

    /// The cells that a cell is joined to.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let lattice = self.lattice;
        self.directions(cell).map(move |direction| lattice.step(cell, direction))
    }

    /// Joins a cell to its neighbour in a direction.
    pub fn join(&mut self, cell: usize, direction: usize) {
        let other = self.lattice.step(cell, direction);
        self.links[cell] |= 1 << direction;
        self.links[other] |= 1 << opposite(direction);
    }

    /// Parts a cell from its neighbour in a direction.
    pub fn part(&mut self, cell: usize, direction: usize) {
        let other = self.lattice.step(cell, direction);
        self.links[cell] &= !(1 << direction);
        self.links[other] &= !(1 << opposite(direction));
    }

    /// Takes away every link of a cell.
    pub fn detach(&mut self, cell: usize) {
        for direction in self.directions(cell) {
            let other = self.lattice.step(cell, direction);
            self.links[other] &= !(1 << opposite(direction));
        }
        self.links[cell] = 0;
    }

    /// Number of cells that are joined to anything.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.links.iter().filter(|links| **links != 0).count()
    }

    /// Number of links.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.links.iter().map(|links| links.count_ones() as usize).sum::<usize>() / 2
    }

    /// The network cell by cell: a point for each joined cell, a line for each link.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory.
    pub fn to_features(&self, frame: &Frame<'_>, job: &Job) -> Result<Features> {
        job.admit((self.nodes() as u64).saturating_mul(192), || "a network cell by cell".into())?;
        let mut ids = vec![u32::MAX; self.links.len()];
        let mut points = Vec::new();
        for (cell, id) in ids.iter_mut().enumerate().filter(|(cell, _)| self.links[*cell] != 0) {
            *id = points.len() as u32;
            let [row, col] = frame.place(cell);
            let kind = match self.degree(cell) {
                1 => PointKind::End,
                2 => PointKind::Path,
                _ => PointKind::Branch,
            };
            points.push(FeaturePoint { row, col, height: frame.heights[cell], kind });
        }
        let mut lines = Vec::new();
        for cell in 0..ids.len() {
            for direction in self.directions(cell).filter(|direction| *direction < 4) {
                let other = self.lattice.step(cell, direction);
                let vertices = vec![frame.place(cell), frame.place(other)];
                lines.push(Polyline { from: ids[cell], to: ids[other], vertices, profiles: Vec::new() });
            }
        }
        Ok(frame.features(points, lines))
    }

    /// The network in features that [`to_features`](Self::to_features) made, and the height of each working cell.
    ///
    /// # Errors
    /// [`Error::Invalid`] for any other features; [`Error::TooLarge`].
    pub fn from_features(features: &Features, job: &Job) -> Result<(Self, Vec<f32>)> {
        let wrong = || {
            Error::invalid(
                "these features are no network of neighbouring working cells",
                "connect the output of `feature.target_connection`, `feature.polygon_breaking` or \
                 `feature.branch_reduction`",
            )
        };
        let blocks = blocks_of(features)?;
        let lattice = blocks.lattice(&features.grid);
        job.admit((lattice.len() as u64).saturating_mul(16), || "the working grid".into())?;
        let mut forest = Self::new(lattice);
        let mut heights = vec![f32::NAN; lattice.len()];
        let mut cells = Vec::with_capacity(features.points.len());
        for point in &features.points {
            let cell = blocks.cell_at([point.row, point.col], &features.grid).ok_or_else(wrong)?;
            heights[cell] = point.height;
            cells.push(cell);
        }
        for line in &features.lines {
            let end = |point: u32| cells.get(point as usize).copied().ok_or_else(wrong);
            let (from, to) = (end(line.from)?, end(line.to)?);
            let direction = (0..8).find(|&direction| lattice.far(from, direction, 1) == Some(to));
            forest.join(from, direction.ok_or_else(wrong)?);
        }
        Ok((forest, heights))
    }
}

/// The blocks of cells that features were found on.
///
/// # Errors
/// [`Error::Invalid`] for a scale that no block has.
pub fn blocks_of(features: &Features) -> Result<Blocks> {
    if !(1.0..=65_536.0).contains(&features.scale) {
        return Err(Error::invalid(
            format!("the features were found on working cells of {} cells", features.scale),
            "make them with a node of the `feature` family",
        ));
    }
    Ok(Blocks::square(features.grid.cell, features.scale.round() as usize))
}

/// Where a network of working cells lies and how high.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The grid of the terrain.
    pub grid: &'a Grid,
    /// Cells in a working cell.
    pub blocks: Blocks,
    /// Height of each working cell in metres.
    pub heights: &'a [f32],
    /// Ridges or valleys.
    pub kind: FeatureKind,
}

impl Frame<'_> {
    /// Fractional (row, column) of the middle of a working cell.
    #[must_use]
    pub fn place(&self, cell: usize) -> [f64; 2] {
        let (row, col) = self.blocks.lattice(self.grid).place(cell);
        self.blocks.to_cells([row as f64, col as f64], self.grid)
    }

    /// Features of these points and lines, without rings and profiles.
    #[must_use]
    pub fn features(&self, points: Vec<FeaturePoint>, lines: Vec<Polyline>) -> Features {
        Features {
            grid: self.grid.clone(),
            kind: self.kind,
            points,
            lines,
            rings: Vec::new(),
            scale: self.blocks.down.max(self.blocks.across) as f64,
            profile_len: 0,
            profile_step: 0.0,
        }
    }
}
