//! Ridged noise: octaves of gradient noise folded at zero, so that their zeros become crests.
//!
//! After F. K. Musgrave's ridged multifractal ("Texturing and Modeling", 1994): each octave is one minus the
//! magnitude of the noise, and may be held back where the octave before lies low. Departures: weights blend
//! from 1, so that the share of detail in valleys is a setting, and the sum is scaled to 0..=1.

use orograph_core::prelude::*;

use super::{
    ground::{Ground, GroundIn, GroundOut},
    noise::{self, Noise},
};

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
    /// Size of the largest forms.
    #[param(default = 4000, range = 0.1..=10_000_000.0, slider = 50.0..=20_000.0, unit = "m")]
    pub wavelength: f64,
    /// Layers of ever finer forms.
    #[param(default = 8u32, range = 1..=16, slider = 1..=12, unit = "1")]
    pub octaves: u32,
    /// Height of each layer relative to the one before: higher is rougher.
    #[param(default = 0.5, range = 0.0..=1.0, slider = 0.3..=0.7, unit = "1")]
    pub gain: f64,
    /// How many times finer each layer is than the one before.
    #[param(default = 2, range = 1.01..=4.0, slider = 1.7..=2.5, unit = "1")]
    pub lacunarity: f64,
    /// Which of all such terrains; the run's seed counts as well.
    #[param(default = 0u32, range = 0..=4_294_967_295u32, slider = 0..=999, unit = "seed")]
    pub seed: u32,
    /// Height of the lowest possible valley.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub base: f64,
    /// Extent of the ground from west to east, when no grid is given.
    #[param(default = 10_000, range = 1.0..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub width: f64,
    /// Extent of the ground from north to south, when no grid is given.
    #[param(default = 10_000, range = 1.0..=10_000_000.0, slider = 100.0..=100_000.0, unit = "m")]
    pub height: f64,
    /// Cells along the longer side, when neither a grid nor the run's resolution is given.
    #[param(default = 512u32, range = 1..=65_536, slider = 64..=4096, unit = "cells")]
    pub cells: u32,
}

impl Node for Ridged {
    const ID: &'static str = "generate.ridged";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Seed, ContextItem::Resolution];
    type Inputs<'a> = GroundIn<'a>;
    type Outputs = GroundOut;

    fn check(&self) -> Result<()> {
        noise::check_octaves(self.wavelength, self.lacunarity, self.octaves)
    }

    fn run(&self, inputs: GroundIn<'_>, job: &Job) -> Result<GroundOut> {
        self.check()?;
        let ground = Ground { width: self.width, height: self.height, cells: self.cells };
        let noise =
            Noise::new(noise::seed(job.seed(), self.seed), self.wavelength, self.lacunarity, self.octaves);
        let gains = noise::gains(self.gain, self.octaves);
        ground.rows(&inputs, job, |x, y, out| self.row(&noise, &gains, x, y, out))
    }

    fn cost(&self) -> f64 {
        10.0 * f64::from(self.octaves)
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

    fn run(node: &Ridged, like: Option<&Heightfield>) -> Heightfield {
        node.run(GroundIn { like }, &Job::detached()).unwrap().terrain
    }

    #[test]
    fn one_octave_is_the_folded_noise() {
        let node = Ridged {
            octaves: 1,
            sharpness: 0.0,
            relief: 100.0,
            base: 5.0,
            wavelength: 900.0,
            cells: 64,
            ..Ridged::default()
        };
        let field = run(&node, None);
        let noise = Noise::new(noise::seed(0, 0), 900.0, 2.0, 1);
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
                wavelength: 800.0,
                ..Ridged::default()
            };
            let (low, high) = run(&node, None).range().unwrap();
            assert!(low >= 100.0 && high <= 1100.0 && high - low > 400.0, "{low} {high}");
        }
    }

    #[test]
    fn smooth_valleys_are_smoother_than_crests() {
        let node = Ridged { smooth_valleys: 1.0, wavelength: 2000.0, ..Ridged::default() };
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
        let node = Ridged { cells: 200, ..Ridged::default() };
        let crop = run(&node, None).crop(11, 7, 100, 120, &Job::detached()).unwrap();
        assert_eq!(run(&node, Some(&crop)).cells(), crop.cells());
    }
}
