//! Placement: which patch each cell of a synthesis came from, as a picture.

use orograph_core::key;
use orograph_core::prelude::*;

use super::colour::{PAPER, blend};

/// Stream of the colours.
const STREAM: u64 = 0x636f_6c6f;

/// Tints the patches of a synthesis over a picture, or white paper, and draws the seams between them.
#[derive(Params, Clone, Debug)]
pub struct Placement {
    /// How much of the picture the patches' colours hide.
    #[param(default = 0.35, range = 0.0..=1.0, unit = "1")]
    pub opacity: f64,
    /// Colour of the seams, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xd2_281e))]
    pub seam: Colour,
    /// Draws the seams.
    #[param(default = true)]
    pub seams: bool,
}

/// Inputs of [`Placement`].
#[derive(Inputs)]
pub struct PlacementIn<'a> {
    /// Which patch went where.
    pub placement: &'a orograph_core::Placement,
    /// Picture to draw over, on the placement's rows and columns.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`Placement`].
#[derive(Outputs)]
pub struct PlacementOut {
    /// The picture.
    pub picture: Texture,
}

impl Node for Placement {
    const ID: &'static str = "look.placement";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PlacementIn<'a>;
    type Outputs = PlacementOut;

    fn run(&self, inputs: PlacementIn<'_>, job: &Job) -> Result<PlacementOut> {
        let PlacementIn { placement, onto } = inputs;
        let grid = &placement.grid;
        if let Some(onto) = onto {
            grid.match_size("placement", onto.grid(), "onto")?;
        }
        if placement.labels.len() != grid.len() {
            return Err(Error::invalid("the placement is damaged", "make it with `synthesis.synthesise`"));
        }
        let mut picture = Texture::build(grid.clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let under = onto.map_or(PAPER, |onto| onto.at(row, col));
                let label = placement.labels[row * grid.cols + col];
                *out = if label == 0 { under } else { blend(under, tint(label), self.opacity) };
            }
            Ok(())
        })?;
        if self.seams {
            let ink = self.seam.0;
            for &cell in placement.seams.iter().flatten() {
                if let Some(pixel) = picture.cells_mut().get_mut(cell as usize) {
                    *pixel = blend(*pixel, ink, 1.0);
                }
            }
        }
        Ok(PlacementOut { picture })
    }
}

/// A colour of a patch's own: any hue, never dark.
pub(crate) fn tint(label: u32) -> [u8; 4] {
    let bits = key(0, STREAM, i64::from(label), 0);
    let channel = |shift: u32| 70 + ((bits >> shift & 0xff) * 185 / 255) as u8;
    [channel(0), channel(8), channel(16), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_differ_and_seams_are_drawn_on_both_sides() {
        let grid = Grid::new(1, 4, CellSize::square(1.0)).unwrap();
        let placement = orograph_core::Placement {
            grid,
            scales: Vec::new(),
            patches: Vec::new(),
            labels: vec![0, 1, 1, 2],
            sources: vec![[0.0; 2]; 4],
            seams: vec![[2, 3]],
        };
        let run = |seams: bool| {
            let node = Placement { opacity: 1.0, seam: Colour::rgb(0), seams };
            node.run(PlacementIn { placement: &placement, onto: None }, &Job::detached()).unwrap().picture
        };
        let (plain, drawn) = (run(false), run(true));
        assert_eq!(plain.at(0, 0), PAPER);
        assert!(plain.at(0, 1) == plain.at(0, 2) && plain.at(0, 2) != plain.at(0, 3));
        assert_eq!(
            (drawn.at(0, 1), drawn.at(0, 2), drawn.at(0, 3)),
            (plain.at(0, 1), [0, 0, 0, 255], [0, 0, 0, 255])
        );
    }
}
