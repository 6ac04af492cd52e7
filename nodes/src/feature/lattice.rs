//! The working grid of the feature nodes: blocks of cells, their eight neighbours, and where they lie.

use orograph_core::prelude::*;

/// Steps (rows, columns) to the eight neighbours: E, SE, S, SW and their opposites.
pub const STEPS: [(i32, i32); 8] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// The direction that leads back.
#[must_use]
pub const fn opposite(direction: usize) -> usize {
    (direction + 4) % 8
}

/// Rows × columns of working cells, numbered row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Rows of working cells.
    pub rows: usize,
    /// Columns of working cells.
    pub cols: usize,
}

impl Lattice {
    /// Number of working cells.
    #[must_use]
    pub fn len(self) -> usize {
        self.rows * self.cols
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Row and column of a working cell.
    #[must_use]
    pub fn place(self, cell: usize) -> (usize, usize) {
        (cell / self.cols, cell % self.cols)
    }

    /// The cell `steps` steps away, if it lies on the grid.
    #[must_use]
    pub fn far(self, cell: usize, direction: usize, steps: usize) -> Option<usize> {
        let (row, col) = self.place(cell);
        let (down, across) = STEPS[direction];
        let go = |at: usize, step: i32, n: usize| {
            let to = at.checked_add_signed(step as isize * steps as isize)?;
            (to < n).then_some(to)
        };
        Some(go(row, down, self.rows)? * self.cols + go(col, across, self.cols)?)
    }

    /// The neighbour in a direction in which there is known to be one.
    #[must_use]
    pub fn step(self, cell: usize, direction: usize) -> usize {
        let (down, across) = STEPS[direction];
        cell.wrapping_add_signed(down as isize * self.cols as isize + across as isize)
    }

    /// Distance between two working cells, in working cells.
    #[must_use]
    pub fn distance(self, a: usize, b: usize) -> f64 {
        let ((ra, ca), (rb, cb)) = (self.place(a), self.place(b));
        let (down, across) = (ra.abs_diff(rb) as f64, ca.abs_diff(cb) as f64);
        (down * down + across * across).sqrt()
    }
}

/// How many rows and columns of cells make one working cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// Rows of cells in a working cell.
    pub down: usize,
    /// Columns of cells in a working cell.
    pub across: usize,
}

impl Blocks {
    /// Blocks of `side` cells along the axis with the shorter cells, and along the other of as many as come
    /// nearest to a square on the ground. Where cells are square that is `side` × `side`.
    #[must_use]
    pub fn square(cell: CellSize, side: usize) -> Self {
        let side = side.max(1);
        let fit = |short: f64, long: f64| ((side as f64 * short / long).round() as usize).max(1);
        if cell.x <= cell.y {
            Self { down: fit(cell.x, cell.y), across: side }
        } else {
            Self { down: side, across: fit(cell.y, cell.x) }
        }
    }

    /// The working grid over `grid`; blocks that the border cuts count.
    #[must_use]
    pub fn lattice(self, grid: &Grid) -> Lattice {
        Lattice { rows: grid.rows.div_ceil(self.down), cols: grid.cols.div_ceil(self.across) }
    }

    /// Fractional (row, column) on `grid` of a place on the working grid.
    #[must_use]
    pub fn to_cells(self, [row, col]: [f64; 2], grid: &Grid) -> [f64; 2] {
        let along = |at: f64, block: usize, n: usize| {
            ((at + 0.5) * block as f64 - 0.5).clamp(0.0, n.saturating_sub(1) as f64)
        };
        [along(row, self.down, grid.rows), along(col, self.across, grid.cols)]
    }

    /// The working cell under a fractional (row, column) of `grid`; `None` outside.
    #[must_use]
    pub fn cell_at(self, [row, col]: [f64; 2], grid: &Grid) -> Option<usize> {
        let lattice = self.lattice(grid);
        let along = |at: f64, block: usize, n: usize| {
            let to = ((at + 0.5) / block as f64).floor();
            (to >= 0.0 && to < n as f64).then_some(to as usize)
        };
        Some(along(row, self.down, lattice.rows)? * lattice.cols + along(col, self.across, lattice.cols)?)
    }
}

