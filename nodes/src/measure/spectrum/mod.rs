//! Roughness spectrum: how much relief there is at which wavelength.
//!
//! The largest centred square less its least-squares plane, under a Hann window; mean power in 24 geometric rings
//! from 4 cycles per window to a quarter of its cells. The exponent β of the power law P ∝ k^-β comes from a
//! straight line through the logarithms. Without the window the leakage of the long waves caps β near 3.
//! Departures: on oblong cells the window is square on the ground, not in cells; voids lie on the plane.

mod window;

use std::f64::consts::PI;

use orograph_core::{Unit, prelude::*};
use rustfft::FftDirection;

use super::{distribution::line_slope, fourier, sums::per_row};
use window::Window;

/// Measures how a terrain's roughness falls with wavelength, and how far that is from a reference.
///
/// Only the largest centred square counts. Spectra and their exponents are compared over the wavelengths that both have,
/// wherever their level lies. Without a reference the distances are NaN.
#[derive(Params, Clone, Debug)]
pub struct Spectrum {}

/// Inputs of [`Spectrum`].
#[derive(Inputs)]
pub struct SpectrumIn<'a> {
    /// Terrain to measure.
    pub terrain: &'a Heightfield,
    /// Terrain to measure the distance to, of any size.
    pub reference: Option<&'a Heightfield>,
}

/// Outputs of [`Spectrum`].
#[derive(Outputs)]
pub struct SpectrumOut {
    /// One row of metrics: exponent, anisotropy, and the distances of exponent and spectrum.
    pub metrics: Table,
    /// Mean power in each ring of wave numbers; the reference as in a window of the terrain's size.
    pub spectrum: Table,
}

impl Node for Spectrum {
    const ID: &'static str = "measure.spectrum";
    const VERSION: u32 = 2; // 2 compares exponents over the wavelengths that both have
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = SpectrumIn<'a>;
    type Outputs = SpectrumOut;

    fn cost(&self) -> f64 {
        60.0
    }

    fn run(&self, inputs: SpectrumIn<'_>, job: &Job) -> Result<SpectrumOut> {
        let own = Rings::of(inputs.terrain, job)?;
        let reference = inputs.reference.map(|reference| Rings::of(reference, job)).transpose()?;
        if own.void_share > 0.0 {
            job.warn(format!(
                "{:.1} % of the window are voids: roughness is missing there",
                100.0 * own.void_share
            ));
        }
        let against = |of: fn(&Rings, &Rings) -> f64| {
            reference.as_ref().map_or(f64::NAN, |reference| of(&own, reference))
        };
        let metrics = Table::metrics([
            ("beta", Unit::One, own.beta),
            ("anisotropy", Unit::One, own.anisotropy),
            ("beta_difference", Unit::One, against(Rings::beta_difference)),
            ("spectrum_rms", Unit::One, against(Rings::distance)),
        ])?;
        let column =
            |name: &str, unit, cells| Column { name: name.into(), unit, cells: Cells::Numbers(cells) };
        let power_of_reference = |ring: &Ring| {
            let found = reference.as_ref().and_then(|other| other.log_density(ring.log_wave_number));
            found.map_or(f64::NAN, |log| libm::exp(log) / own.area)
        };
        let spectrum = Table::new(vec![
            column(
                "wave_number",
                Unit::PerMetre,
                own.rings.iter().map(|ring| libm::exp(ring.log_wave_number)).collect(),
            ),
            column(
                "wavelength",
                Unit::Metre,
                own.rings.iter().map(|ring| libm::exp(-ring.log_wave_number)).collect(),
            ),
            column(
                "power",
                Unit::SquareMetre,
                own.rings.iter().map(|ring| libm::exp(ring.log_density) / own.area).collect(),
            ),
            column("reference_power", Unit::SquareMetre, own.rings.iter().map(power_of_reference).collect()),
        ])?;
        Ok(SpectrumOut { metrics, spectrum })
    }
}

const RINGS: usize = 24;
const SECTORS: usize = 8;
/// A ring of fewer cells says little.
const LEAST_CELLS: u32 = 8;

/// Mean power in a ring of wave numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Mean of the natural logarithms of the ring's wave numbers, in cycles per metre.
    pub log_wave_number: f64,
    /// Natural logarithm of the mean power density, in m⁴: it does not depend on the window's size.
    pub log_density: f64,
}

