//! Gradient noise after Perlin ("Improving noise", 2002), in octaves.
//!
//! On a square lattice every point holds a unit gradient, drawn from a hash of the point and the seed; the
//! noise at a position blends the four planes of its lattice cell by the quintic fade, so that the second
//! derivatives are continuous.
//!
//! Departures: gradients of any direction and nearly one length instead of a few, and for each octave a rotation, an offset and a
//! seed of its own, since lattices that share directions or zeros show as stripes along the axes. Values are
//! scaled by √2 to fill −1..=1.
//!
//! Hash and gradient are arithmetic without tables or branches, so that the compiler works on several cells
//! at once, with the widest registers that the machine has; no operation depends on their width, so neither
//! does the result. Positions are `f64`; what lies within a lattice cell is `f32`.

use orograph_core::{key, mix64, unit};
use pulp::{Arch, NullaryFnOnce};

/// Stream of random numbers for offsets and seeds of octaves.
const STREAM: u64 = 0x6E6F_6973;
/// Cells worked out together; a multiple of every vector width, and few enough for the nearest cache.
const CHUNK: usize = 256;
/// Adding and subtracting this rounds to whole numbers below 2^51, and vectorises where `floor` does not.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// √2 over the length of the longest gradient: 3/4 √2 times 2^60.
const SCALE: f32 = 4.0 / 3.0 / (1_u64 << 60) as f32;

/// Octaves of gradient noise.
#[derive(Clone, Debug)]
pub struct Noise {
    octaves: Vec<Octave>,
    arch: Arch,
}

/// A lattice: `u = east·x + north·y + shift` and, a quarter turn on, `v`.
#[derive(Clone, Debug)]
struct Octave {
    east: f64,
    north: f64,
    shift: [f64; 2],
    seed: [u32; 2],
}

/// Where cells lie: the lattice cell's first corner, and the place within it.
struct Places {
    u: [u32; CHUNK],
    v: [u32; CHUNK],
    inside_u: [f32; CHUNK],
    inside_v: [f32; CHUNK],
}

impl Noise {
    /// `octaves` lattices; the first has cells of `wavelength` metres, each further one is finer by `lacunarity`.
    #[must_use]
    pub fn new(seed: u64, wavelength: f64, lacunarity: f64, octaves: u32) -> Self {
        let mut frequency = 1.0 / wavelength;
        let octaves = (0..i64::from(octaves))
            .map(|k| {
                // Steps of the golden angle keep any few octaves from sharing a direction.
                let (sin, cos) = libm::sincos(0.5 + 2.399_963_229_728_653 * k as f64);
                let bits = key(seed, STREAM, k, 2);
                let octave = Octave {
                    east: cos * frequency,
                    north: sin * frequency,
                    shift: [unit(key(seed, STREAM, k, 0)), unit(key(seed, STREAM, k, 1))],
                    seed: [bits as u32, (bits >> 32) as u32],
                };
                frequency *= lacunarity;
                octave
            })
            .collect();
        Self { octaves, arch: Arch::new() }
    }

    /// Number of octaves.
    #[must_use]
    pub fn octaves(&self) -> usize {
        self.octaves.len()
    }

    /// Octave `k` at the world positions (`x[i]`, `y`), in metres; `out[i]` lies in −1..=1.
    ///
    /// # Panics
    /// When there is no octave `k`.
    pub fn row(&self, k: usize, x: &[f64], y: f64, out: &mut [f32]) {
        self.arch.dispatch(Row { octave: &self.octaves[k], x, y, out });
    }
}

/// A row to be worked out. Not a closure: those escape inlining, and with it the wide registers.
struct Row<'a> {
    octave: &'a Octave,
    x: &'a [f64],
    y: f64,
    out: &'a mut [f32],
}

impl NullaryFnOnce for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (x, out) in self.x.chunks(CHUNK).zip(self.out.chunks_mut(CHUNK)) {
            self.octave.chunk(x, self.y, out);
        }
    }
}