/// Means of the known heights in each block, on a grid of unit cells. A block is known if at least half of its cells
/// are, counted as if the border did not cut it.
///
/// # Errors
/// [`Error::BadSize`] below 3 × 3 cells; [`Error::AllVoid`]; [`Error::NonFinite`]; [`Error::TooLarge`];
/// [`Error::Cancelled`].
pub fn block_means(terrain: &Heightfield, blocks: Blocks, job: &Job) -> Result<Heightfield> {
    let (rows, cols) = terrain.grid().size();
    if rows < 3 || cols < 3 {
        return Err(Error::BadSize { what: "the terrain".into(), rows, cols, min: 3 });
    }
    let (low, high) = terrain.known_range("the terrain")?;
    if low.is_infinite() || high.is_infinite() {
        let at = terrain.cells().iter().position(|height| height.is_infinite()).unwrap_or(0);
        return Err(Error::NonFinite { what: "the terrain".into(), row: at / cols, col: at % cols });
    }
    let lattice = blocks.lattice(terrain.grid());
    if u32::try_from(lattice.len()).is_err() {
        let bytes = (lattice.len() as u64).saturating_mul(64);
        return Err(Error::TooLarge {
            what: "the working grid".into(),
            bytes,
            limit: u64::from(u32::MAX) * 64,
        });
    }
    let grid = Grid::new(lattice.rows, lattice.cols, CellSize::square(1.0))?;
    let half = (blocks.down * blocks.across).div_ceil(2);
    Heightfield::build(grid, job, |row, out| {
        let block_rows = row * blocks.down..rows.min((row + 1) * blocks.down);
        for (col, out) in out.iter_mut().enumerate() {
            let block_cols = col * blocks.across..cols.min((col + 1) * blocks.across);
            let (mut sum, mut known) = (0.0, 0);
            for row in block_rows.clone() {
                for &height in &terrain.row(row)[block_cols.clone()] {
                    if !height.is_nan() {
                        sum += f64::from(height);
                        known += 1;
                    }
                }
            }
            if known >= half {
                *out = (sum / known as f64) as f32;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn blocks_of_non_square_cells_come_near_to_squares() {
        let of = |x, y, side| {
            let blocks = Blocks::square(CellSize { x, y }, side);
            (blocks.down, blocks.across)
        };
        assert_eq!(of(10.0, 10.0, 5), (5, 5));
        assert_eq!(of(60.9, 92.5, 5), (3, 5));
        assert_eq!(of(92.5, 72.0, 5), (5, 4));
        assert_eq!(of(60.9, 92.5, 1), (1, 1));
        assert_eq!(of(1.0, 1e9, 32), (1, 32));
    }

    #[test]
    fn a_block_is_known_when_half_of_it_is_and_its_middle_maps_back() {
        let mut terrain = field(7, 10, |row, col| (row * 10 + col) as f64);
        for i in [0, 1, 2, 10, 11, 12, 20, 21] {
            terrain.cells_mut()[i] = f32::NAN;
        }
        let job = Job::detached();
        let blocks = Blocks { down: 4, across: 4 };
        let means = block_means(&terrain, blocks, &job).unwrap();
        assert_eq!(means.grid().size(), (2, 3));
        // 8 of 16 cells are left in the first block, and the third is half cut by the border.
        assert_eq!(means.at(0, 0), [3, 13, 22, 23, 30, 31, 32, 33].iter().sum::<i32>() as f32 / 8.0);
        assert!(!means.at(0, 2).is_nan());
        assert!(means.at(1, 2).is_nan());
        for cell in 0..6 {
            let (row, col) = blocks.lattice(terrain.grid()).place(cell);
            let at = blocks.to_cells([row as f64, col as f64], terrain.grid());
            assert_eq!(blocks.cell_at(at, terrain.grid()), Some(cell));
        }
        assert!(block_means(&field(2, 9, |_, _| 0.0), blocks, &job).is_err());
        assert!(block_means(&field(9, 9, |_, _| f64::NAN), blocks, &job).is_err());
        assert!(block_means(&field(9, 9, |row, _| 1e300 * row as f64), blocks, &job).is_err());
    }
}