/// The spectrum of a terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Rings {
    /// The rings that hold enough cells, from long waves to short ones.
    pub rings: Vec<Ring>,
    /// Exponent of the power law; NaN for fewer than three rings.
    pub beta: f64,
    /// Natural logarithm of the strongest over the weakest of 8 directions; NaN without rings.
    pub anisotropy: f64,
    /// Area of the window in m².
    pub area: f64,
    /// Share of the window that is void.
    pub void_share: f64,
}

impl Rings {
    /// The spectrum of the largest centred square.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
    pub fn of(terrain: &Heightfield, job: &Job) -> Result<Self> {
        job.check()?;
        let window = Window::of(terrain);
        let (rows, cols) = (window.rows, window.cols);
        let least = rows.min(cols) as f64;
        let none = Self {
            rings: Vec::new(),
            beta: f64::NAN,
            anisotropy: f64::NAN,
            area: window.area(),
            void_share: 0.0,
        };
        // From 4 cycles to a quarter of the cells there must be something.
        if least < 24.0 {
            return Ok(none);
        }
        job.admit((rows * cols) as u64 * 16, || format!("a Fourier transform of {rows} × {cols} cells"))?;
        let (cells, void_share) = window.prepared(job)?;
        if void_share == 1.0 {
            return Ok(Self { void_share, ..none });
        }
        let power = fourier::transform(cells, (rows, cols), FftDirection::Forward, job)?;

        // Column by column: the first half of the columns stands for the other by symmetry.
        let side = window.side();
        let (shortest, breadth) = (4.0, libm::log(least / 16.0) / RINGS as f64);
        let place = |u: usize, v: usize| {
            let v = if 2 * v > rows { v as f64 - rows as f64 } else { v as f64 };
            let along =
                [u as f64 * side / (cols as f64 * window.cell.x), v * side / (rows as f64 * window.cell.y)];
            let cycles = (along[0] * along[0] + along[1] * along[1]).sqrt();
            let ring = libm::log(cycles / shortest) / breadth;
            (ring >= 0.0 && ring < RINGS as f64).then_some((ring as usize, cycles, along))
        };
        let half = (cols / 2 + 1).min(cols);
        let columns = per_row(half, job, |u| {
            let mut sums = [(0u32, 0.0, 0.0); RINGS];
            // The first column, and the middle one of an even count, are their own mirror images.
            let twice = if u == 0 || 2 * u == cols { 1 } else { 2 };
            for (v, value) in power[u * rows..(u + 1) * rows].iter().enumerate() {
                if let Some((ring, cycles, _)) = place(u, v) {
                    let sum = &mut sums[ring];
                    let weight = f64::from(twice);
                    *sum = (
                        sum.0 + twice,
                        sum.1 + weight * libm::log(cycles),
                        sum.2 + weight * value.norm_sqr(),
                    );
                }
            }
            Ok(sums)
        })?;
        let mut sums = [(0u32, 0.0, 0.0); RINGS];
        for of_column in columns {
            for (all, own) in sums.iter_mut().zip(of_column) {
                *all = (all.0 + own.0, all.1 + own.1, all.2 + own.2);
            }
        }
        let means =
            sums.map(|(count, _, power)| if count >= LEAST_CELLS { power / f64::from(count) } else { 0.0 });
        let directions = per_row(half, job, |u| {
            let mut sectors = [(0.0, 0.0); SECTORS];
            for (v, value) in power[u * rows..(u + 1) * rows].iter().enumerate() {
                if let Some((ring, _, [east, south])) = place(u, v).filter(|(ring, ..)| means[*ring] > 0.0) {
                    // The first sector lies astride the axis, where seams along the grid would show.
                    let turn = libm::atan2(south, east) / PI + 1.0 + 0.5 / SECTORS as f64;
                    let sector = &mut sectors[(turn * SECTORS as f64) as usize % SECTORS];
                    *sector = (sector.0 + 1.0, sector.1 + value.norm_sqr() / means[ring]);
                }
            }
            Ok(sectors)
        })?;
        let mut sectors = [(0.0, 0.0); SECTORS];
        for of_column in directions {
            for (all, own) in sectors.iter_mut().zip(of_column) {
                *all = (all.0 + own.0, all.1 + own.1);
            }
        }
        let scale = window.area() / ((rows * cols) as f64 * window.weight());
        let rings: Vec<Ring> = sums
            .iter()
            .zip(means)
            .filter(|(_, mean)| *mean > 0.0)
            .map(|((count, log, _), mean)| Ring {
                log_wave_number: log / f64::from(*count) - libm::log(side),
                log_density: libm::log(mean * scale),
            })
            .collect();
        let beta = exponent(rings.iter().map(|ring| (ring.log_wave_number, ring.log_density)).collect());
        Ok(Self { rings, beta, anisotropy: spread(&sectors), area: window.area(), void_share })
    }

