//! Splat map: shares of several materials as the channels of one picture.

use orograph_core::prelude::*;

/// How masks that overlap share the ground.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// Each lies over those before it, as layers of paint do.
    Stack,
    /// They keep their proportions: where they come to more than the whole, each gets its part of their sum.
    Proportion,
}

/// A channel of a picture.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha.
    Alpha,
}

/// Turns up to four masks into weights of materials: red for the first, then green, blue and alpha.
///
/// The weights of each cell come to exactly 255: what the masks leave goes to the base, and rounding takes from none
/// more than a level. Alpha is a weight like the others; `io.write_texture` keeps it, and colours are not multiplied
/// with it.
#[derive(Params, Clone, Debug)]
pub struct SplatMap {
    /// How masks that overlap share the ground.
    #[param(default = Overlap::Stack)]
    pub overlap: Overlap,
    /// The channel that gets what the masks leave. It may be one of theirs, or one that has no mask.
    #[param(default = Channel::Red)]
    pub base: Channel,
}

/// Inputs of [`SplatMap`].
#[derive(Inputs)]
pub struct SplatMapIn<'a> {
    /// One to four masks on grids of the same size, in the order of the channels.
    pub masks: Vec<&'a Mask>,
}

/// Outputs of [`SplatMap`].
#[derive(Outputs)]
pub struct SplatMapOut {
    /// The weights.
    pub splat: Texture,
}

impl Node for SplatMap {
    const ID: &'static str = "mask.splat_map";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = SplatMapIn<'a>;
    type Outputs = SplatMapOut;

    fn run(&self, inputs: SplatMapIn<'_>, job: &Job) -> Result<SplatMapOut> {
        let masks = inputs.masks;
        let Some(first) = masks.first() else {
            return Err(Error::EmptyInput { what: "masks".into() });
        };
        if masks.len() > 4 {
            return Err(Error::invalid(
                format!("{} masks for the four channels of a picture", masks.len()),
                "make a second splat map of those beyond the fourth",
            ));
        }
        for (mask, name) in masks.iter().zip(["mask 1", "mask 2", "mask 3", "mask 4"]) {
            first.grid().match_size("mask 1", mask.grid(), name)?;
        }
        let splat = Texture::build(first.grid().clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let mut shares = [0.0; 4];
                for (share, mask) in shares.iter_mut().zip(&masks) {
                    let found = f64::from(mask.at(row, col));
                    // What is no number is no share either.
                    *share = if found > 0.0 { found.min(1.0) } else { 0.0 };
                }
                *out = self.weights(shares);
            }
            Ok(())
        })?;
        Ok(SplatMapOut { splat })
    }
}

impl SplatMap {
    /// The weights of a cell, which come to 255.
    fn weights(&self, mut shares: [f64; 4]) -> [u8; 4] {
        let left = match self.overlap {
            Overlap::Stack => {
                let mut left = 1.0;
                for share in shares.iter_mut().rev() {
                    let over = *share;
                    *share *= left;
                    left *= 1.0 - over;
                }
                left
            }
            Overlap::Proportion => {
                let sum: f64 = shares.iter().sum();
                shares = shares.map(|share| share / sum.max(1.0));
                (1.0 - sum).max(0.0)
            }
        };
        shares[self.base as usize] += left;
        rounded(shares)
    }
}

/// Levels of shares that come to 1: rounded down, and those that lost most by it get one more, the first among equals.
fn rounded(shares: [f64; 4]) -> [u8; 4] {
    let exact = shares.map(|share| share * 255.0);
    let mut levels = exact.map(|level| level as u8);
    let sum: u32 = levels.iter().map(|&level| u32::from(level)).sum();
    for _ in sum..255 {
        let mut neediest = 0;
        for channel in 1..4 {
            let lost = |channel: usize| exact[channel] - f64::from(levels[channel]);
            if lost(channel) > lost(neediest) {
                neediest = channel;
            }
        }
        levels[neediest] += 1;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    fn mask(cells: &[f32]) -> Mask {
        Mask::new(row(cells).grid().clone(), cells.to_vec()).unwrap()
    }

    fn splat(node: &SplatMap, masks: &[Mask]) -> Vec<[u8; 4]> {
        let inputs = SplatMapIn { masks: masks.iter().collect() };
        node.run(inputs, &Job::detached()).unwrap().splat.cells().to_vec()
    }

    #[test]
    fn layers_lie_over_each_other_or_keep_their_proportions() {
        let masks = [mask(&[1.0, 1.0, 1.0, 0.0]), mask(&[0.0, 1.0, 0.2, 0.2]), mask(&[0.0, 1.0, 0.0, 0.2])];
        let stack = SplatMap { base: Channel::Alpha, ..SplatMap::default() };
        assert_eq!(
            splat(&stack, &masks),
            [[255, 0, 0, 0], [0, 0, 255, 0], [204, 51, 0, 0], [0, 41, 51, 163]]
        );
        let proportion = SplatMap { overlap: Overlap::Proportion, ..stack };
        assert_eq!(
            splat(&proportion, &masks),
            [[255, 0, 0, 0], [85, 85, 85, 0], [212, 43, 0, 0], [0, 51, 51, 153]]
        );
        // The base may be a channel of a mask.
        let red = splat(&SplatMap::default(), &masks[1..]);
        assert_eq!(red, [[255, 0, 0, 0], [0, 255, 0, 0], [255, 0, 0, 0], [204, 51, 0, 0]]);
    }

    #[test]
    fn weights_come_to_255_and_are_no_level_off() {
        for overlap in [Overlap::Stack, Overlap::Proportion] {
            let node = SplatMap { overlap, base: Channel::Blue };
            for seed in 0..20_000 {
                let share = |which| orograph_core::unit(orograph_core::key(seed, which, 0, 0));
                let shares = [0, 1, 2, 3].map(share);
                let levels = node.weights(shares);
                assert_eq!(levels.iter().map(|&level| u32::from(level)).sum::<u32>(), 255, "{shares:?}");
                if overlap == Overlap::Proportion {
                    let sum: f64 = shares.iter().sum();
                    for channel in [0, 1, 3] {
                        let exact = shares[channel] / sum.max(1.0) * 255.0;
                        assert!((f64::from(levels[channel]) - exact).abs() < 1.0, "{shares:?}: {levels:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_told_apart_is_refused() {
        let run = |masks: &[Mask]| {
            SplatMap::default().run(SplatMapIn { masks: masks.iter().collect() }, &Job::detached())
        };
        assert!(matches!(run(&[]), Err(Error::EmptyInput { .. })));
        let one = mask(&[1.0, 0.5]);
        assert!(matches!(run(&vec![one.clone(); 5]), Err(Error::Invalid { .. })));
        assert!(matches!(run(&[one, mask(&[1.0])]), Err(Error::DimensionMismatch { .. })));
        assert_eq!(splat(&SplatMap::default(), &[mask(&[f32::NAN])]), [[255, 0, 0, 0]]);
    }
}
