//! A real terrain in four tiles: patched one by one, each with the ground of the others around, beside the whole.

use std::path::Path;

use orograph_core::prelude::*;
use orograph_nodes::{
    adjust::punch::{Punch, PunchIn},
    mask::random_voids::{RandomVoids, RandomVoidsIn},
    repair::void_patch::{VoidPatch, VoidPatchIn},
};

use super::repair::read;
use crate::Check;

/// Cells from edge to edge of a tile, ground around it, and cells from an inner edge that are looked at.
const STEP: usize = 1200;
const MARGIN: usize = 120;
const NEAR: usize = 60;
const TILES: [[usize; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];

pub(crate) fn checks() -> Vec<Check> {
    vec![Check::new("repair: tiles with their neighbours are patched as well as the whole", |folder| {
        tiles(&folder.join("tatra_carpathians_3as_2401.tif"))
    })]
}

fn tiles(path: &Path) -> Result<(), String> {
    let job = Job::detached();
    let said = |error: Error| error.to_string();
    let terrain = read(path)?;
    let side = terrain.grid().cell.x;
    let node = VoidPatch::default();
    let patch = |terrain: &Heightfield, around: Option<&Heightfield>| {
        node.run(VoidPatchIn { terrain, around }, &job).map(|out| out.terrain).map_err(said)
    };
    let (mut whole, mut together, mut alone) = (Errors::default(), Errors::default(), Errors::default());
    for seed in 1..=3 {
        let blots =
            RandomVoids { smallest: 20.0 * side, largest: 200.0 * side, seed, ..RandomVoids::default() };
        let mask = blots.run(RandomVoidsIn { like: &terrain }, &job).map_err(said)?.mask;
        let holed =
            Punch::default().run(PunchIn { terrain: &terrain, mask: &mask }, &job).map_err(said)?.terrain;
        whole.add(&terrain, &holed, &patch(&holed, None)?);
        let mut patched = Vec::new();
        for tile in TILES {
            let [own, around] =
                [cut(&holed, tile, 0).map_err(said)?, cut(&holed, tile, MARGIN).map_err(said)?];
            alone.add(&terrain, &holed, &patch(&own, None)?);
            patched.push(patch(&own, Some(&around))?);
            together.add(&terrain, &holed, &patched[patched.len() - 1]);
        }
        let [nw, ne, sw, se] = &patched[..] else { return Err("not four tiles".into()) };
        let same = (0..=STEP).all(|i| {
            [
                [nw.at(i, STEP), ne.at(i, 0)],
                [sw.at(i, STEP), se.at(i, 0)],
                [nw.at(STEP, i), sw.at(0, i)],
                [ne.at(STEP, i), se.at(0, i)],
            ]
            .into_iter()
            .all(|[a, b]| a.to_bits() == b.to_bits())
        });
        if !same {
            return Err("tiles differ in what they share".into());
        }
    }
    let [whole, together, alone] = [whole, together, alone].map(|errors| errors.rmse());
    let told = format!("{whole:.1} m the whole, {together:.1} m tiles with neighbours, {alone:.1} m alone");
    if together <= 1.02 * whole && together < 0.97 * alone { Ok(()) } else { Err(told) }
}

/// A tile with so much ground around.
fn cut(whole: &Heightfield, tile: [usize; 2], margin: usize) -> Result<Heightfield> {
    let [(row, rows), (col, cols)] = tile.map(|at| {
        let first = (at * STEP).saturating_sub(margin);
        (first, (at * STEP + STEP + 1 + margin).min(2 * STEP + 1) - first)
    });
    whole.crop(row, col, rows, cols, &Job::detached())
}

/// Squares of errors of filled cells near the inner edges.
#[derive(Default)]
struct Errors {
    sum: f64,
    n: f64,
}

impl Errors {
    fn add(&mut self, truth: &Heightfield, holed: &Heightfield, filled: &Heightfield) {
        let grid = filled.grid();
        for (i, height) in filled.cells().iter().enumerate() {
            let (row, col) = grid.base(i / grid.cols, i % grid.cols);
            let (row, col) = (row as usize, col as usize);
            let is_near = row.abs_diff(STEP) <= NEAR || col.abs_diff(STEP) <= NEAR;
            if is_near && holed.at(row, col).is_nan() && !truth.at(row, col).is_nan() {
                let off = f64::from(height - truth.at(row, col));
                (self.sum, self.n) = (self.sum + off * off, self.n + 1.0);
            }
        }
    }

    fn rmse(self) -> f64 {
        (self.sum / self.n).sqrt()
    }
}
