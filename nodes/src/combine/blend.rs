//! Blend: a weighted mean of two heightfields.
use orograph_core::prelude::*;

/// Mixes two terrains by a share that may differ from cell to cell.
///
/// A terrain counts only where its share is above 0: elsewhere its voids do no harm, and the other terrain's
/// heights pass unchanged.
#[derive(Params, Clone, Debug)]
pub struct Blend {
    /// Share of the second terrain, where the mask is 1: at 0 the first alone, at 1 the second alone.
    #[param(default = 0.5, range = 0.0..=1.0, unit = "1")]
    pub share: f64,
    /// Where one terrain is a void, take the other's height instead of a void.
    #[param(default = false)]
    pub fill_voids: bool,
}

/// Inputs of [`Blend`].
#[derive(Inputs)]
pub struct BlendIn<'a> {
    /// First terrain; the result lies where it lies.
    pub a: &'a Heightfield,
    /// Second terrain, on a grid of the same size.
    pub b: &'a Heightfield,
    /// Where the second terrain counts; everywhere when unconnected.
    pub mask: Option<&'a Mask>,
}

/// Outputs of [`Blend`].
#[derive(Outputs)]
pub struct BlendOut {
    /// The mixture.
    pub terrain: Heightfield,
}

impl Node for Blend {
    const ID: &'static str = "combine.blend";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = BlendIn<'a>;
    type Outputs = BlendOut;

    fn run(&self, inputs: BlendIn<'_>, job: &Job) -> Result<BlendOut> {
        let (a, b, share) = (inputs.a, inputs.b, self.share as f32);
        // Which void to fill is settled before the loop, not in it.
        let fill = |mixed: f32, a: f32, b: f32| match (mixed.is_nan(), a.is_nan()) {
            (false, _) => mixed,
            (true, true) => b,
            (true, false) => a,
        };
        let terrain = match (inputs.mask, self.fill_voids) {
            (None, false) => a.map_with(b, job, |a, b| mix(a, b, share)),
            (None, true) => a.map_with(b, job, |a, b| fill(mix(a, b, share), a, b)),
            (Some(mask), false) => {
                a.map_with_mask(b, mask, job, |a, b, mask| mix(a, b, share * mask.clamp(0.0, 1.0)))
            }
            (Some(mask), true) => a.map_with_mask(b, mask, job, |a, b, mask| {
                fill(mix(a, b, share * mask.clamp(0.0, 1.0)), a, b)
            }),
        }?;
        Ok(BlendOut { terrain })
    }
}

/// The second height by its share; one without a share does not count at all, void or not.
fn mix(a: f32, b: f32, share: f32) -> f32 {
    let mixed = a + (b - a) * share;
    let mixed = if share >= 1.0 { b } else { mixed };
    if share > 0.0 { mixed } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    fn run(node: &Blend, a: &[f32], b: &[f32], mask: Option<&[f32]>) -> Vec<f32> {
        let (a, b) = (row(a), row(b));
        let mask = mask.map(|cells| Mask::new(a.grid().clone(), cells.to_vec()).unwrap());
        let inputs = BlendIn { a: &a, b: &b, mask: mask.as_ref() };
        node.run(inputs, &Job::detached()).unwrap().terrain.into_cells()
    }

    #[test]
    fn heights_mix_by_share_and_mask() {
        let node = Blend { share: 0.5, fill_voids: false };
        assert_eq!(run(&node, &[0.0, 10.0], &[4.0, 20.0], None), [2.0, 15.0]);
        assert_eq!(run(&node, &[0.0, 10.0], &[4.0, 20.0], Some(&[0.0, 0.5])), [0.0, 12.5]);
        let all = Blend { share: 1.0, fill_voids: false };
        assert_eq!(run(&all, &[0.1, 10.0], &[0.3, 20.0], None), [0.3, 20.0]);
    }

    #[test]
    fn a_void_counts_only_where_it_has_a_share() {
        let void = f32::NAN;
        let node = Blend { share: 1.0, fill_voids: false };
        let out = run(&node, &[void, 1.0, void, 1.0], &[2.0, void, 2.0, void], Some(&[1.0, 0.0, 0.5, 0.5]));
        assert_eq!(out[..2], [2.0, 1.0]);
        assert!(out[2].is_nan() && out[3].is_nan());
        let node = Blend { share: 0.5, fill_voids: true };
        let out = run(&node, &[void, 1.0, void], &[2.0, void, void], None);
        assert_eq!(out[..2], [2.0, 1.0]);
        assert!(out[2].is_nan());
    }
}