    /// How far the exponents lie apart over the wavelengths that both have: real ground is not quite a power law, so that
    /// windows of other sizes have other exponents. NaN where either has fewer than three rings there.
    #[must_use]
    pub fn beta_difference(&self, other: &Self) -> f64 {
        let span = |rings: &[Ring]| {
            let ends = [rings.first(), rings.last()];
            ends.map(|ring| ring.map_or(f64::NAN, |ring| ring.log_wave_number))
        };
        let ([a, b], [c, d]) = (span(&self.rings), span(&other.rings));
        // The ends of equal spectra count.
        let common = a.max(c) - 1e-9..=b.min(d) + 1e-9;
        let of = |rings: &[Ring]| {
            let within = rings.iter().filter(|ring| common.contains(&ring.log_wave_number));
            exponent(within.map(|ring| (ring.log_wave_number, ring.log_density)).collect())
        };
        (of(&self.rings) - of(&other.rings)).abs()
    }

    /// Root mean square of the difference of the logarithmic spectra less its mean, over the wavelengths that
    /// both have; NaN where they share fewer than three rings.
    #[must_use]
    pub fn distance(&self, reference: &Self) -> f64 {
        let gaps: Vec<f64> = self
            .rings
            .iter()
            .filter_map(|ring| Some(ring.log_density - reference.log_density(ring.log_wave_number)?))
            .collect();
        if gaps.len() < 3 {
            return f64::NAN;
        }
        let n = gaps.len() as f64;
        let mean = gaps.iter().sum::<f64>() / n;
        (gaps.iter().map(|gap| (gap - mean) * (gap - mean)).sum::<f64>() / n).sqrt()
    }

    /// The logarithmic density between the rings, along straight lines; `None` beyond them.
    fn log_density(&self, log_wave_number: f64) -> Option<f64> {
        let after = self.rings.iter().position(|ring| ring.log_wave_number >= log_wave_number)?;
        let b = self.rings[after];
        if b.log_wave_number == log_wave_number {
            return Some(b.log_density);
        }
        let a = self.rings[after.checked_sub(1)?];
        let t = (log_wave_number - a.log_wave_number) / (b.log_wave_number - a.log_wave_number);
        Some(a.log_density + t * (b.log_density - a.log_density))
    }
}

/// The exponent of a power law through logarithms of wave number and density; NaN for fewer than three.
fn exponent(points: Vec<(f64, f64)>) -> f64 {
    if points.len() < 3 { f64::NAN } else { -line_slope(&points) }
}

