//! Voids: where a terrain is not known.
use orograph_core::prelude::*;

/// Selects the voids of a terrain.
#[derive(Params, Clone, Debug)]
pub struct Voids {}

/// Inputs of [`Voids`].
#[derive(Inputs)]
pub struct VoidsIn<'a> {
    /// Terrain whose voids to select.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`Voids`].
#[derive(Outputs)]
pub struct VoidsOut {
    /// 1 at voids, 0 at known heights.
    pub mask: Mask,
}

impl Node for Voids {
    const ID: &'static str = "mask.voids";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = VoidsIn<'a>;
    type Outputs = VoidsOut;

    fn run(&self, inputs: VoidsIn<'_>, job: &Job) -> Result<VoidsOut> {
        let mask = inputs.terrain.map(job, |height| f32::from(u8::from(height.is_nan())))?;
        Ok(VoidsOut { mask })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn only_voids_are_selected() {
        let terrain = row(&[0.0, f32::NAN, -32768.0]);
        let out = Voids {}.run(VoidsIn { terrain: &terrain }, &Job::detached()).unwrap().mask;
        assert_eq!(out.cells(), [0.0, 1.0, 0.0]);
    }
}
