//! Mask overlay: a mask as a tint over a picture.

use orograph_core::prelude::*;

use super::colour::{PAPER, blend};

/// Tints a picture, or white paper, where a mask is set.
#[derive(Params, Clone, Debug)]
pub struct MaskOverlay {
    /// Colour of the tint, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xd2_281e))]
    pub colour: Colour,
    /// How much of the picture a full mask hides.
    #[param(default = 0.55, range = 0.0..=1.0, unit = "1")]
    pub opacity: f64,
}

/// Inputs of [`MaskOverlay`].
#[derive(Inputs)]
pub struct MaskOverlayIn<'a> {
    /// Where to tint.
    pub mask: &'a Mask,
    /// Picture to tint, on the mask's grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`MaskOverlay`].
#[derive(Outputs)]
pub struct MaskOverlayOut {
    /// The tinted picture.
    pub picture: Texture,
}

impl Node for MaskOverlay {
    const ID: &'static str = "look.mask_overlay";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = MaskOverlayIn<'a>;
    type Outputs = MaskOverlayOut;

    fn run(&self, inputs: MaskOverlayIn<'_>, job: &Job) -> Result<MaskOverlayOut> {
        let MaskOverlayIn { mask, onto } = inputs;
        if let Some(onto) = onto {
            mask.grid().match_size("mask", onto.grid(), "onto")?;
        }
        let tint = self.colour.0;
        let picture = Texture::build(mask.grid().clone(), job, |row, out| {
            for (col, (pixel, share)) in out.iter_mut().zip(mask.row(row)).enumerate() {
                let under = onto.map_or(PAPER, |onto| onto.at(row, col));
                // A share that is NaN tints nothing.
                let share = f64::from(*share).max(0.0) * self.opacity;
                *pixel = blend(under, tint, share);
            }
            Ok(())
        })?;
        Ok(MaskOverlayOut { picture })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tint_follows_the_mask() {
        let grid = Grid::new(1, 4, CellSize::square(1.0)).unwrap();
        let mask = Mask::new(grid, vec![0.0, 0.5, 1.0, f32::NAN]).unwrap();
        let node = MaskOverlay { colour: Colour::rgb(0), opacity: 1.0 };
        let out = node.run(MaskOverlayIn { mask: &mask, onto: None }, &Job::detached()).unwrap().picture;
        let levels: Vec<u8> = out.cells().iter().map(|pixel| pixel[0]).collect();
        assert_eq!(levels, [255, 128, 0, 255]);
    }
}
