//! Voids in real terrain: patched ones against the truth, real ones filled to the last cell.

use std::path::Path;

use orograph_core::prelude::*;
use orograph_nodes::{
    Chance,
    adjust::punch::{Punch, PunchIn},
    io::read_dem::ReadDem,
    mask::random_voids::{RandomVoids, RandomVoidsIn},
    mcmd::random_decimate::{RandomDecimate, RandomDecimateIn},
    measure::compare::{Compare, CompareIn},
    repair::{
        harmonic_fill::harmonic_fill,
        thin_plate_fill::{Stiffness, thin_plate_fill},
        void_patch::{VoidPatch, VoidPatchIn},
    },
};

use crate::Check;

/// Mountains in which voids are made.
const MOUNTAINS: [&str; 6] = [
    "mount_washington_3as_1025.tif",
    "mount_jackson_n39w107_3as_1201.tif",
    "southern_alps_s45e169_3as_1201.tif",
    "tatra_carpathians_3as_2401.tif",
    "big_tujunga_30m_1197x643.tif",
    "N32E076.hgt.zip",
];

/// Tiles with voids of their own.
const TILES: [&str; 6] = [
    "N27E086.hgt.zip",
    "N42E001.hgt.zip",
    "N43E007.hgt.zip",
    "N46E008.hgt.zip",
    "N46W122.hgt",
    "N49W123.hgt.zip",
];

pub(crate) fn checks() -> Vec<Check> {
    let mut checks: Vec<Check> = MOUNTAINS
        .into_iter()
        .map(|file| {
            Check::new(format!("repair: patches in {file} are near the truth and as rough"), move |folder| {
                patches(&folder.join(file))
            })
        })
        .collect();
    checks.extend(TILES.into_iter().map(|file| {
        Check::new(format!("repair: {file} is filled to the last cell"), move |folder| {
            fills(&folder.join(file))
        })
    }));
    checks.push(Check::new(
        "repair: a thin plate rebuilds Mount Washington from 3.4 % of its cells",
        |folder| rebuilds(&folder.join(MOUNTAINS[0])),
    ));
    checks
}

pub(crate) fn read(path: &Path) -> Result<Heightfield, String> {
    let file = InputPath(path.display().to_string());
    let read = ReadDem { file, ..ReadDem::default() }.run((), &Job::detached());
    read.map(|out| out.terrain).map_err(|error| error.to_string())
}

/// Over three sets of voids of 20 to 200 cells across, each a twentieth of the ground: the error is at most a twentieth above
/// the better interpolator's, and roughness and steps are those of the ground.
fn patches(path: &Path) -> Result<(), String> {
    const NAMES: [&str; 4] = ["rmse", "roughness_ratio", "roughness_ratio_rim", "step_ratio_rim"];
    const SEEDS: u32 = 3;
    let job = Job::detached();
    let said = |error: Error| error.to_string();
    let terrain = read(path)?;
    let side = terrain.grid().cell.x;
    let (mut sums, mut plate, mut harmonic) = ([0.0; 4], 0.0, 0.0);
    for seed in 1..=SEEDS {
        let blots =
            RandomVoids { smallest: 20.0 * side, largest: 200.0 * side, seed, ..RandomVoids::default() };
        let mask = blots.run(RandomVoidsIn { like: &terrain }, &job).map_err(said)?.mask;
        let tile =
            Punch::default().run(PunchIn { terrain: &terrain, mask: &mask }, &job).map_err(said)?.terrain;
        let measure = |filled: &Heightfield| {
            let inputs =
                CompareIn { terrain: filled, reference: &terrain, known: Some(&tile), mask: Some(&mask) };
            let metrics = Compare { rim: 2 }.run(inputs, &job).map_err(said)?.metrics;
            Ok::<_, String>(move |name: &str| metrics.metric(name).unwrap_or(f64::NAN))
        };
        let filled = VoidPatch::default()
            .run(VoidPatchIn { terrain: &tile, around: None }, &job)
            .map_err(said)?
            .terrain;
        let patch = measure(&filled)?;
        if patch("exact_at_known") != 100.0 || patch("missing") != 0.0 {
            return Err("a known cell was changed, or one is missing".into());
        }
        sums.iter_mut().zip(NAMES).for_each(|(sum, name)| *sum += patch(name));
        plate += measure(&thin_plate_fill(&tile, None, Stiffness::default(), &job).map_err(said)?)?("rmse");
        harmonic += measure(&harmonic_fill(&tile, None, &job).map_err(said)?)?("rmse");
    }
    let mean = |sum: f64| sum / f64::from(SEEDS);
    let [error, rough, rim, step] = sums.map(mean);
    let is_good = error <= 1.05 * mean(plate.min(harmonic))
        && (0.9..=1.1).contains(&rough)
        && (0.9..=1.1).contains(&rim)
        && step <= 1.1;
    if is_good {
        return Ok(());
    }
    Err(format!(
        "error {error:.1} m (plate {:.1}, harmonic {:.1}), roughness {rough:.3}, at the rim {rim:.3}, steps {step:.3}",
        mean(plate),
        mean(harmonic)
    ))
}

/// No void is left, known heights are kept to the bit, and filled ones lie within reason.
fn fills(path: &Path) -> Result<(), String> {
    let tile = read(path)?;
    let voids = tile.void_count();
    if voids == 0 {
        return Err("the tile has no voids".into());
    }
    let filled = VoidPatch::default()
        .run(VoidPatchIn { terrain: &tile, around: None }, &Job::detached())
        .map_err(|error| error.to_string())?
        .terrain;
    if filled.void_count() > 0 {
        return Err(format!("{} of {voids} voids are left", filled.void_count()));
    }
    let pairs = || tile.cells().iter().zip(filled.cells());
    if pairs().any(|(known, height)| !known.is_nan() && known.to_bits() != height.to_bits()) {
        return Err("a known cell was changed".into());
    }
    let (low, high) = tile.known_range("tile").map_err(|error| error.to_string())?;
    let relief = high - low;
    match filled.cells().iter().find(|&&height| height < low - 0.2 * relief || height > high + 0.2 * relief) {
        Some(height) => Err(format!("a height of {height} m, of a tile from {low} to {high} m")),
        None => Ok(()),
    }
}

/// The mean error over three choices of samples is that of minimum curvature: 17.7 to 18.1 m.
fn rebuilds(path: &Path) -> Result<(), String> {
    let job = Job::detached();
    let said = |error: Error| error.to_string();
    let terrain = read(path)?;
    let mut sum = 0.0;
    for seed in 1..=3 {
        let thin = RandomDecimate { keep: 35_721.0 / 1_050_625.0, chance: Chance { seed } };
        let samples = thin.run(RandomDecimateIn { terrain: &terrain }, &job).map_err(said)?.constraints;
        let out = thin_plate_fill(&samples, None, Stiffness::default(), &job).map_err(said)?;
        let inputs = CompareIn { terrain: &out, reference: &terrain, known: Some(&samples), mask: None };
        let metrics = Compare::default().run(inputs, &job).map_err(said)?.metrics;
        sum += metrics.metric("rmse").unwrap_or(f64::NAN);
    }
    if sum / 3.0 <= 18.1 { Ok(()) } else { Err(format!("an error of {:.2} m", sum / 3.0)) }
}
