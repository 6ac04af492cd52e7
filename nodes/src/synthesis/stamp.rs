//! Stamp: a piece of terrain set into another, turned, scaled and raised.
//!
//! Zhou 2007 §6 places a real mountain first and lets synthesis continue it: connect a stamp that stands alone as the
//! given ground of `synthesis.synthesise`.

use orograph_core::prelude::*;

use crate::transform::sample::{Interpolation, sample};

/// Sets a piece of terrain into another.
#[derive(Params, Clone, Debug)]
pub struct Stamp {
    /// Where its middle goes, as a share of the terrain's width from the left.
    #[param(default = 0.5, range = -10.0..=10.0, slider = 0.0..=1.0, unit = "1")]
    pub across: f64,
    /// Where its middle goes, as a share of the terrain's height from the top.
    #[param(default = 0.5, range = -10.0..=10.0, slider = 0.0..=1.0, unit = "1")]
    pub down: f64,
    /// How far it is turned, clockwise.
    #[param(default = 0, range = -360.0..=360.0, slider = -180.0..=180.0, unit = "deg")]
    pub turn: f64,
    /// How much larger it becomes, in cells of the terrain for one of its own.
    #[param(default = 1, range = 0.01..=100.0, slider = 0.25..=4.0, unit = "1")]
    pub scale: f64,
    /// How far it is raised.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -1000.0..=1000.0, unit = "m")]
    pub raise: f64,
    /// Leaves all other cells void, to be filled by synthesis.
    #[param(default = false)]
    pub alone: bool,
}

/// Inputs of [`Stamp`].
#[derive(Inputs)]
pub struct StampIn<'a> {
    /// Terrain to set it into; its grid counts even when the stamp stands alone.
    pub terrain: &'a Heightfield,
    /// The piece; its voids let the terrain through.
    pub stamp: &'a Heightfield,
    /// How much of the stamp shows, on its grid; all of it when unconnected. Alone, at least one half counts.
    pub alpha: Option<&'a Mask>,
}

/// Outputs of [`Stamp`].
#[derive(Outputs)]
pub struct StampOut {
    /// The terrain with the stamp.
    pub terrain: Heightfield,
    /// How much of the stamp shows in each cell.
    pub mask: Mask,
}

impl Node for Stamp {
    const ID: &'static str = "synthesis.stamp";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = StampIn<'a>;
    type Outputs = StampOut;

    fn run(&self, inputs: StampIn<'_>, job: &Job) -> Result<StampOut> {
        let StampIn { terrain, stamp, alpha } = inputs;
        if let Some(alpha) = alpha {
            stamp.grid().match_size("stamp", alpha.grid(), "alpha")?;
        }
        let laid = Laid::new(self, terrain.grid(), stamp, alpha);
        let out = Heightfield::build(terrain.grid().clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let (height, share) = laid.at(row, col);
                let below = terrain.at(row, col);
                *out = if self.alone {
                    if share >= 0.5 { height } else { f32::NAN }
                } else if share == 0.0 {
                    below
                } else if below.is_nan() || share == 1.0 {
                    height
                } else {
                    below + (height - below) * share
                };
            }
            Ok(())
        })?;
        let mask = Mask::build(terrain.grid().clone(), job, |row, out| {
            out.iter_mut().enumerate().for_each(|(col, out)| *out = laid.at(row, col).1);
            Ok(())
        })?;
        Ok(StampOut { terrain: out, mask })
    }
}

/// A stamp laid over a grid.
pub(crate) struct Laid<'a> {
    stamp: &'a Heightfield,
    alpha: Option<&'a Mask>,
    /// The cell of the grid that the stamp's middle lies on, and that middle.
    center: [f64; 2],
    middle: [f64; 2],
    /// Sine and cosine of the turn.
    turn: (f64, f64),
    scale: f64,
    raise: f32,
}

impl<'a> Laid<'a> {
    /// As the settings say.
    pub(crate) fn new(
        settings: &Stamp,
        grid: &Grid,
        stamp: &'a Heightfield,
        alpha: Option<&'a Mask>,
    ) -> Self {
        let (rows, cols) = grid.size();
        let angle = settings.turn.to_radians();
        Self {
            stamp,
            alpha,
            center: [settings.down * rows as f64 - 0.5, settings.across * cols as f64 - 0.5],
            middle: [stamp.rows() as f64 / 2.0 - 0.5, stamp.cols() as f64 / 2.0 - 0.5],
            turn: (libm::sin(angle), libm::cos(angle)),
            scale: settings.scale,
            raise: settings.raise as f32,
        }
    }

    /// The stamp's height over a cell of the grid, and how much of it shows there; NaN and 0 where there is none.
    pub(crate) fn at(&self, row: usize, col: usize) -> (f32, f32) {
        let (sin, cos) = self.turn;
        let (down, across) =
            ((row as f64 - self.center[0]) / self.scale, (col as f64 - self.center[1]) / self.scale);
        // Rows grow downwards, so clockwise is from columns to rows.
        let row = self.middle[0] + cos * down - sin * across;
        let col = self.middle[1] + sin * down + cos * across;
        let height = sample(self.stamp, row, col, Interpolation::Cubic);
        let share = match self.alpha {
            _ if height.is_nan() => 0.0,
            None => 1.0,
            Some(alpha) => super::replay::nearest(alpha, [row, col]).unwrap_or(0.0),
        };
        (height + self.raise, if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn a_stamp_lands_where_it_is_told_and_the_rest_stays() {
        let terrain = field(20, 20, |_, _| 5.0);
        let stamp = field(4, 6, |row, col| 100.0 + (row * 10 + col) as f64);
        let run = |node: &Stamp| {
            node.run(StampIn { terrain: &terrain, stamp: &stamp, alpha: None }, &Job::detached()).unwrap()
        };
        let out = run(&Stamp { raise: 50.0, ..Stamp::default() });
        // The middle of 4 × 6 cells goes to that of 20 × 20: rows 8 to 11, columns 7 to 12.
        assert_eq!(out.terrain.at(8, 7), 150.0);
        assert_eq!(out.terrain.at(11, 12), 185.0);
        assert_eq!((out.terrain.at(7, 7), out.mask.at(7, 7), out.mask.at(8, 7)), (5.0, 0.0, 1.0));
        let turned = run(&Stamp { turn: 90.0, alone: true, ..Stamp::default() }).terrain;
        // A quarter turn clockwise brings the first row to the right side.
        assert!((turned.at(7, 11) - 100.0).abs() < 1e-3 && (turned.at(12, 8) - 135.0).abs() < 1e-3);
        assert!(turned.at(0, 0).is_nan());
    }
}
