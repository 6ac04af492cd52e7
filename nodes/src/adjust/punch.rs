//! Punch: voids where a mask says so.
use orograph_core::prelude::*;

/// Makes voids where a mask is set; every other height stays as it is.
#[derive(Params, Clone, Debug)]
pub struct Punch {
    /// Cells whose mask is at least this become voids.
    #[param(default = 0.5, range = 0.001..=1.0, unit = "1")]
    pub threshold: f64,
}

/// Inputs of [`Punch`].
#[derive(Inputs)]
pub struct PunchIn<'a> {
    /// Terrain to make voids in.
    pub terrain: &'a Heightfield,
    /// Where to make them.
    pub mask: &'a Mask,
}

/// Outputs of [`Punch`].
#[derive(Outputs)]
pub struct PunchOut {
    /// Terrain with voids.
    pub terrain: Heightfield,
}

impl Node for Punch {
    const ID: &'static str = "adjust.punch";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = PunchIn<'a>;
    type Outputs = PunchOut;

    fn run(&self, inputs: PunchIn<'_>, job: &Job) -> Result<PunchOut> {
        let (terrain, mask) = (inputs.terrain, inputs.mask);
        terrain.grid().match_size("terrain", mask.grid(), "mask")?;
        let threshold = self.threshold as f32;
        let terrain = Heightfield::build(terrain.grid().clone(), job, |row, out| {
            for ((out, &height), &share) in out.iter_mut().zip(terrain.row(row)).zip(mask.row(row)) {
                *out = if share >= threshold { f32::NAN } else { height };
            }
            Ok(())
        })?;
        Ok(PunchOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn masked_cells_become_voids_and_others_stay() {
        let terrain = row(&[1.0, 2.0, 3.0]);
        let mask = Mask::new(terrain.grid().clone(), vec![0.0, 0.5, 1.0]).unwrap();
        let inputs = PunchIn { terrain: &terrain, mask: &mask };
        let out = Punch::default().run(inputs, &Job::detached()).unwrap().terrain;
        assert_eq!(out.at(0, 0), 1.0);
        assert!(out.at(0, 1).is_nan() && out.at(0, 2).is_nan());
    }
}
