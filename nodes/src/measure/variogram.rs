//! Variogram: how much heights differ with distance.
//!
//! Matheron, G. (1963), "Principles of geostatistics", Economic Geology 58 (8): half the mean squared difference of
//! heights a lag apart, in four directions, at lags of 1, 2, 4 … cells up to an eighth of the shorter side. For a
//! surface of Hurst exponent H it grows as lag^2H: H is half the slope of the logarithms.

use orograph_core::{Unit, prelude::*};

use super::{distribution::line_slope, sums::per_row};

/// Measures how heights differ with distance in four directions, and how far that is from a reference.
///
/// Pairs with a void are left out. Without a reference the difference is NaN.
#[derive(Params, Clone, Debug)]
pub struct Variogram {}

/// Inputs of [`Variogram`].
#[derive(Inputs)]
pub struct VariogramIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Variogram`].
#[derive(Outputs)]
pub struct VariogramOut {
    /// One row of metrics: Hurst exponent over all directions and in each, and its difference.
    pub metrics: Table,
    /// Semivariance at each lag in each direction.
    pub variogram: Table,
}

impl Node for Variogram {
    const ID: &'static str = "measure.variogram";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = VariogramIn<'a>;
    type Outputs = VariogramOut;

    fn cost(&self) -> f64 {
        30.0
    }

    fn run(&self, inputs: VariogramIn<'_>, job: &Job) -> Result<VariogramOut> {
        let own = Semivariances::of(inputs.terrain, job)?;
        let reference = inputs.reference.map(|reference| Semivariances::of(reference, job)).transpose()?;
        let difference =
            reference.as_ref().map_or(f64::NAN, |reference| (own.hurst() - reference.hurst()).abs());
        let [east, south_east, south, south_west] = [0, 1, 2, 3].map(|direction| own.hurst_along(direction));
        let metrics = Table::metrics([
            ("hurst", Unit::One, own.hurst()),
            ("hurst_west_east", Unit::One, east),
            ("hurst_north_west_south_east", Unit::One, south_east),
            ("hurst_north_south", Unit::One, south),
            ("hurst_north_east_south_west", Unit::One, south_west),
            ("hurst_difference", Unit::One, difference),
        ])?;
        let mut columns = vec![Column {
            name: "lag".into(),
            unit: Unit::Cell,
            cells: Cells::Numbers(own.lags.iter().map(|lag| lag.cells as f64).collect()),
        }];
        for (direction, name) in DIRECTIONS.iter().map(|direction| direction.2).enumerate() {
            let at = |of: fn(&Lag, usize) -> f64| {
                Cells::Numbers(own.lags.iter().map(|lag| of(lag, direction)).collect())
            };
            let distance = at(|lag, direction| lag.metres[direction]);
            columns.push(Column { name: format!("lag_{name}"), unit: Unit::Metre, cells: distance });
            let gamma = at(|lag, direction| lag.gamma[direction]);
            columns.push(Column {
                name: format!("semivariance_{name}"),
                unit: Unit::SquareMetre,
                cells: gamma,
            });
        }
        Ok(VariogramOut { metrics, variogram: Table::new(columns)? })
    }
}

/// Steps of row and column, and what the table calls them.
const DIRECTIONS: [(usize, isize, &str); 4] = [
    (0, 1, "west_east"),
    (1, 1, "north_west_south_east"),
    (1, 0, "north_south"),
    (1, -1, "north_east_south_west"),
];

/// Semivariances at one lag.
#[derive(Clone, Debug, PartialEq)]
pub struct Lag {
    /// Steps of a cell.
    pub cells: usize,
    /// Distance in metres along each direction.
    pub metres: [f64; 4],
    /// Half the mean squared difference of heights, in m², along each direction; NaN without pairs.
    pub gamma: [f64; 4],
}

/// The variogram of a terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Semivariances {
    /// Lags from near to far.
    pub lags: Vec<Lag>,
}

impl Semivariances {
    /// Semivariances of all pairs of finite heights.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, job: &Job) -> Result<Self> {
        job.check()?;
        let (rows, cols) = terrain.grid().size();
        let CellSize { x, y } = terrain.grid().cell;
        let mut lags = Vec::new();
        let mut cells = 1;
        while cells <= rows.min(cols) / 8 {
            let (mut metres, mut gamma) = ([0.0; 4], [0.0; 4]);
            for (direction, &(down, right, _)) in DIRECTIONS.iter().enumerate() {
                let (across, along) = (down as f64 * y, right as f64 * x);
                metres[direction] = cells as f64 * (across * across + along * along).sqrt();
                gamma[direction] = semivariance(terrain, (down * cells, right * cells as isize), job)?;
            }
            lags.push(Lag { cells, metres, gamma });
            cells *= 2;
        }
        Ok(Self { lags })
    }

    /// The Hurst exponent over all directions; NaN for fewer than two lags or without relief.
    #[must_use]
    pub fn hurst(&self) -> f64 {
        self.fit(&[0, 1, 2, 3])
    }

    /// The Hurst exponent along one direction: west–east, north-west–south-east, north–south and
    /// north-east–south-west, in this order.
    #[must_use]
    pub fn hurst_along(&self, direction: usize) -> f64 {
        if direction < 4 { self.fit(&[direction]) } else { f64::NAN }
    }

    fn fit(&self, directions: &[usize]) -> f64 {
        let points =
            self.lags.iter().flat_map(|lag| directions.iter().map(|&at| (lag.metres[at], lag.gamma[at])));
        let logs: Vec<_> = points
            .filter(|(_, gamma)| *gamma > 0.0 && gamma.is_finite())
            .map(|(metres, gamma)| (libm::log(metres), libm::log(gamma)))
            .collect();
        if logs.len() < 2 * directions.len() { f64::NAN } else { line_slope(&logs) / 2.0 }
    }
}

fn semivariance(terrain: &Heightfield, (down, right): (usize, isize), job: &Job) -> Result<f64> {
    let (rows, cols) = terrain.grid().size();
    let shift = right.unsigned_abs().min(cols);
    let parts = per_row(rows.saturating_sub(down), job, |row| {
        let (near, far) = (terrain.row(row), terrain.row(row + down));
        let (near, far) = if right >= 0 {
            (&near[..cols - shift], &far[shift..])
        } else {
            (&near[shift..], &far[..cols - shift])
        };
        let (mut count, mut sum) = (0u64, 0.0);
        for (&a, &b) in near.iter().zip(far) {
            let step = f64::from(a) - f64::from(b);
            if step.is_finite() {
                count += 1;
                sum += step * step;
            }
        }
        Ok((count, sum))
    })?;
    let (count, sum) = parts.into_iter().fold((0, 0.0), |all, own| (all.0 + own.0, all.1 + own.1));
    Ok(if count == 0 { f64::NAN } else { sum / (2.0 * count as f64) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn a_plane_s_semivariance_is_half_the_squared_rise() {
        let grid = Grid::new(40, 48, CellSize { x: 20.0, y: 10.0 }).unwrap();
        let cells = (0..40 * 48).map(|i| (i % 48) as f32 * 2.0 + (i / 48) as f32).collect();
        let terrain = Heightfield::new(grid, cells).unwrap();
        let found = Semivariances::of(&terrain, &Job::detached()).unwrap();
        assert_eq!(found.lags.iter().map(|lag| lag.cells).collect::<Vec<_>>(), [1, 2, 4]);
        assert_eq!(found.lags[2].gamma, [32.0, 72.0, 8.0, 8.0]);
        assert_eq!(found.lags[2].metres[..1], [80.0]);
        for direction in 0..4 {
            assert!((found.hurst_along(direction) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn noise_has_no_memory_and_a_random_walk_half() {
        let noise = |row: usize, col: usize| orograph_core::gaussian(3, 5, row as i64, col as i64);
        let white = field(256, 256, |row, col| 10.0 * noise(row, col));
        assert!(Semivariances::of(&white, &Job::detached()).unwrap().hurst().abs() < 0.02);
        let walks: Vec<Vec<f64>> = (0..256)
            .map(|row| {
                let steps = (0..256).map(|col| noise(row, col));
                steps
                    .scan(0.0, |sum, step| {
                        *sum += step;
                        Some(*sum)
                    })
                    .collect()
            })
            .collect();
        let walk = field(256, 256, |row, col| walks[row][col]);
        let hurst = Semivariances::of(&walk, &Job::detached()).unwrap().hurst_along(0);
        assert!((hurst - 0.5).abs() < 0.03, "{hurst}");
    }

    #[test]
    fn voids_leave_the_other_pairs_and_equal_terrains_do_not_differ() {
        let terrain =
            field(33, 40, |row, col| if (row + col) % 5 == 0 { f64::NAN } else { 3.0 * col as f64 });
        let found = Semivariances::of(&terrain, &Job::detached()).unwrap();
        assert_eq!(found.lags[1].gamma[0], 18.0);
        let inputs = VariogramIn { terrain: &terrain, reference: Some(&terrain) };
        let metrics = Variogram::default().run(inputs, &Job::detached()).unwrap().metrics;
        assert_eq!(metrics.metric("hurst_difference"), Some(0.0));
        let small = Semivariances::of(&field(5, 5, |_, _| 1.0), &Job::detached()).unwrap();
        assert!(small.lags.is_empty() && small.hurst().is_nan());
    }
}
