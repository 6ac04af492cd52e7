//! Ridges: two walkers leave each summit in opposite directions.

use std::f64::consts::{PI, TAU};

use orograph_core::prelude::*;
use orograph_core::{key, unit};

use crate::mcmd::{
    axis::Axis,
    raster_line::line,
    settings::{Scheme, Settings, Shape},
    skeleton::{Skeleton, diagonal},
    top_down::top_down,
};

/// Stream of the summits' places, heights and directions.
const STREAM: u64 = 0x7269_6467;

/// Samples of a heading along the whole length of an arm.
const HEADINGS: usize = 257;

/// Share of the relief below which a ridge ends.
const FOOT: f64 = 0.1;

impl Skeleton {
    /// Heights of all ridges; the first ridge to reach a cell sets it, and one that meets another ends there.
    pub(super) fn draw_ridges(&self, grid: Grid, seed: u64, job: &Job<'_>) -> Result<Heightfield> {
        let (rows, cols) = grid.size();
        let reach = self.reach * diagonal(&grid);
        let mut ridges = Heightfield::filled(grid, f32::NAN, job)?;
        let mut owners = Owners { owner: vec![0; rows * cols], rows, cols };
        for ridge in 0..self.ridges {
            let draw = |what: i64| unit(key(seed, STREAM, i64::from(ridge), what));
            let summit = (draw(0) * rows as f64 - 0.5, draw(1) * cols as f64 - 0.5);
            let height = (0.6 + 0.4 * draw(2)) * self.relief;
            for (arm, turn) in [(1, 0.0), (2, PI)] {
                let direction = draw(3) * TAU + turn;
                let wander = wander(key(seed, STREAM, i64::from(ridge), 10 + arm), job)?;
                let walk = Walk { summit, height, direction, reach, foot: FOOT * self.relief };
                let turn = |way: f64| self.wander.to_radians() * wander.at(way);
                walk.run(ridge + 1, turn, &mut ridges, &mut owners, job)?;
            }
        }
        Ok(ridges)
    }
}

/// A fractal curve of one unit of displacement, from 0 at its start.
fn wander(seed: u64, job: &Job<'_>) -> Result<orograph_core::Curve> {
    let mut curve = Heightfield::filled(Grid::new(1, HEADINGS, CellSize::square(1.0))?, f32::NAN, job)?;
    curve.cells_mut()[0] = 0.0;
    let settings = Settings {
        scheme: Scheme::TriangleEdge,
        shape: Shape { l: 0.0, l_bu: 0.0, hurst: 0.7, rt: 0.0, rs: 1.0 },
        relief: 1.0,
        datum: 0.0,
        center_gain: 1.0,
        limits: None,
        dimensions: 1.0,
        seed,
    };
    top_down(&mut curve, (&Axis::new(HEADINGS)?, &Axis::new(1)?), &settings, job)?;
    let last = (HEADINGS - 1) as f64;
    let points = curve.cells().iter().enumerate().map(|(i, &turn)| [i as f64 / last, f64::from(turn)]);
    Ok(orograph_core::Curve(points.collect()))
}

/// Which ridge a cell belongs to, counted from 1.
struct Owners {
    owner: Vec<u32>,
    rows: usize,
    cols: usize,
}

/// One arm of a ridge.
struct Walk {
    /// Row and column, with fractions.
    summit: (f64, f64),
    height: f64,
    direction: f64,
    /// Cells in which the ridge sinks by one standard deviation of its bell.
    reach: f64,
    foot: f64,
}

impl Walk {
    fn run(
        &self,
        own: u32,
        turn: impl Fn(f64) -> f64,
        ridges: &mut Heightfield,
        owners: &mut Owners,
        job: &Job<'_>,
    ) -> Result<()> {
        let (rows, cols) = (owners.rows, owners.cols);
        // Where the highest summit's bell reaches the foot; no arm is longer.
        let longest = self.reach * (-2.0 * libm::log(FOOT)).sqrt();
        let cell = |(row, col): (f64, f64)| (row.round() as i64, col.round() as i64);
        let mut here = self.summit;
        let mut way = 0.0;
        loop {
            job.check()?;
            let share = way / self.reach;
            let height = self.height * libm::exp(-share * share / 2.0);
            if height < self.foot {
                return Ok(());
            }
            let heading = self.direction + turn(way / longest);
            let next = (here.0 + libm::sin(heading), here.1 + libm::cos(heading));
            let mut met = false;
            line(cell(here), cell(next), (rows, cols), |row, col, _| {
                let at = row * cols + col;
                match owners.owner[at] {
                    0 if !met => {
                        owners.owner[at] = own;
                        ridges.cells_mut()[at] = height as f32;
                    }
                    other => met |= other != own,
                }
            });
            let (row, col) = cell(next);
            let outside = !(0..rows as i64).contains(&row) || !(0..cols as i64).contains(&col);
            if met || outside {
                return Ok(());
            }
            here = next;
            way += 1.0;
        }
    }
}