impl Octave {
    #[inline(always)]
    fn chunk(&self, x: &[f64], y: f64, out: &mut [f32]) {
        let mut at = Places { u: [0; CHUNK], v: [0; CHUNK], inside_u: [0.0; CHUNK], inside_v: [0.0; CHUNK] };
        self.locate(x, y, &mut at);
        let Places { u, v, inside_u, inside_v } = &at;
        for ((((out, &u), &v), &x), &y) in out.iter_mut().zip(u).zip(v).zip(inside_u).zip(inside_v) {
            *out = self.at(u, v, x, y);
        }
    }

    #[inline(always)]
    fn locate(&self, x: &[f64], y: f64, at: &mut Places) {
        let start_u = self.north * y + self.shift[0];
        let start_v = self.east * y + self.shift[1];
        let Places { u, v, inside_u, inside_v } = at;
        for ((((x, u), v), inside_u), inside_v) in x.iter().zip(u).zip(v).zip(inside_u).zip(inside_v) {
            (*u, *inside_u) = split(self.east * x + start_u);
            (*v, *inside_v) = split(start_v - self.north * x);
        }
    }

    /// The noise at (`x`, `y`) within the lattice cell whose first corner is (`u`, `v`).
    #[inline(always)]
    fn at(&self, u: u32, v: u32, x: f32, y: f32) -> f32 {
        let (west, east) = (self.column(u), self.column(u.wrapping_add(1)));
        let (south, north) = (row(v), row(v.wrapping_add(1)));
        let plane = |column: u32, row: u32, x: f32, y: f32| {
            let [gx, gy] = gradient(column ^ row);
            gx * x + gy * y
        };
        let (fade_x, fade_y) = (fade(x), fade(y));
        let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let low = lerp(plane(west, south, x, y), plane(east, south, x - 1.0, y), fade_x);
        let high = lerp(plane(west, north, x, y - 1.0), plane(east, north, x - 1.0, y - 1.0), fade_x);
        SCALE * lerp(low, high, fade_y)
    }

    /// A hash of a column of lattice points; one of products alone would repeat along some diagonal.
    #[inline(always)]
    fn column(&self, u: u32) -> u32 {
        let bits = (u ^ self.seed[0]).wrapping_mul(0x85EB_CA6B);
        (bits ^ (bits >> 15)).wrapping_mul(0xC2B2_AE35) ^ self.seed[1]
    }
}

/// A hash of a row of lattice points, to be joined with its column's.
#[inline(always)]
fn row(v: u32) -> u32 {
    v.wrapping_mul(0x9E37_79B1)
}

/// The gradient of a lattice point, 2^60 times too long: a direction from the bits, by parabolas for sine and
/// cosine, which make it up to 6 % longer on the diagonals.
#[inline(always)]
fn gradient(bits: u32) -> [f32; 2] {
    let bits = (bits ^ (bits >> 16)).wrapping_mul(0x7FEB_352D);
    [half_wave(bits.wrapping_add(1 << 30)), half_wave(bits)]
}

/// A parabola for each half of a wave, over a turn's 2^32nd parts.
#[inline(always)]
fn half_wave(turn: u32) -> f32 {
    let t = (turn as i32) as f32;
    t * (2_147_483_648.0 - t.abs())
}

/// The next lower whole number, in 32 bits, and how far above it `x` lies.
#[inline(always)]
fn split(x: f64) -> (u32, f32) {
    let nearest = (x + ROUNDER) - ROUNDER;
    let floor = if nearest > x { nearest - 1.0 } else { nearest };
    // The low bits of a whole number's mantissa, shifted by the rounder, are the number.
    ((floor + ROUNDER).to_bits() as u32, (x - floor) as f32)
}

#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// The seed of a generator from the run's and its own.
pub(crate) fn seed(run: u64, own: u32) -> u64 {
    mix64(run ^ mix64(u64::from(own)))
}

/// Share of each octave in a sum of 1.
pub(crate) fn gains(gain: f64, octaves: u32) -> Vec<f32> {
    let gains: Vec<f64> =
        std::iter::successors(Some(1.0), |last| Some(last * gain)).take(octaves as usize).collect();
    let sum: f64 = gains.iter().sum();
    gains.iter().map(|one| (one / sum) as f32).collect()
}

