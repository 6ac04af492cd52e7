//! Mask to height: shares as heights between two levels.
use orograph_core::prelude::*;

/// Makes terrain of a mask: its shares become heights between two levels.
#[derive(Params, Clone, Debug)]
pub struct ToHeight {
    /// Height where the mask is 0.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub low: f64,
    /// Height where the mask is 1.
    #[param(default = 100, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub high: f64,
}

/// Inputs of [`ToHeight`].
#[derive(Inputs)]
pub struct ToHeightIn<'a> {
    /// Mask to make terrain of.
    pub mask: &'a Mask,
}

/// Outputs of [`ToHeight`].
#[derive(Outputs)]
pub struct ToHeightOut {
    /// The terrain.
    pub terrain: Heightfield,
}

impl Node for ToHeight {
    const ID: &'static str = "mask.to_height";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ToHeightIn<'a>;
    type Outputs = ToHeightOut;

    fn run(&self, inputs: ToHeightIn<'_>, job: &Job) -> Result<ToHeightOut> {
        let range = self.high - self.low;
        let terrain = inputs.mask.map(job, |share| (self.low + range * f64::from(share)) as f32)?;
        Ok(ToHeightOut { terrain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn shares_become_heights() {
        let mask = Mask::new(row(&[0.0; 3]).grid().clone(), vec![0.0, 0.5, 1.0]).unwrap();
        let node = ToHeight { low: -10.0, high: 30.0 };
        let out = node.run(ToHeightIn { mask: &mask }, &Job::detached()).unwrap().terrain;
        assert_eq!(out.cells(), [-10.0, 10.0, 30.0]);
    }
}
