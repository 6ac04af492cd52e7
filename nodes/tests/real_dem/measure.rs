//! What is known of all natural terrain, found in real terrain by the metrics.

use std::path::Path;

use orograph_core::prelude::*;
use orograph_nodes::{
    io::read_dem::ReadDem,
    measure::{
        copies::repetition, drainage::Drainage, realism::portrait::Portrait, seams::Lines,
        slope_distribution::Slopes,
    },
};

use crate::Check;

/// Terrain shaped by running water, whole and at its true resolution.
const RIVERS: [&str; 3] = [
    "mount_jackson_n39w107_3as_1201.tif",
    "southern_alps_s45e169_3as_1201.tif",
    "big_tujunga_30m_1197x643.tif",
];

pub(crate) fn checks() -> Vec<Check> {
    RIVERS
        .into_iter()
        .map(|file| {
            Check::new(
                format!("measure: {file} obeys the laws of drainage and does not repeat itself"),
                move |folder| is_natural(&folder.join(file)),
            )
        })
        .collect()
}

fn is_natural(path: &Path) -> Result<(), String> {
    let job = Job::detached();
    let said = |error: Error| error.to_string();
    let file = InputPath(path.display().to_string());
    let terrain = ReadDem { file, ..ReadDem::default() }.run((), &job).map_err(said)?.terrain;
    let drainage = Drainage::default().figures(&terrain, &job).map_err(said)?.0;
    let portrait = Portrait::of(&terrain, &job).map_err(said)?;
    let repeats = repetition(&terrain, 80, &job).map_err(said)?;
    let lines = Lines::of(&terrain, 8, &job).map_err(said)?;
    let mean_slope = Slopes::of(&terrain, &job).map_err(said)?.mean;
    let found = [
        // Rodríguez-Iturbe et al. find 0.43 ± 0.02 within basins; the edges of a map cut basins off.
        ("exceedance exponent", drainage.exceedance, -0.60, -0.35),
        // Hack and his successors find 0.5 to 0.6.
        ("Hack exponent", drainage.hack, 0.45, 0.70),
        // Mountains at 30 to 90 m.
        ("beta", portrait.rings.beta, 2.2, 4.2),
        ("Hurst exponent", portrait.semivariances.hurst(), 0.4, 1.0),
        ("mean slope", mean_slope, 5.0, 45.0),
        ("autocorrelation", repeats.peak, -1.0, 0.6),
        ("step along a row", lines.between_rows.log_ratio, -0.25, 0.25),
        ("step along a column", lines.between_columns.log_ratio, -0.25, 0.25),
    ];
    let wrong: Vec<String> = found
        .iter()
        .filter(|(_, value, low, high)| !(low..=high).contains(&value))
        .map(|(name, value, low, high)| format!("{name} is {value:.3}, expected {low} to {high}"))
        .collect();
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}
