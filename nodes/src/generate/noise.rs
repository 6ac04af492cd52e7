//! Gradient noise after Perlin ("Improving noise", 2002), in octaves.
//!
//! On a square lattice every point holds a unit gradient, drawn from a hash of the point and the seed; the
//! noise at a position blends the four planes of its lattice cell by the quintic fade, so that the second
//! derivatives are continuous.
//!
//! Departures: 256 directions instead of a few, and for each octave a rotation, an offset and a seed of its
//! own, since lattices that share directions or zeros show as stripes along the axes. Values are scaled by
//! √2 to fill −1..=1.
//!
//! A row of cells is walked in runs that stay inside one lattice cell, whose gradients are then hashed once
//! per run and not once per cell. A cell's value depends on its position alone, never on the run. Positions
//! are `f64`; what lies within a lattice cell is `f32`.

use orograph_core::{key, mix64, unit};

/// Stream of random numbers for offsets and seeds of octaves.
const STREAM: u64 = 0x6E6F_6973;
/// Cells whose places are worked out together; a multiple of every vector width.
const CHUNK: usize = 256;
/// Adding and subtracting this rounds to whole numbers below 2^51, and vectorises where `floor` does not.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Octaves of gradient noise.
#[derive(Clone, Debug)]
pub struct Noise {
    octaves: Vec<Octave>,
    /// Unit vectors in all directions, times √2.
    directions: [[f32; 2]; 256],
}

/// A lattice: `u = east·x + north·y + shift` and, a quarter turn on, `v`.
#[derive(Clone, Debug)]
struct Octave {
    east: f64,
    north: f64,
    shift: [f64; 2],
    seed: u64,
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
                let octave = Octave {
                    east: cos * frequency,
                    north: sin * frequency,
                    shift: [unit(key(seed, STREAM, k, 0)), unit(key(seed, STREAM, k, 1))],
                    seed: key(seed, STREAM, k, 2),
                };
                frequency *= lacunarity;
                octave
            })
            .collect();
        let directions = std::array::from_fn(|i| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * (i as f64 + 0.5) / 256.0);
            [(cos * std::f64::consts::SQRT_2) as f32, (sin * std::f64::consts::SQRT_2) as f32]
        });
        Self { octaves, directions }
    }

    /// Number of octaves.
    #[must_use]
    pub fn octaves(&self) -> usize {
        self.octaves.len()
    }

    /// Octave `k` at the world positions (`x[i]`, `y`), in metres, with `x` ascending; `out[i]` lies in −1..=1.
    ///
    /// # Panics
    /// When there is no octave `k`.
    pub fn row(&self, k: usize, x: &[f64], y: f64, out: &mut [f32]) {
        let octave = &self.octaves[k];
        for (x, out) in x.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            self.chunk(octave, x, y, out);
        }
    }

    fn chunk(&self, octave: &Octave, x: &[f64], y: f64, out: &mut [f32]) {
        let n = x.len().min(out.len());
        let mut places = [0_u64; CHUNK];
        let mut inside = [[0.0_f32; CHUNK]; 2];
        octave.locate(&x[..n], y, &mut places, &mut inside);
        let mut start = 0;
        while start < n {
            let place = places[start];
            let end = run_end(&places[..n], start);
            let patch = self.patch(octave.seed, place);
            let (u, v) = (&inside[0][start..end], &inside[1][start..end]);
            for ((out, &u), &v) in out[start..end].iter_mut().zip(u).zip(v) {
                *out = patch.at(u, v);
            }
            start = end;
        }
    }

    /// The surface over one lattice cell.
    #[inline]
    fn patch(&self, seed: u64, place: u64) -> Patch {
        let (u, v) = (place as u32, (place >> 32) as u32);
        let corner = |du: u32, dv: u32| {
            let [x, y] = self.gradient(seed, u.wrapping_add(du), v.wrapping_add(dv));
            // The plane through zero at the corner, from the cell's first corner.
            [x, y, -(x * du as f32 + y * dv as f32)]
        };
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
        let each = |f: fn(f32, f32, f32, f32) -> f32| [0, 1, 2].map(|i| f(a[i], b[i], c[i], d[i]));
        Patch {
            first: a,
            along_u: each(|a, b, _, _| b - a),
            along_v: each(|a, _, c, _| c - a),
            twist: each(|a, b, c, d| (d - c) - (b - a)),
        }
    }

    #[inline]
    fn gradient(&self, seed: u64, u: u32, v: u32) -> [f32; 2] {
        let state = (u64::from(v) << 32 | u64::from(u)) ^ seed;
        let state = (state ^ (state >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let state = (state ^ (state >> 32)).wrapping_mul(0x94D0_49BB_1331_11EB);
        self.directions[(state >> 56) as usize]
    }
}

impl Octave {
    /// Lattice cell (both whole coordinates, 32 bits each) and place within it, for each position.
    fn locate(&self, x: &[f64], y: f64, places: &mut [u64; CHUNK], inside: &mut [[f32; CHUNK]; 2]) {
        let start_u = self.north * y + self.shift[0];
        let start_v = self.east * y + self.shift[1];
        let [inside_u, inside_v] = inside;
        for (((x, place), u_out), v_out) in x.iter().zip(places).zip(inside_u).zip(inside_v) {
            let (u, v) = (self.east * x + start_u, start_v - self.north * x);
            let (floor_u, floor_v) = (floor(u), floor(v));
            *u_out = (u - floor_u) as f32;
            *v_out = (v - floor_v) as f32;
            // The low bits of a whole number's mantissa, shifted by the rounder, are the number.
            let (low, high) = ((floor_u + ROUNDER).to_bits(), (floor_v + ROUNDER).to_bits());
            *place = (low & 0xFFFF_FFFF) | (high << 32);
        }
    }
}

#[inline]
fn floor(x: f64) -> f64 {
    let nearest = (x + ROUNDER) - ROUNDER;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// Where the run of equal places from `start` ends. Along a row both coordinates only rise or only fall, so
/// that a place that comes again a few cells on holds in between.
#[inline]
fn run_end(places: &[u64], start: usize) -> usize {
    let place = places[start];
    let mut end = start + 1;
    while places.get(end + 7) == Some(&place) {
        end += 8;
    }
    while places.get(end) == Some(&place) {
        end += 1;
    }
    end
}

/// The blend of four planes: each row holds (per u, per v, constant).
struct Patch {
    first: [f32; 3],
    along_u: [f32; 3],
    along_v: [f32; 3],
    twist: [f32; 3],
}

impl Patch {
    #[inline]
    fn at(&self, u: f32, v: f32) -> f32 {
        let plane = |p: &[f32; 3]| p[0] * u + p[1] * v + p[2];
        let (fade_u, fade_v) = (fade(u), fade(v));
        (plane(&self.first) + fade_u * plane(&self.along_u))
            + fade_v * (plane(&self.along_v) + fade_u * plane(&self.twist))
    }
}

#[inline]
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
            let [gx, gy] = noise.gradient(o.seed, (iu + du) as i64 as u32, (iv + dv) as i64 as u32);
            f64::from(gx) * (u - iu - du) + f64::from(gy) * (v - iv - dv)
        };
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let (fu, fv) = (fade(u - iu), fade(v - iv));
        lerp(lerp(dot(0.0, 0.0), dot(1.0, 0.0), fu), lerp(dot(0.0, 1.0), dot(1.0, 1.0), fu), fv)
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
