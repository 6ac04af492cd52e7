//! Terrain as a net of places in the world, few enough for a frame.

use glam::Vec3;
use orograph_core::Heightfield;

use super::camera::Bounds;

/// Most rows and columns that are drawn; more would cost more than a frame has.
const MOST: usize = 257;

/// Relief that is higher than the ground is wide is squeezed to this share of that.
const HIGHEST: f64 = 1.0;

/// How far below the lowest ground the walls reach.
pub(super) const FOOT: f32 = 0.06;

/// A net over terrain: x to the east, y to the south, the larger side 2 long, the middle at 0.
pub(super) struct Relief {
    pub(super) xs: Vec<f32>,
    pub(super) ys: Vec<f32>,
    /// Where the columns and rows stand in a picture of the terrain, in shares of it.
    pub(super) us: Vec<f32>,
    pub(super) vs: Vec<f32>,
    /// Heights row by row, unexaggerated; NaN is a void.
    zs: Vec<f32>,
    /// Half of the relief.
    half: f32,
    /// How often lower than life it is drawn.
    pub(super) squeezed: f64,
    /// From (row, column) of the terrain to x and y.
    step: [f64; 2],
    extent: [f64; 2],
}

impl Relief {
    /// The net, or in words why there is none.
    pub(super) fn new(terrain: &Heightfield) -> Result<Self, &'static str> {
        let (rows, cols) = (terrain.rows(), terrain.cols());
        if rows < 2 || cols < 2 {
            return Err("Ground needs two rows and two columns at least: look at it in 2D");
        }
        let cell = terrain.grid().cell;
        let (width, depth) = (cell.x * (cols - 1) as f64, cell.y * (rows - 1) as f64);
        let scale = 2.0 / width.max(depth);
        let step = [cell.y * scale, cell.x * scale];
        let extent = [depth * scale / 2.0, width * scale / 2.0];
        let chosen = |of: usize| -> Vec<usize> {
            let n = of.min(MOST);
            (0..n).map(|i| i * (of - 1) / (n - 1)).collect()
        };
        let (at_rows, at_cols) = (chosen(rows), chosen(cols));
        let place = |at: &[usize], axis: usize| -> Vec<f32> {
            at.iter().map(|i| (*i as f64 * step[axis] - extent[axis]) as f32).collect()
        };
        let share = |at: &[usize], of: usize| -> Vec<f32> {
            at.iter().map(|i| (*i as f32 + 0.5) / of as f32).collect()
        };
        let heights: Vec<f32> = at_rows
            .iter()
            .flat_map(|row| {
                let heights = terrain.row(*row);
                at_cols.iter().map(|col| heights[*col])
            })
            .collect();
        // Of what is drawn, which is soon looked through however large the terrain is.
        let finite = || heights.iter().copied().filter(|height| height.is_finite());
        let low = f64::from(finite().fold(f32::INFINITY, f32::min));
        let high = f64::from(finite().fold(f32::NEG_INFINITY, f32::max));
        if low > high {
            return Err("There is no ground to see: every cell is a void");
        }
        let squeezed = ((high - low) * scale / (2.0 * HIGHEST)).max(1.0);
        let (middle, scale_z) = (f64::midpoint(low, high), scale / squeezed);
        let zs: Vec<f32> = heights
            .iter()
            .map(|height| match height.is_finite() {
                true => ((f64::from(*height) - middle) * scale_z) as f32,
                false => f32::NAN,
            })
            .collect();
        let known = |row: usize, col: usize| !zs[row * at_cols.len() + col].is_nan();
        let square = |(row, col)| {
            known(row, col) && known(row, col + 1) && known(row + 1, col) && known(row + 1, col + 1)
        };
        let mut squares =
            (1..at_rows.len()).flat_map(|row| (1..at_cols.len()).map(move |col| (row - 1, col - 1)));
        if !squares.any(square) {
            return Err("Heights are known in single places or along lines alone: look at them in 2D");
        }
        Ok(Self {
            xs: place(&at_cols, 1),
            ys: place(&at_rows, 0),
            us: share(&at_cols, cols),
            vs: share(&at_rows, rows),
            zs,
            half: ((high - low) * scale_z / 2.0) as f32,
            squeezed,
            step,
            extent,
        })
    }

    pub(super) fn rows(&self) -> usize {
        self.ys.len()
    }

    pub(super) fn cols(&self) -> usize {
        self.xs.len()
    }

    pub(super) fn z(&self, row: usize, col: usize) -> f32 {
        self.zs[row * self.cols() + col]
    }

    pub(super) fn point(&self, row: usize, col: usize, exaggeration: f32) -> Vec3 {
        Vec3::new(self.xs[col], self.ys[row], self.z(row, col) * exaggeration)
    }

    /// The highest height.
    pub(super) fn top(&self, exaggeration: f32) -> f32 {
        self.half * exaggeration
    }

    /// How far it reaches, and the walls below it.
    pub(super) fn bounds(&self, exaggeration: f32) -> Bounds {
        let [y, x] = self.extent;
        let high = self.top(exaggeration);
        Bounds { level: libm::hypot(x, y) as f32, low: -high - FOOT, high }
    }

    /// x and y of a fractional (row, column) of the terrain.
    pub(super) fn locate(&self, place: [f64; 2]) -> [f32; 2] {
        let at = |axis: usize| (place[axis] * self.step[axis] - self.extent[axis]) as f32;
        [at(1), at(0)]
    }

    /// Normals of the ground as it is exaggerated, row by row.
    pub(super) fn normals(&self, exaggeration: f32) -> Vec<Vec3> {
        let (rows, cols) = (self.rows(), self.cols());
        let mut normals = Vec::with_capacity(rows * cols);
        for row in 0..rows {
            for col in 0..cols {
                let at = |r: usize, c: usize| self.point(r, c, exaggeration);
                // Beside a void the slope is that of the other side.
                let ends = |a: Vec3, b: Vec3| {
                    let own = at(row, col);
                    (if a.is_finite() { a } else { own }, if b.is_finite() { b } else { own })
                };
                let (west, east) = ends(at(row, col.saturating_sub(1)), at(row, (col + 1).min(cols - 1)));
                let (north, south) = ends(at(row.saturating_sub(1), col), at((row + 1).min(rows - 1), col));
                let normal = (east - west).cross(south - north);
                normals.push(if normal.is_finite() { normal.normalize_or(Vec3::Z) } else { Vec3::Z });
            }
        }
        normals
    }

    /// The height of the net at x and y; none outside and in voids.
    pub(super) fn height(&self, x: f32, y: f32, exaggeration: f32) -> Option<f32> {
        let (col, u) = interval(&self.xs, x)?;
        let (row, v) = interval(&self.ys, y)?;
        let z = |r: usize, c: usize| self.z(row + r, col + c);
        let (a, b, c, d) = (z(0, 0), z(0, 1), z(1, 0), z(1, 1));
        // A square is cut as it is drawn.
        let height = match u + v <= 1.0 {
            true => a + u * (b - a) + v * (c - a),
            false => d + (1.0 - u) * (c - d) + (1.0 - v) * (b - d),
        };
        height.is_finite().then_some(height * exaggeration)
    }

    /// Whether the eye sees a place a little above the ground, or ground lies before it.
    pub(super) fn is_seen(&self, place: Vec3, eye: Vec3, exaggeration: f32) -> bool {
        let towards = eye - place;
        let level = Vec3::new(towards.x, towards.y, 0.0).length();
        let top = self.top(exaggeration);
        // Half of an interval of the net at each step.
        let interval = 1.0 / (self.rows().max(self.cols()) - 1) as f32;
        let steps = (level / interval).ceil().max(1.0);
        for step in 1..steps as usize {
            let at = place + towards * (step as f32 / steps);
            if at.z > top || at.x.abs() > 1.0 || at.y.abs() > 1.0 {
                return true;
            }
            if self.height(at.x, at.y, exaggeration).is_some_and(|ground| ground > at.z) {
                return false;
            }
        }
        true
    }
}

