//! Patch pools: the places of an exemplar that features pass through. Positions only; pixels stay in the exemplar.
//!
//! Zhou 2007 §5.2. Each branch point and end is a candidate, and every quarter patch along a line, in both directions;
//! each also mirrored, unless that is switched off.

use orograph_core::prelude::*;
use orograph_core::{FeatureKind, Unit};

use super::{
    exemplar::Exemplar,
    network::{Arm, Network, Role, Site},
    resample::cubic,
    settings::{Preset, Rules},
    tps::Point,
};
use crate::PatchSize;

/// Lists the places of an exemplar that patches can be taken from: branch points, ends, and steps along its lines.
#[derive(Params, Clone, Debug)]
pub struct Patches {
    /// The patches.
    #[param(flatten)]
    pub patches: PatchSize,
    /// Each place counts mirrored, too.
    #[param(default = true)]
    pub mirror: bool,
}

/// Inputs of [`Patches`].
#[derive(Inputs)]
pub struct PatchesIn<'a> {
    /// Terrain to take patches from.
    pub exemplar: &'a Heightfield,
    /// Lines found on it.
    pub features: &'a Features,
}

/// Outputs of [`Patches`].
#[derive(Outputs)]
pub struct PatchesOut {
    /// One row for each candidate: kind, row and column of its centre, number of arms, 1 where mirrored.
    pub patches: Table,
}

impl Node for Patches {
    const ID: &'static str = "synthesis.patches";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PatchesIn<'a>;
    type Outputs = PatchesOut;

    fn run(&self, inputs: PatchesIn<'_>, job: &Job) -> Result<PatchesOut> {
        inputs.exemplar.grid().match_size("exemplar", &inputs.features.grid, "features")?;
        let exemplar = Exemplar::new(inputs.exemplar, job)?;
        let rules = Rules { mirror: self.mirror, ..Rules::of(Preset::Default, self.patches.side()) };
        let network = Network::new(inputs.features, exemplar.scale);
        let pool = extract(&network, 0, &exemplar.terrain, &exemplar.voids, &rules, job)?;
        if pool.left_out > 0 {
            job.warn(format!("{} places at the border or beside voids are left out", pool.left_out));
        }
        let all: Vec<&Candidate> = pool.branches.iter().chain(&pool.ends).chain(&pool.paths).collect();
        let name = |candidate: &&Candidate| match candidate.site.role {
            Role::Branch => "branch".to_owned(),
            Role::End => "end".to_owned(),
            Role::Path => "path".to_owned(),
        };
        // Rows and columns of the exemplar as it was given.
        let place = |axis: usize| {
            let scale = exemplar.scale[axis];
            all.iter().map(|candidate| (candidate.site.center[axis] + 0.5) / scale - 0.5).collect()
        };
        let numbers =
            |name: &str, unit, cells| Column { name: name.into(), unit, cells: Cells::Numbers(cells) };
        let mirrored = all.iter().map(|candidate| f64::from(u8::from(candidate.mirrored))).collect();
        let arms = all.iter().map(|candidate| candidate.site.arms.len() as f64).collect();
        let patches = Table::new(vec![
            Column {
                name: "kind".into(),
                unit: Unit::One,
                cells: Cells::Texts(all.iter().map(name).collect()),
            },
            numbers("row", Unit::Cell, place(0)),
            numbers("col", Unit::Cell, place(1)),
            numbers("arms", Unit::One, arms),
            numbers("mirrored", Unit::One, mirrored),
        ])?;
        Ok(PatchesOut { patches })
    }
}

/// A place to take a patch from.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Which exemplar.
    pub exemplar: usize,
    /// The place. A mirrored candidate's lines are reflected about the centre's column.
    pub site: Site,
    /// Whether the source is reflected.
    pub mirrored: bool,
}

/// The candidates of one exemplar and one kind of features.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pool {
    /// Branch points.
    pub branches: Vec<Candidate>,
    /// Ends.
    pub ends: Vec<Candidate>,
    /// Places along lines.
    pub paths: Vec<Candidate>,
    /// How far ground falls on the lower side of a usual stretch of line within three sixteenths of a patch, in metres.
    pub prominence: f64,
    /// Places that were left out because their window leaves the exemplar or meets a void.
    pub left_out: usize,
}

/// Most path candidates that are kept.
const MAX_PATHS: usize = 600;

impl Candidate {
    /// A position of the candidate's (perhaps mirrored) frame in the exemplar.
    #[must_use]
    pub fn source(&self, [row, col]: Point) -> Point {
        if self.mirrored { [row, 2.0 * self.site.center[1] - col] } else { [row, col] }
    }

