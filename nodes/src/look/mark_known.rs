//! Mark known cells: scattered constraints as dots large enough to be seen.

use orograph_core::prelude::*;

use super::colour::{PAPER, blend};

/// Draws a dot over each known cell, on a picture or on white paper.
///
/// Single cells among many voids vanish when a picture is shrunk; dots of a few pixels do not.
#[derive(Params, Clone, Debug)]
pub struct MarkKnown {
    /// Radius of a dot; 0 colours the cell alone.
    #[param(default = 1, range = 0.0..=32.0, slider = 0.0..=6.0, unit = "px")]
    pub radius: f64,
    /// Colour of the dots, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xc8_281e))]
    pub colour: Colour,
}

/// Inputs of [`MarkKnown`].
#[derive(Inputs)]
pub struct MarkKnownIn<'a> {
    /// Constraints; voids are not known.
    pub known: &'a Heightfield,
    /// Picture to draw over, on the constraints' grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`MarkKnown`].
#[derive(Outputs)]
pub struct MarkKnownOut {
    /// The picture with the dots.
    pub picture: Texture,
}

impl Node for MarkKnown {
    const ID: &'static str = "look.mark_known";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = MarkKnownIn<'a>;
    type Outputs = MarkKnownOut;

    fn halo(&self, _cell: CellSize) -> usize {
        self.reach()
    }

    fn run(&self, inputs: MarkKnownIn<'_>, job: &Job) -> Result<MarkKnownOut> {
        let MarkKnownIn { known, onto } = inputs;
        if let Some(onto) = onto {
            known.grid().match_size("known", onto.grid(), "onto")?;
        }
        let ink = self.colour.0;
        let picture = Texture::build(known.grid().clone(), job, |row, out| {
            for (col, pixel) in out.iter_mut().enumerate() {
                let under = onto.map_or(PAPER, |onto| onto.at(row, col));
                *pixel = blend(under, ink, self.coverage(known, row, col));
            }
            Ok(())
        })?;
        Ok(MarkKnownOut { picture })
    }
}

impl MarkKnown {
    /// Cells beyond which no dot touches a pixel.
    fn reach(&self) -> usize {
        (self.radius + 0.5).ceil() as usize - 1
    }

    /// How much of a pixel the nearest known cell's dot covers.
    fn coverage(&self, known: &Heightfield, row: usize, col: usize) -> f64 {
        let (rows, cols) = known.grid().size();
        let reach = self.reach();
        let mut nearest = u64::MAX;
        for r in row.saturating_sub(reach)..=(row + reach).min(rows - 1) {
            let (first, last) = (col.saturating_sub(reach), (col + reach).min(cols - 1));
            for (c, height) in (first..=last).zip(&known.row(r)[first..=last]) {
                if !height.is_nan() {
                    let (dy, dx) = (r.abs_diff(row) as u64, c.abs_diff(col) as u64);
                    nearest = nearest.min(dy * dy + dx * dx);
                }
            }
        }
        match nearest {
            0 => 1.0,
            u64::MAX => 0.0,
            far => (self.radius + 0.5 - (far as f64).sqrt()).clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn dots_are_discs_about_known_cells() {
        let known = field(9, 9, |row, col| if (row, col) == (4, 4) { 7.0 } else { f64::NAN });
        for radius in [0.0, 1.0, 2.5] {
            let node = MarkKnown { radius, colour: Colour::rgb(0) };
            let out = node.run(MarkKnownIn { known: &known, onto: None }, &Job::detached()).unwrap().picture;
            for i in 0..81 {
                let far = libm::hypot((i / 9) as f64 - 4.0, (i % 9) as f64 - 4.0);
                let share = if far == 0.0 { 1.0 } else { (radius + 0.5 - far).clamp(0.0, 1.0) };
                assert!((f64::from(out.cells()[i][0]) - 255.0 * (1.0 - share)).abs() < 1.0);
            }
        }
    }
}