/// The interval of ascending places that `at` lies in, and the share of it that lies before.
fn interval(places: &[f32], at: f32) -> Option<(usize, f32)> {
    let (first, last) = (*places.first()?, *places.last()?);
    if at < first || at > last || at.is_nan() {
        return None;
    }
    let before = places.partition_point(|place| *place <= at).clamp(1, places.len() - 1) - 1;
    let (from, to) = (places[before], places[before + 1]);
    Some((before, ((at - from) / (to - from)).clamp(0.0, 1.0)))
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::{CellSize, Grid};

    use super::*;

    /// Terrain of 100 m cells.
    pub(in super::super) fn terrain(
        rows: usize,
        cols: usize,
        height: impl Fn(usize, usize) -> f32,
    ) -> Heightfield {
        let grid = Grid::new(rows, cols, CellSize::square(100.0)).unwrap();
        let cells = (0..rows * cols).map(|i| height(i / cols, i % cols)).collect();
        Heightfield::new(grid, cells).unwrap()
    }

    #[test]
    fn what_cannot_be_ground_says_why() {
        assert!(Relief::new(&terrain(1, 9, |_, _| 3.0)).err().unwrap().contains("two rows"));
        assert!(Relief::new(&terrain(9, 1, |_, _| 3.0)).err().unwrap().contains("two columns"));
        assert!(Relief::new(&terrain(4, 4, |_, _| f32::NAN)).err().unwrap().contains("void"));
        assert!(Relief::new(&terrain(4, 4, |_, _| f32::INFINITY)).err().unwrap().contains("void"));
        let line = |row, col| if row == col { 3.0 } else { f32::NAN };
        assert!(Relief::new(&terrain(4, 4, line)).err().unwrap().contains("lines"));
        let square = |row, col| if row < 2 && col < 2 { 3.0 } else { f32::NAN };
        assert!(Relief::new(&terrain(4, 4, square)).is_ok());
    }

    #[test]
    fn a_plane_is_a_plane_of_the_same_slope() {
        // It rises by 10 m in 100 m to the east.
        let relief = Relief::new(&terrain(50, 1001, |_, col| col as f32 * 10.0)).unwrap();
        assert_eq!(relief.cols(), MOST);
        for (x, y) in [(-0.9, 0.0), (0.0, 0.01), (0.77, -0.03)] {
            assert!((relief.height(x, y, 1.0).unwrap() - 0.1 * x).abs() < 1e-4, "{x}");
        }
        let normal = Vec3::new(-0.1, 0.0, 1.0).normalize();
        assert!(relief.normals(1.0).iter().all(|found| (*found - normal).length() < 1e-3));
        let steep = Vec3::new(-0.5, 0.0, 1.0).normalize();
        assert!(relief.normals(5.0).iter().all(|found| (*found - steep).length() < 1e-3));
        assert_eq!(relief.height(1.1, 0.0, 1.0), None);
    }

    #[test]
    fn a_place_of_the_terrain_is_found_on_the_net() {
        let relief = Relief::new(&terrain(11, 21, |_, _| 0.0)).unwrap();
        assert_eq!(relief.locate([5.0, 10.0]), [0.0, 0.0]);
        assert_eq!(relief.locate([0.0, 0.0]), [relief.xs[0], relief.ys[0]]);
        assert_eq!(relief.locate([10.0, 20.0]), [1.0, 0.5]);
    }

    #[test]
    fn odd_heights_stay_in_view() {
        for field in [
            terrain(3, 3, |_, _| 5.0),
            terrain(3, 3, |row, _| [3e38, -3e38, 0.0][row]),
            terrain(3, 3, |row, _| [f32::INFINITY, 1.0, 2.0][row]),
            terrain(3, 3, |row, col| if row + col == 0 { f32::NAN } else { 1e9 }),
        ] {
            let relief = Relief::new(&field).unwrap();
            assert!(relief.bounds(1.0).high <= 1.0 && relief.squeezed >= 1.0);
            assert!((0..9).all(|i| !relief.z(i / 3, i % 3).is_infinite()));
            assert!(relief.normals(10.0).iter().all(|normal| normal.is_finite()));
        }
    }

    #[test]
    fn a_wall_hides_what_lies_behind_it_and_nothing_else() {
        // A wall along the middle column, as high as a fifth of the half width.
        let relief = Relief::new(&terrain(101, 101, |_, col| if col == 50 { 1000.0 } else { 0.0 })).unwrap();
        let floor = relief.height(0.5, 0.0, 1.0).unwrap();
        let place = |x: f32| Vec3::new(x, 0.0, floor + 0.004);
        let eye = Vec3::new(4.0, 0.0, 0.4);
        assert!(relief.is_seen(place(0.5), eye, 1.0), "before the wall");
        assert!(!relief.is_seen(place(-0.3), eye, 1.0), "right behind it");
        // The ray to the eye rises by a tenth: it clears a wall of 0.2 from three and more widths away.
        let high = Vec3::new(4.0, 0.0, 8.0);
        assert!(relief.is_seen(place(-0.3), high, 1.0), "from high up");
        assert!(!relief.is_seen(place(-0.05), high, 1.0), "right behind it even from high up");
    }
}
