//! The roughness spectrum of displaced surfaces: its exponent follows from H.

use std::f64::consts::TAU;

use orograph_core::prelude::*;

use crate::Chance;
use crate::mcmd::{
    mcmd::{Mcmd, McmdIn},
    params::{Displacement, Subdivision},
    settings::Scheme,
};
use crate::test_fields::field;

/// Exponent of the radial power spectrum of a square field: plane removed, Hann window, mean power in geometric rings.
fn exponent(terrain: &Heightfield) -> f64 {
    let n = terrain.rows();
    let heights = windowed(terrain);
    let (sin, cos): (Vec<f64>, Vec<f64>) = (0..n).map(|i| libm::sincos(TAU * i as f64 / n as f64)).unzip();
    // Rows first, then columns; half of the plane suffices, for the field is real.
    let half = n / 2;
    let mut rows = vec![(0.0, 0.0); n * (half + 1)];
    for y in 0..n {
        for k in 0..=half {
            let terms = (0..n).map(|x| (heights[y * n + x], x * k % n));
            rows[y * (half + 1) + k] =
                terms.fold((0.0, 0.0), |sum, (h, i)| (sum.0 + h * cos[i], sum.1 - h * sin[i]));
        }
    }
    let edges: Vec<f64> =
        (0..=24).map(|i| 6.0 * libm::pow(0.2 * n as f64 / 6.0, f64::from(i) / 24.0)).collect();
    let mut rings = vec![(0.0, 0.0, 0.0); 24];
    for kx in 0..=half {
        for ky in 0..n {
            let k = libm::hypot(kx as f64, ky.min(n - ky) as f64);
            let Some(ring) = (0..24).find(|&i| edges[i] <= k && k < edges[i + 1]) else { continue };
            let (re, im) = (0..n).fold((0.0, 0.0), |sum, y| {
                let (a, b) = rows[y * (half + 1) + kx];
                let i = y * ky % n;
                (sum.0 + a * cos[i] + b * sin[i], sum.1 + b * cos[i] - a * sin[i])
            });
            let ring = &mut rings[ring];
            *ring = (ring.0 + libm::log(k), ring.1 + re * re + im * im, ring.2 + 1.0);
        }
    }
    let points: Vec<(f64, f64)> =
        rings.iter().filter(|r| r.2 >= 4.0).map(|r| (r.0 / r.2, libm::log(r.1 / r.2))).collect();
    -slope(&points)
}

/// Heights less their least-squares plane, times a Hann window.
fn windowed(terrain: &Heightfield) -> Vec<f64> {
    let n = terrain.rows();
    let middle = (n - 1) as f64 / 2.0;
    let height = |i: usize| f64::from(terrain.cells()[i]);
    let cells = || (0..n * n).map(|i| (i, (i % n) as f64 - middle, (i / n) as f64 - middle));
    let mean = cells().map(|(i, ..)| height(i)).sum::<f64>() / (n * n) as f64;
    let square: f64 = cells().map(|(_, x, _)| x * x).sum();
    let along = cells().map(|(i, x, _)| x * height(i)).sum::<f64>() / square;
    let down = cells().map(|(i, _, y)| y * height(i)).sum::<f64>() / square;
    let hann = |offset: f64| 0.5 + 0.5 * libm::cos(TAU * offset / (n - 1) as f64);
    cells().map(|(i, x, y)| (height(i) - mean - along * x - down * y) * hann(x) * hann(y)).collect()
}

fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let (xy, xx) =
        points.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x) * (p.0 - x)));
    xy / xx
}

/// With m = 2 the exponent is about 2 m H + 2 - 0.2, the mean over three seeds.
#[test]
fn the_spectrum_falls_as_h_says() {
    let corners = field(257, 257, |row, col| if row % 256 == 0 && col % 256 == 0 { 0.0 } else { f64::NAN });
    for scheme in [Scheme::TriangleEdge, Scheme::DiamondSquare] {
        for hurst in [0.25, 0.35, 0.45, 0.5] {
            let of = |seed| {
                let node = Mcmd {
                    subdivision: Subdivision { scheme },
                    displacement: Displacement { hurst, rt: 0.0, rs: 0.5, relief: 1000.0 },
                    chance: Chance { seed },
                    ..Mcmd::default()
                };
                exponent(&node.run(McmdIn { constraints: &corners }, &Job::detached()).unwrap().terrain)
            };
            let mean = (1..=3).map(of).sum::<f64>() / 3.0;
            let expected = 4.0 * hurst + 1.8;
            assert!((mean - expected).abs() <= 0.25, "{scheme:?}, H {hurst}: {mean}, expected {expected}");
        }
    }
}
