//! Fractional Brownian motion: octaves of gradient noise, summed.
//!
//! Each octave is finer by the lacunarity and lower by the gain, so that variance over a distance d grows as
//! d^(2H), with H = −log(gain) / log(lacunarity), between the finest and the largest wavelength.
//! See F. K. Musgrave in "Texturing and Modeling" (1994), and `noise` for the octaves themselves.

use orograph_core::prelude::*;

use super::{
    ground::{GroundIn, GroundOut, bands, sample_rows},
    noise::Noise,
    octaves::Octaves,
};
use crate::Ground;

/// Makes rolling hills, equally rough everywhere, by fractal noise.
#[derive(Params, Clone, Debug)]
pub struct Fbm {
    /// How far heights may lie above and below the base; most lie within a third of it.
    #[param(default = 1000, range = 0.0..=20_000.0, slider = 0.0..=4000.0, unit = "m")]
    pub amplitude: f64,
    /// The layers of noise.
    #[param(flatten)]
    pub layers: Octaves,
    /// Mean height.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = -500.0..=4000.0, unit = "m")]
    pub base: f64,
    /// The ground to cover.
    #[param(flatten)]
    pub ground: Ground,
}

impl Node for Fbm {
    const ID: &'static str = "generate.fbm";
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

impl Fbm {
    fn row(&self, noise: &Noise, gains: &[f32], x: &[f64], y: f64, out: &mut [f32]) {
        let mut octave = [0.0_f32; SPAN];
        for (x, out) in x.chunks(SPAN).zip(out.chunks_mut(SPAN)) {
            let octave = &mut octave[..out.len()];
            out.fill(0.0);
            for (k, &gain) in gains.iter().enumerate() {
                noise.row(k, x, y, octave);
                for (sum, &n) in out.iter_mut().zip(&*octave) {
                    *sum += gain * n;
                }
            }
            for sum in out {
                *sum = (self.base + self.amplitude * f64::from(*sum)) as f32;
            }
        }
    }
}

/// Cells summed at a time, few enough to stay in the nearest cache.
const SPAN: usize = 1024;

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use orograph_core::{Context, DetachedHost};

    use super::*;

    fn waves(wavelength: f64) -> Octaves {
        Octaves { wavelength, ..Octaves::default() }
    }

    fn run(node: &Fbm, like: Option<&Heightfield>) -> Heightfield {
        node.run(GroundIn { like }, &Job::detached()).unwrap().terrain
    }

    #[test]
    fn variance_grows_with_distance_by_the_hurst_exponent() {
        for hurst in [0.4, 0.6, 0.8] {
            let node = Fbm {
                layers: Octaves {
                    gain: libm::pow(0.5, hurst),
                    wavelength: 2048.0,
                    octaves: 11,
                    ..Octaves::default()
                },
                ground: Ground { width: 8192.0, height: 8192.0, cells: 1024 },
                ..Fbm::default()
            };
            let field = run(&node, None);
            let spread = |lag: usize| {
                let mut sum = 0.0;
                for row in 0..1024 {
                    let row = field.row(row);
                    sum +=
                        row.iter().zip(&row[lag..]).map(|(a, b)| f64::from((b - a) * (b - a))).sum::<f64>()
                            / (row.len() - lag) as f64;
                }
                sum
            };
            let slope = libm::log2(spread(32) / spread(4)) / 3.0;
            assert!((slope - 2.0 * hurst).abs() < 0.25, "H = {hurst}: slope {slope}");
        }
    }

    #[test]
    fn heights_are_bounded_and_centred_on_the_base() {
        let node = Fbm { layers: waves(500.0), base: 300.0, amplitude: 100.0, ..Fbm::default() };
        let field = run(&node, None);
        let (low, high) = field.range().unwrap();
        assert!(low >= 200.0 && high <= 400.0 && high - low > 60.0, "{low} {high}");
        let mean = field.cells().iter().map(|&h| f64::from(h)).sum::<f64>() / field.cells().len() as f64;
        assert!((mean - 300.0).abs() < 3.0, "{mean}");
    }

    #[test]
    fn a_crop_of_the_build_is_a_build_of_the_crop() {
        let node = Fbm { ground: Ground { cells: 300, width: 9000.7, height: 5000.3 }, ..Fbm::default() };
        let whole = run(&node, None);
        let crop = whole.crop(31, 77, 50, 200, &Job::detached()).unwrap();
        assert_eq!(run(&node, Some(&crop)).cells(), crop.cells());
    }

    #[test]
    fn other_resolutions_agree_where_their_cells_coincide() {
        let node = Fbm { layers: waves(400.0), ..Fbm::default() };
        let at = |cells| {
            let ground = Ground { width: 900.0, height: 900.0, cells };
            run(&Fbm { ground, ..node.clone() }, None)
        };
        let (fine, coarse) = (at(300), at(100));
        let (_, high) = fine.range().unwrap();
        for row in 0..100 {
            for col in 0..100 {
                // Every third cell has the same centre, up to the last bits of its position.
                assert!((fine.at(3 * row + 1, 3 * col + 1) - coarse.at(row, col)).abs() < 1e-3);
            }
        }
        // Exactly so when positions have the same bits.
        let mut doubled = coarse.grid().clone();
        doubled.cell = CellSize { x: fine.grid().cell.x * 2.0, y: fine.grid().cell.y * 2.0 };
        doubled.origin = fine.grid().origin;
        let half = run(&node, Some(&Heightfield::filled(doubled, 0.0, &Job::detached()).unwrap()));
        assert!((0..100).all(|i| half.at(i, 7).to_bits() == fine.at(2 * i, 14).to_bits()));
        assert!(high > 0.0);
    }

    #[test]
    fn both_seeds_count() {
        let node = Fbm { ground: Ground { cells: 16, ..Ground::default() }, ..Fbm::default() };
        let other = run(&Fbm { layers: Octaves { seed: 1, ..node.layers }, ..node.clone() }, None);
        let job = Job::new(&DetachedHost, Context { seed: 1, resolution: None });
        let run_seed = node.run(GroundIn { like: None }, &job).unwrap().terrain;
        let plain = run(&node, None);
        assert_ne!(plain.cells(), other.cells());
        assert_ne!(plain.cells(), run_seed.cells());
        assert_ne!(other.cells(), run_seed.cells());
    }

    #[test]
    fn octaves_below_a_millimetre_are_refused() {
        let layers = Octaves { octaves: 16, ..waves(1.0) };
        assert!(Fbm { layers, ..Fbm::default() }.check().is_err());
        assert!(Fbm::default().check().is_ok());
    }

    #[test]
    fn far_from_the_origin_is_as_good_as_near() {
        let mut grid = Grid::new(8, 8, CellSize::square(10.0)).unwrap();
        grid.origin = DVec2::new(700_000.0, 5_000_000.0);
        let like = Heightfield::filled(grid, 0.0, &Job::detached()).unwrap();
        let (low, high) = run(&Fbm::default(), Some(&like)).range().unwrap();
        assert!(low > -1000.0 && high < 1000.0 && high > low);
    }
}