    fn mirrored(&self) -> Self {
        let axis = self.site.center[1];
        let mut arms: Vec<Arm> = self
            .site
            .arms
            .iter()
            .map(|arm| Arm { track: arm.track.iter().map(|&[row, col]| [row, 2.0 * axis - col]).collect() })
            .collect();
        if self.site.role == Role::Branch {
            arms.sort_by(|a, b| a.angle().total_cmp(&b.angle()));
        }
        let site = Site { role: self.site.role, center: self.site.center, arms };
        Self { exemplar: self.exemplar, site, mirrored: !self.mirrored }
    }
}

/// Which windows of a terrain hold no void, by sums over rectangles.
#[derive(Clone, Debug)]
pub struct VoidSums {
    rows: usize,
    cols: usize,
    sums: Option<Vec<u32>>,
}

impl VoidSums {
    /// Sums over `terrain`; nothing is kept of one without voids.
    #[must_use]
    pub fn new(terrain: &Heightfield) -> Self {
        let (rows, cols) = terrain.grid().size();
        if terrain.void_count() == 0 {
            return Self { rows, cols, sums: None };
        }
        let mut sums = vec![0_u32; (rows + 1) * (cols + 1)];
        for row in 0..rows {
            let mut along = 0;
            for (col, height) in terrain.row(row).iter().enumerate() {
                along += u32::from(height.is_nan());
                sums[(row + 1) * (cols + 1) + col + 1] = sums[row * (cols + 1) + col + 1].wrapping_add(along);
            }
        }
        Self { rows, cols, sums: Some(sums) }
    }

    /// Whether the window from (`top`, `left`) lies inside and holds no void.
    #[must_use]
    pub fn is_whole(&self, top: i64, left: i64, rows: usize, cols: usize) -> bool {
        let inside =
            top >= 0 && left >= 0 && top as usize + rows <= self.rows && left as usize + cols <= self.cols;
        inside
            && self.sums.as_ref().is_none_or(|sums| {
                let (top, left) = (top as usize, left as usize);
                let at = |row: usize, col: usize| sums[row * (self.cols + 1) + col];
                let (bottom, right) = (top + rows, left + cols);
                at(bottom, right).wrapping_add(at(top, left)) == at(top, right).wrapping_add(at(bottom, left))
            })
    }
}