/// Refuses octaves finer than a millimetre: there, positions have no digits left.
pub(crate) fn check_octaves(wavelength: f64, lacunarity: f64, octaves: u32) -> orograph_core::Result<()> {
    let finest = (1..octaves).fold(wavelength, |finest, _| finest / lacunarity);
    if finest >= 1e-3 {
        return Ok(());
    }
    Err(orograph_core::Error::invalid(
        format!("the last of {octaves} octaves has a wavelength of {finest:e} m"),
        "take fewer octaves, a lower `lacunarity` or a longer `wavelength`",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(noise: &Noise, k: usize, x: f64, y: f64) -> f32 {
        let mut out = [0.0];
        noise.row(k, &[x], y, &mut out);
        out[0]
    }

    /// The textbook form: four corner gradients dotted with the offsets, and three lerps, in `f64`.
    fn textbook(noise: &Noise, k: usize, x: f64, y: f64) -> f64 {
        let o = &noise.octaves[k];
        let u = o.east * x + o.north * y + o.shift[0];
        let v = o.east * y - o.north * x + o.shift[1];
        let (iu, iv) = (u.floor(), v.floor());
        let dot = |du: f64, dv: f64| {
            let [column, row] = [o.column((iu + du) as i64 as u32), row((iv + dv) as i64 as u32)];
            let [gx, gy] = gradient(column ^ row).map(|g| f64::from(g) * f64::from(SCALE));
            gx * (u - iu - du) + gy * (v - iv - dv)
        };
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let (fu, fv) = (fade(u - iu), fade(v - iv));
        lerp(lerp(dot(0.0, 0.0), dot(1.0, 0.0), fu), lerp(dot(0.0, 1.0), dot(1.0, 1.0), fu), fv)
    }

    #[test]
    fn gradients_have_all_directions_alike_and_no_two_neighbours_agree() {
        let noise = Noise::new(11, 1.0, 2.0, 1);
        let octave = &noise.octaves[0];
        let at = |u: u32, v: u32| gradient(octave.column(u) ^ row(v));
        let side = 512;
        let mut sectors = [0_u32; 64];
        // Products of gradients with those of points a few steps away: their means must vanish.
        let steps = [(1, 0), (0, 1), (1, 1), (1, 511), (2, 0), (0, 2), (3, 5), (0, 256), (256, 0)];
        let mut products = [[0.0_f64; 2]; 9];
        for u in 0..side {
            for v in 0..side {
                let [x, y] = at(u, v).map(f64::from);
                let unit = (1_u64 << 60) as f64;
                let [x, y] = [x / unit, y / unit];
                let length = (x * x + y * y).sqrt();
                assert!((0.999..1.061).contains(&length), "{length}");
                let turn = libm::atan2(y, x) / std::f64::consts::TAU + 0.5;
                sectors[(turn * 64.0) as usize % 64] += 1;
                for ((du, dv), sums) in steps.iter().zip(&mut products) {
                    let [other_x, other_y] = at(u + du, v + dv).map(f64::from);
                    sums[0] += (x * other_x + y * other_y) / unit;
                    sums[1] += (x * other_y - y * other_x) / unit;
                }
            }
        }
        // 4096 expected a sector, with a standard deviation of 64; the parabolas favour some by up to a fifth.
        // Means of 2^18 products have one of 1/724.
        assert!(sectors.iter().all(|n| n.abs_diff(4096) < 1024), "{sectors:?}");
        let n = f64::from(side * side);
        assert!(products.as_flattened().iter().all(|sum| (sum / n).abs() < 5.0 / 724.0), "{products:?}");
    }

    #[test]
    fn rows_agree_with_the_textbook_form() {
        let noise = Noise::new(7, 50.0, 2.1, 6);
        for i in 0..2000 {
            let (x, y) = (f64::from(i) * 13.7 - 14_000.0, f64::from(i * i % 977) * 3.3 - 1500.0);
            for k in 0..noise.octaves() {
                let (ours, truth) = (f64::from(sample(&noise, k, x, y)), textbook(&noise, k, x, y));
                assert!((ours - truth).abs() < 1e-5, "octave {k} at {x}, {y}: {ours} {truth}");
            }
        }
    }

    #[test]
    fn a_value_depends_on_its_position_alone() {
        let noise = Noise::new(3, 40.0, 2.0, 5);
        let x: Vec<f64> = (0..1000).map(|i| f64::from(i) * 7.3 - 900.0).collect();
        for k in 0..5 {
            let mut whole = vec![0.0; x.len()];
            noise.row(k, &x, 123.4, &mut whole);
            for i in (0..x.len()).step_by(37) {
                assert_eq!(whole[i].to_bits(), sample(&noise, k, x[i], 123.4).to_bits());
            }
        }
    }

    #[test]
    fn wide_registers_give_the_bits_of_narrow_ones() {
        let noise = Noise::new(9, 40.0, 2.3, 4);
        let x: Vec<f64> = (0..CHUNK).map(|i| i as f64 * 3.7 - 300.0).collect();
        for octave in 0..4 {
            let (mut wide, mut narrow) = (vec![0.0; CHUNK], vec![0.0; CHUNK]);
            noise.row(octave, &x, 55.5, &mut wide);
            noise.octaves[octave].chunk(&x, 55.5, &mut narrow);
            assert!(wide.iter().zip(&narrow).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }

    #[test]
    fn noise_is_bounded_centred_and_zero_at_lattice_points() {
        let noise = Noise::new(1, 10.0, 2.0, 1);
        let x: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1.37).collect();
        let mut out = vec![0.0; x.len()];
        let (mut sum, mut extreme) = (0.0, 0.0_f32);
        for row in 0..500 {
            noise.row(0, &x, f64::from(row) * 1.93, &mut out);
            sum += out.iter().map(|&n| f64::from(n)).sum::<f64>() / out.len() as f64;
            extreme = out.iter().fold(extreme, |most, n| most.max(n.abs()));
        }
        assert!(extreme <= 1.0 && extreme > 0.8, "{extreme}");
        assert!((sum / 500.0).abs() < 0.01, "{sum}");

        let o = &noise.octaves[0];
        let scale = o.east * o.east + o.north * o.north;
        for (u, v) in [(0.0, 0.0), (3.0, -4.0), (-17.0, 5.0)] {
            let (u, v) = (u - o.shift[0], v - o.shift[1]);
            let (x, y) = ((o.east * u - o.north * v) / scale, (o.north * u + o.east * v) / scale);
            assert!(sample(&noise, 0, x, y).abs() < 1e-6);
        }
    }

    #[test]
    fn values_and_slopes_are_continuous_across_lattice_lines() {
        let noise = Noise::new(5, 1.0, 2.0, 1);
        let step = 1e-4;
        let x: Vec<f64> = (0..200_000).map(|i| f64::from(i) * step).collect();
        let mut out = vec![0.0; x.len()];
        noise.row(0, &x, 0.37, &mut out);
        // Unit gradients times √2, blended by a fade of slope 15/8 at most: no slope beyond a few.
        assert!(out.windows(2).all(|w| (w[1] - w[0]).abs() < 8.0 * step as f32));
        let far: Vec<f64> = out.iter().step_by(100).map(|&n| f64::from(n)).collect();
        // Second differences over 0.01 of a cell: bounded curvature, no kink.
        assert!(far.windows(3).all(|w| (w[2] - 2.0 * w[1] + w[0]).abs() < 40.0 * 1e-4));
    }

    #[test]
    fn seeds_and_octaves_differ() {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let row = |seed, k| {
            let mut out = vec![0.0; x.len()];
            Noise::new(seed, 9.0, 2.0, 2).row(k, &x, 0.0, &mut out);
            out
        };
        assert_ne!(row(1, 0), row(2, 0));
        assert_ne!(row(1, 0), row(1, 1));
        assert_ne!(seed(0, 1), seed(1, 0));
        assert_ne!(seed(0, 0), seed(0, 1));
    }

    #[test]
    fn absurd_positions_do_not_panic() {
        let noise = Noise::new(1, 1.0, 2.0, 2);
        let mut out = [0.0; 4];
        noise.row(1, &[1e300, f64::NAN, f64::INFINITY, -1e18], 1e17, &mut out);
    }
}
