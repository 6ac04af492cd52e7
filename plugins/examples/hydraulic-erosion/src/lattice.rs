//! The cells that carry heights, their neighbours, and what lies beyond the edge of the known terrain.

use orograph_plugin::{prelude::*, rayon::prelude::*};

/// In place of a cell: out of the known terrain.
pub(crate) const OUT: u32 = u32::MAX;

/// Row and column steps to the eight neighbours; the last four are those that follow in row-major order.
const STEPS: [(isize, isize); 8] = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)];
/// The first of the neighbours that follow in row-major order.
pub(crate) const FORWARD: usize = 4;
/// The way out of the known terrain, beside the eight directions.
pub(crate) const BEYOND: usize = 8;

/// What a cell has around it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Eight known neighbours.
    Inner,
    /// The raster's border or a void is next to it.
    Edge,
    /// It is a void.
    Void,
}

/// Where water leaves from a cell of the edge.
#[derive(Clone, Copy)]
pub(crate) struct Beyond {
    cell: u32,
    /// Height of the ground beyond, in metres.
    pub(crate) height: f32,
    /// Metres to there.
    pub(crate) distance: f32,
}

/// The known cells of a raster.
pub(crate) struct Lattice {
    /// Number of columns.
    pub(crate) cols: usize,
    rows: usize,
    /// Index steps to the neighbours.
    offsets: [isize; 8],
    /// Metres to the neighbours.
    pub(crate) distances: [f32; 8],
    /// Metres from one column and from one row to the next.
    pub(crate) cell: CellSize,
    /// Square metres of a cell.
    pub(crate) area: f64,
    places: Vec<Place>,
    beyond: Vec<Beyond>,
}

impl Lattice {
    /// The known cells of `terrain`.
    ///
    /// # Errors
    /// [`Error::NonFinite`] for an infinite height, [`Error::TooLarge`], [`Error::Cancelled`].
    pub(crate) fn new(terrain: &Heightfield, job: &Job) -> Result<Self> {
        let grid = terrain.grid();
        let (rows, cols) = grid.size();
        if let Some(cell) = terrain.cells().iter().position(|height| height.is_infinite()) {
            return Err(Error::NonFinite { what: "terrain".into(), row: cell / cols, col: cell % cols });
        }
        if grid.len() >= OUT as usize {
            let what = format!("erosion of {rows} × {cols} cells");
            return Err(Error::TooLarge { what, bytes: grid.len() as u64 * 64, limit: u64::from(OUT) * 64 });
        }
        let mut lattice = Self {
            cols,
            rows,
            offsets: STEPS.map(|(row, col)| row * cols as isize + col),
            distances: STEPS.map(|(row, col)| {
                let (x, y) = (col as f64 * grid.cell.x, row as f64 * grid.cell.y);
                (x * x + y * y).sqrt() as f32
            }),
            cell: grid.cell,
            area: grid.cell.x * grid.cell.y,
            places: vec![Place::Void; grid.len()],
            beyond: Vec::new(),
        };
        let heights = terrain.cells();
        let known = |row: isize, col: isize| {
            let inside = (0..rows as isize).contains(&row) && (0..cols as isize).contains(&col);
            inside && !heights[row as usize * cols + col as usize].is_nan()
        };
        let mut places = std::mem::take(&mut lattice.places);
        places.par_chunks_mut(cols.max(1)).enumerate().try_for_each(|(row, places)| {
            job.check()?;
            for (col, place) in places.iter_mut().enumerate() {
                let (row, col) = (row as isize, col as isize);
                *place = if !known(row, col) {
                    Place::Void
                } else if STEPS.iter().all(|step| known(row + step.0, col + step.1)) {
                    Place::Inner
                } else {
                    Place::Edge
                };
            }
            Ok::<_, Error>(())
        })?;
        lattice.places = places;
        lattice.beyond = (0..heights.len())
            .filter(|&cell| lattice.places[cell] == Place::Edge)
            .map(|cell| lattice.extrapolate(heights, cell))
            .collect();
        Ok(lattice)
    }

    /// The ground beyond an edge cell: it goes on falling as it fell up to there, and where it rose it lies level,
    /// so that no edge dams up what wants to leave.
    fn extrapolate(&self, heights: &[f32], cell: usize) -> Beyond {
        let here = heights[cell];
        let mut found = Beyond { cell: cell as u32, height: here, distance: self.distances[1] };
        let mut steepest = 0.0;
        for direction in [1, 3, 4, 6] {
            let across = self.neighbour(cell, 7 - direction);
            if let (None, Some(across)) = (self.neighbour(cell, direction), across) {
                let (fall, distance) = (heights[across] - here, self.distances[direction]);
                if fall / distance > steepest {
                    steepest = fall / distance;
                    found = Beyond { height: here - fall, distance, ..found };
                }
            }
        }
        found
    }

    /// The known neighbour in that direction.
    fn neighbour(&self, cell: usize, direction: usize) -> Option<usize> {
        let (row, col) = (cell / self.cols, cell % self.cols);
        let row = row.checked_add_signed(STEPS[direction].0).filter(|&row| row < self.rows)?;
        let col = col.checked_add_signed(STEPS[direction].1).filter(|&col| col < self.cols)?;
        let neighbour = row * self.cols + col;
        (self.places[neighbour] != Place::Void).then_some(neighbour)
    }

    /// Calls `visit(direction, neighbour)` for each known neighbour, in a fixed order.
    #[inline(always)]
    pub(crate) fn each(&self, cell: usize, mut visit: impl FnMut(usize, usize)) {
        if self.places[cell] == Place::Inner {
            for (direction, &offset) in self.offsets.iter().enumerate() {
                visit(direction, cell.wrapping_add_signed(offset));
            }
        } else {
            for direction in 0..8 {
                if let Some(neighbour) = self.neighbour(cell, direction) {
                    visit(direction, neighbour);
                }
            }
        }
    }

    /// Where water leaves from `cell`, if that is at the edge.
    #[inline(always)]
    pub(crate) fn beyond(&self, cell: usize) -> Option<Beyond> {
        if self.places[cell] != Place::Edge {
            return None;
        }
        let at = self.beyond.binary_search_by_key(&(cell as u32), |beyond| beyond.cell).ok()?;
        Some(self.beyond[at])
    }

    /// Whether `cell` carries a height.
    #[inline(always)]
    pub(crate) fn known(&self, cell: usize) -> bool {
        self.places[cell] != Place::Void
    }

    /// Number of cells, voids counted.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }
}