/// The pool of an exemplar.
///
/// # Errors
/// Cancellation.
pub fn extract(
    network: &Network,
    exemplar: usize,
    terrain: &Heightfield,
    voids: &VoidSums,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<Pool> {
    let (radius, patch) = (rules.radius(), rules.patch as f64);
    let side = (patch * 1.25).round() as usize;
    let mut pool = Pool::default();
    let add = |site: Option<Site>, pool: &mut Pool| {
        let Some(site) = site else { return };
        let corner = |at: f64| (at - side as f64 / 2.0).floor() as i64;
        if !voids.is_whole(corner(site.center[0]), corner(site.center[1]), side, side) {
            pool.left_out += 1;
            return;
        }
        let (list, role) = match site.role {
            Role::Branch => (&mut pool.branches, Role::Branch),
            Role::End => (&mut pool.ends, Role::End),
            Role::Path => (&mut pool.paths, Role::Path),
        };
        let candidate = Candidate { exemplar, site, mirrored: false };
        if role == Role::Path {
            let mut back = candidate.clone();
            back.site.arms.reverse();
            list.extend([candidate, back]);
        } else {
            list.push(candidate);
        }
    };
    for knot in 0..network.knots.len() {
        add(network.knot_site(knot, radius), &mut pool);
    }
    for (number, chain) in network.chains.iter().enumerate() {
        job.check()?;
        let length = chain.length();
        if length < patch / 2.0 {
            continue;
        }
        let mut at = patch / 2.0;
        if at > length - patch / 2.0 {
            add(network.path_site(number, length / 2.0, radius), &mut pool);
        }
        while at <= length - patch / 2.0 {
            add(network.path_site(number, at, radius), &mut pool);
            at += patch / 4.0;
        }
    }
    if rules.mirror {
        for list in [&mut pool.branches, &mut pool.ends, &mut pool.paths] {
            let reflected: Vec<Candidate> = list.iter().map(Candidate::mirrored).collect();
            list.extend(reflected);
        }
    }
    pool.prominence = prominence(&pool.paths, terrain, network.kind, rules);
    // Every k-th, counted in pairs of directions so that none is lost one-sidedly.
    let keep = pool.paths.len().div_ceil(MAX_PATHS).max(1);
    let mut number = 0;
    pool.paths.retain(|_| {
        number += 1;
        ((number - 1) / 2) % keep == 0
    });
    Ok(pool)
}

/// Distances across a line, in sixteenths of a patch, of the heights that tell whether it stands out.
pub(super) const ACROSS: [f64; 9] = [-3.0, -2.0, -1.0, -0.4, 0.0, 0.4, 1.0, 2.0, 3.0];

/// How far the ground falls on the less steep side of a line, from heights at [`ACROSS`]; negative heights for valleys.
pub(super) fn fall(at: impl Fn(usize) -> f32) -> f64 {
    let crest = at(3).max(at(4)).max(at(5));
    let side = |three: [usize; 3]| three.into_iter().map(|i| crest - at(i)).fold(f32::NEG_INFINITY, f32::max);
    let fall = side([0, 1, 2]).min(side([6, 7, 8]));
    if fall.is_finite() { f64::from(fall) } else { 0.0 }
}

/// Median of the falls at the centres of the candidates; 0 without any.
fn prominence(paths: &[Candidate], terrain: &Heightfield, kind: FeatureKind, rules: &Rules) -> f64 {
    let sign = if kind == FeatureKind::Ridge { 1.0 } else { -1.0 };
    let unit = rules.patch as f64 / 16.0;
    let mut falls: Vec<f64> = paths
        .iter()
        .map(|path| {
            let [a, b] = [0, 1].map(|arm| path.site.arms[arm].crossing(unit));
            let length = libm::hypot(b[0] - a[0], b[1] - a[1]).max(f64::MIN_POSITIVE);
            let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
            let [row, col] = path.site.center;
            let at = |i: usize| {
                let by = ACROSS[i] * unit;
                sign * cubic(terrain, [row + normal[0] * by, col + normal[1] * by])
            };
            fall(at)
        })
        .collect();
    if falls.is_empty() {
        return 0.0;
    }
    let middle = falls.len() / 2;
    *falls.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::network::{Chain, Knot};
    use crate::test_fields::field;

    /// Three lines of 150 cells from (200, 200), one of them bent.
    fn star() -> Network {
        let tips = [[200.0, 350.0], [50.0, 200.0], [330.0, 125.0]];
        let knot = |at: Point, chains: Vec<(usize, bool)>| Knot { at, height: 0.0, chains };
        let mut knots = vec![knot([200.0; 2], vec![(0, true), (1, true), (2, true)])];
        let mut chains = Vec::new();
        for (i, tip) in tips.into_iter().enumerate() {
            knots.push(knot(tip, vec![(i, false)]));
            let track = vec![[200.0; 2], tip];
            let length = libm::hypot(tip[0] - 200.0, tip[1] - 200.0);
            chains.push(Chain { ends: [0, i + 1], track, along: vec![0.0, length] });
        }
        Network { kind: FeatureKind::Ridge, knots, chains, rings: Vec::new() }
    }

    #[test]
    fn pools_hold_each_place_and_its_mirror_image() {
        let terrain = field(401, 401, |row, col| (row + col) as f64);
        let voids = VoidSums::new(&terrain);
        let rules = Rules::of(Preset::Default, 60);
        let pool = extract(&star(), 0, &terrain, &voids, &rules, &Job::detached()).unwrap();
        assert_eq!((pool.branches.len(), pool.ends.len(), pool.left_out), (2, 6, 0));
        // Seven places on each line of 150 cells, 30 to 120 by 15, in two directions and two images.
        assert_eq!(pool.paths.len(), 3 * 7 * 4);
        for candidate in pool.branches.iter().chain(&pool.paths) {
            let center = candidate.site.center;
            for arm in &candidate.site.arms {
                let away = libm::hypot(arm.tip()[0] - center[0], arm.tip()[1] - center[1]);
                assert!((away - rules.radius()).abs() < 0.01, "{away}");
            }
            let twice = candidate.mirrored().mirrored();
            assert_eq!((twice.mirrored, twice.site.role), (candidate.mirrored, candidate.site.role));
            for (a, b) in twice.site.arms.iter().zip(&candidate.site.arms) {
                assert!(libm::hypot(a.tip()[0] - b.tip()[0], a.tip()[1] - b.tip()[1]) < 1e-9);
            }
        }
    }

    #[test]
    fn windows_that_meet_a_void_or_the_border_are_left_out() {
        let terrain = field(401, 401, |row, col| if (row, col) == (60, 205) { f64::NAN } else { 1.0 });
        let rules = Rules { mirror: false, ..Rules::of(Preset::Default, 60) };
        let pool = extract(&star(), 0, &terrain, &VoidSums::new(&terrain), &rules, &Job::detached()).unwrap();
        assert_eq!(pool.ends.len(), 2);
        let near = |candidate: &Candidate| candidate.site.center[0] < 60.0 + 38.0;
        assert!(!pool.paths.iter().any(near) && pool.left_out > 1);
    }
}
