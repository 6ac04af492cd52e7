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
        let (a, b) = (inputs.a, inputs.b);
        a.grid().match_size("a", b.grid(), "b")?;
        if let Some(mask) = inputs.mask {
            a.grid().match_size("a", mask.grid(), "mask")?;
        }
        let share = self.share as f32;
        let terrain = Heightfield::build(a.grid().clone(), job, |row, out| {
            let mask = inputs.mask.map(|mask| mask.row(row));
            for (col, ((out, &a), &b)) in out.iter_mut().zip(a.row(row)).zip(b.row(row)).enumerate() {
                *out = self.mix(a, b, share * mask.map_or(1.0, |mask| mask[col].clamp(0.0, 1.0)));
            }
            Ok(())
        })?;
        Ok(BlendOut { terrain })
    }
}

impl Blend {
    fn mix(&self, a: f32, b: f32, share: f32) -> f32 {
        let mixed = if share >= 1.0 {
            b
        } else if share > 0.0 {
            a + (b - a) * share
        } else {
            a
        };
        match mixed.is_nan() && self.fill_voids {
            true if a.is_nan() => b,
            true => a,
            false => mixed,
        }
    }
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