/// Logarithm of the largest over the least mean of the sectors that hold anything.
fn spread(sectors: &[(f64, f64)]) -> f64 {
    let means = sectors.iter().filter(|(count, _)| *count > 0.0).map(|(count, sum)| sum / count);
    let (low, high) =
        means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| (low.min(mean), high.max(mean)));
    if low > 0.0 && low <= high { libm::log(high / low) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;
    use rustfft::num_complex::Complex;
    use std::f64::consts::TAU;

    /// Part of a periodic surface of random phases whose power falls as k^-beta.
    fn synthetic(beta: f64, seed: u64) -> Heightfield {
        let n = 512usize;
        let fold = |k: usize| k.min(n - k) as f64;
        let waves = (0..n * n).map(|i| {
            let square = fold(i / n) * fold(i / n) + fold(i % n) * fold(i % n);
            let draw = |stream| orograph_core::gaussian(seed, stream, (i / n) as i64, (i % n) as i64);
            let size = if square == 0.0 { 0.0 } else { libm::pow(square, -beta / 4.0) };
            Complex::new(draw(11) * size, draw(21) * size)
        });
        let waves = waves.collect();
        let plane = fourier::transform(waves, (n, n), FftDirection::Inverse, &Job::detached()).unwrap();
        field(384, 384, |row, col| 100.0 * plane[col * n + row].re)
    }

    #[test]
    fn synthetic_spectra_have_their_exponent() {
        for beta in [2.0, 3.0, 4.0] {
            let of = |seed| Rings::of(&synthetic(beta, seed), &Job::detached()).unwrap();
            let mean = (1..=3).map(|seed| of(seed).beta).sum::<f64>() / 3.0;
            assert!((mean - beta).abs() < 0.15, "{mean} for {beta}");
            let (a, b) = (of(1), of(2));
            assert_eq!(a.distance(&a), 0.0);
            assert!(a.distance(&b) < 0.5, "{}", a.distance(&b));
            assert!(a.anisotropy < 0.5, "{}", a.anisotropy);
        }
    }

    #[test]
    fn distance_is_that_of_the_exponents_and_level_does_not_count() {
        let (rough, smooth) = (synthetic(2.0, 4), synthetic(3.0, 4));
        let run = |terrain: &Heightfield| {
            let inputs = SpectrumIn { terrain, reference: Some(&smooth) };
            Spectrum::default().run(inputs, &Job::detached()).unwrap()
        };
        let far = run(&rough).metrics;
        assert!((far.metric("beta_difference").unwrap() - 1.0).abs() < 0.15);
        let raised = smooth.map(&Job::detached(), |height| 4.0 * height + 128.0).unwrap();
        assert!(run(&raised).metrics.metric("spectrum_rms").unwrap() < 1e-4);
    }

    #[test]
    fn exponents_are_compared_over_common_wavelengths() {
        // A spectrum that is steep for long waves and flat for short ones; a corner of it lacks the long ones.
        let (steep, flat) = (synthetic(4.0, 6), synthetic(1.0, 7));
        let whole =
            field(384, 384, |row, col| f64::from(steep.at(row, col)) + 0.02 * f64::from(flat.at(row, col)));
        let corner = whole.crop(0, 0, 96, 96, &Job::detached()).unwrap();
        let [whole, corner] = [&whole, &corner].map(|field| Rings::of(field, &Job::detached()).unwrap());
        let apart = (whole.beta - corner.beta).abs();
        assert!(whole.beta_difference(&corner) < 0.5 * apart, "{} {apart}", whole.beta_difference(&corner));
        assert_eq!(whole.beta_difference(&corner), corner.beta_difference(&whole));
        assert_eq!(whole.beta_difference(&whole), 0.0);
        let none = Rings { rings: Vec::new(), ..whole.clone() };
        assert!(whole.beta_difference(&none).is_nan());
    }

    #[test]
    fn one_wave_shows_at_its_length_and_direction() {
        let oblong = Grid::new(300, 128, CellSize { x: 20.0, y: 10.0 }).unwrap();
        let wave = |i: usize| 10.0 * libm::sin(TAU * (i % 128) as f64 * 20.0 / 256.0);
        let cells = (0..300 * 128).map(|i| wave(i) as f32 + (i % 7) as f32 * 0.01).collect();
        let terrain = Heightfield::new(oblong, cells).unwrap();
        let window = Window::of(&terrain);
        assert_eq!((window.rows, window.cols, window.row), (256, 128, 22));
        let rings = Rings::of(&terrain, &Job::detached()).unwrap();
        let peak = rings.rings.iter().max_by(|a, b| a.log_density.total_cmp(&b.log_density)).unwrap();
        assert!((libm::exp(-peak.log_wave_number) / 256.0 - 1.0).abs() < 0.12);
        assert!(rings.anisotropy > 3.0);
    }

    #[test]
    fn planes_small_and_void_terrains_have_no_spectrum() {
        for terrain in [field(10, 10, |row, _| row as f64), field(40, 40, |_, _| f64::NAN)] {
            let rings = Rings::of(&terrain, &Job::detached()).unwrap();
            assert!(rings.beta.is_nan() && rings.anisotropy.is_nan());
        }
        let plane = field(64, 64, |row, col| 3.0 * row as f64 - col as f64);
        assert!(
            Rings::of(&plane, &Job::detached()).unwrap().rings.iter().all(|ring| ring.log_density < -30.0)
        );
    }
}
