//! Ridged noise: octaves of gradient noise folded at zero, so that their zeros become crests.
//!
//! After F. K. Musgrave's ridged multifractal ("Texturing and Modeling", 1994): each octave is one minus the
//! magnitude of the noise, and may be held back where the octave before lies low. Departures: weights blend
//! from 1, so that the share of detail in valleys is a setting, and the sum is scaled to 0..=1.

use orograph_core::prelude::*;

use super::{
    ground::{GroundIn, GroundOut, bands, sample_rows},
    noise::Noise,
    octaves::Octaves,
};
use crate::Ground;

/// Makes mountains with sharp crests and wide valleys, by folded fractal noise.
#[derive(Params, Clone, Debug)]
pub struct Ridged {
    /// From the lowest possible valley to the highest possible crest.
    #[param(default = 2000, range = 0.0..=20_000.0, slider = 0.0..=6000.0, unit = "m")]
    pub relief: f64,
    /// From straight flanks (0) to flanks that steepen towards the crest (1).
    #[param(default = 0.7, range = 0.0..=1.0, unit = "1")]
    pub sharpness: f64,
    /// How far finer forms keep to the heights: 0 roughens valleys like crests, 1 leaves valleys smooth.
    #[param(default = 0.7, range = 0.0..=1.0, unit = "1")]
    pub smooth_valleys: f64,
    /// The layers of noise.
    #[param(flatten)]
    pub layers: Octaves,
    /// Height of the lowest possible valley.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub base: f64,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

impl Node for Ridged {
    const ID: &'static str = "generate.ridged";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Seed, ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn check(&self) -> Result<()> {
        self.layers.check()
    }

    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        bands(self, &self.ground, job)
    }

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        self.check()?;
        let noise = self.layers.noise(job);
        let gains = self.layers.gains();
        sample_rows(&self.ground, &inputs, job, |x, y, out| self.row(&noise, &gains, x, y, out))
    }

    fn cost(&self) -> f64 {
        10.0 * f64::from(self.layers.octaves)
    }
}

impl Ridged {
    fn row(&self, noise: &Noise, gains: &[f32], x: &[f64], y: f64, out: &mut [f32]) {
        let (sharp, smooth) = (self.sharpness as f32, self.smooth_valleys as f32);
        let mut octave = [0.0_f32; SPAN];
        let mut weights = [0.0_f32; SPAN];
        for (x, out) in x.chunks(SPAN).zip(out.chunks_mut(SPAN)) {
            let octave = &mut octave[..out.len()];
            let weights = &mut weights[..out.len()];
            out.fill(0.0);
            weights.fill(1.0);
            for (k, &gain) in gains.iter().enumerate() {
                noise.row(k, x, y, octave);
                for ((sum, weight), &n) in out.iter_mut().zip(&mut *weights).zip(&*octave) {
                    let tent = (1.0 - n.abs()).max(0.0);
                    let crest = tent * (1.0 + sharp * (tent - 1.0));
                    *sum += gain * *weight * crest;
                    *weight *= 1.0 + smooth * (crest - 1.0);
                }
            }
            for sum in out {
                *sum = (self.base + self.relief * f64::from(*sum)) as f32;
            }
        }
    }
}

/// Cells summed at a time, few enough to stay in the nearest cache.
const SPAN: usize = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(wavelength: f64) -> Octaves {
        Octaves { wavelength, ..Octaves::default() }
    }

    fn run(node: &Ridged, like: Option<&Heightfield>) -> Heightfield {
        node.run(GroundIn { like }, &Job::detached()).unwrap().terrain
    }

    #[test]
    fn one_octave_is_the_folded_noise() {
        let node = Ridged {
            layers: Octaves { octaves: 1, ..waves(900.0) },
            sharpness: 0.0,
            relief: 100.0,
            base: 5.0,
            ground: Ground { cells: 64, ..Ground::default() },
            ..Ridged::default()
        };
        let field = run(&node, None);
        let noise = Noise::new(crate::generate::noise::seed(0, 0), 900.0, 2.0, 1);
        let mut row = vec![0.0; 64];
        let x: Vec<f64> = (0..64).map(|col| field.grid().position(0, col).x).collect();
        noise.row(0, &x, field.grid().position(9, 0).y, &mut row);
        for (&height, n) in field.row(9).iter().zip(row) {
            assert!((height - (5.0 + 100.0 * (1.0 - n.abs()))).abs() < 1e-3);
        }
    }

    #[test]
    fn heights_fill_but_never_leave_the_relief() {
        for (sharpness, smooth_valleys) in [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5)] {
            let node = Ridged {
                sharpness,
                smooth_valleys,
                base: 100.0,
                relief: 1000.0,
                layers: waves(800.0),
                ..Ridged::default()
            };
            let (low, high) = run(&node, None).range().unwrap();
            assert!(low >= 100.0 && high <= 1100.0 && high - low > 400.0, "{low} {high}");
        }
    }

    #[test]
    fn smooth_valleys_are_smoother_than_crests() {
        let node = Ridged { smooth_valleys: 1.0, layers: waves(2000.0), ..Ridged::default() };
        let field = run(&node, None);
        let (low, high) = field.range().unwrap();
        let (mut rough, mut count) = ([0.0; 2], [0.0; 2]);
        for row in 0..field.rows() {
            for w in field.row(row).windows(3) {
                let crest = usize::from(w[1] > (low + high) / 2.0);
                rough[crest] += f64::from((w[0] - 2.0 * w[1] + w[2]).abs());
                count[crest] += 1.0;
            }
        }
        assert!(rough[1] / count[1] > 1.5 * rough[0] / count[0], "{rough:?} {count:?}");
    }

    #[test]
    fn a_crop_of_the_build_is_a_build_of_the_crop() {
        let node = Ridged { ground: Ground { cells: 200, ..Ground::default() }, ..Ridged::default() };
        let crop = run(&node, None).crop(11, 7, 100, 120, &Job::detached()).unwrap();
        assert_eq!(run(&node, Some(&crop)).cells(), crop.cells());
    }
}
