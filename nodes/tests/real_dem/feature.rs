//! Ridges and valleys of real terrain, against counts of an independent prototype.

use std::path::Path;

use orograph_core::{PointKind, prelude::*};
use orograph_nodes::{
    feature::{
        lattice::Blocks,
        ppa::{Ppa, PpaIn, find, forest},
        settings::{Drop, Reduction, Shaping, Steps},
    },
    io::read_dem::ReadDem,
};

use crate::Check;

/// A file, what is looked for, the share of blocks of 5 × 5 cells on lines in percent, branch points and ends.
const TABLE: [(&str, FeatureKind, f64, usize, usize); 2] = [
    ("mount_jackson_n39w107_3as_1201.tif", FeatureKind::Ridge, 5.6, 59, 229),
    ("grand_canyon_n36w113_1000.tif", FeatureKind::Valley, 3.7, 47, 90),
];

/// Files with few lines or none, which must come out all the same.
const DULL: [&str; 3] =
    ["bohemian_highlands_n49e015_3as_1201.tif", "big_butte_flat_30m_623x672.tif", "N53E028.hgt.zip"];

pub(crate) fn checks() -> Vec<Check> {
    let counted = TABLE.into_iter().map(|(file, kind, share, branches, ends)| {
        Check::new(format!("feature: {file} has {branches} branch points and {ends} ends"), move |folder| {
            counts(&read(&folder.join(file))?, kind, share, branches, ends)
        })
    });
    let dull = DULL.into_iter().map(|file| {
        Check::new(format!("feature: {file} is looked through without complaint"), move |folder| {
            let terrain = read(&folder.join(file))?;
            let out = Ppa::default().run(PpaIn { terrain: &terrain }, &Job::detached());
            let share = out.map_err(|error| error.to_string())?.report.metric("share").unwrap_or(f64::NAN);
            if (0.0..20.0).contains(&share) {
                Ok(())
            } else {
                Err(format!("{share} % of the ground on lines"))
            }
        })
    });
    counted.chain(dull).collect()
}

fn read(path: &Path) -> Result<Heightfield, String> {
    let file = InputPath(path.display().to_string());
    let read = ReadDem { file, ..ReadDem::default() }.run((), &Job::detached());
    read.map(|out| out.terrain).map_err(|error| error.to_string())
}

/// The prototype knew nothing of the cells' shape nor of rings, so the counts are those of square cells and without them.
fn counts(
    terrain: &Heightfield,
    kind: FeatureKind,
    share: f64,
    branches: usize,
    ends: usize,
) -> Result<(), String> {
    let job = Job::detached();
    let said = |error: Error| error.to_string();
    let square = Grid { cell: CellSize::square(80.0), ..terrain.grid().clone() };
    let terrain = terrain.clone().with_grid(square).map_err(said)?;
    let reduction = Reduction { rings: false, ..Reduction::default() };
    let steps = Steps { kind, drop: Drop::Share(0.05), reduction, ..Steps::default() };
    let found = find(&terrain, &steps, &Shaping::default(), &job).map_err(said)?;
    let count = |kind| found.features.points.iter().filter(|point| point.kind == kind).count();
    let got = (count(PointKind::Branch), count(PointKind::End));
    if got != (branches, ends) || (100.0 * found.share - share).abs() > 0.06 {
        return Err(format!(
            "{got:?} and {:.2} %, stated {:?} and {share} %",
            100.0 * found.share,
            (branches, ends)
        ));
    }
    let raw = forest(&terrain, Blocks { down: 5, across: 5 }, &steps, &job).map_err(said)?.forest;
    let trees = found.features.points.len() - found.features.lines.len();
    if raw.segments() + trees != raw.nodes() {
        return Err(format!("{} segments, {} cells, {trees} trees", raw.segments(), raw.nodes()));
    }
    Ok(())
}
