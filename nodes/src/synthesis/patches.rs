//! Patch pools: the places of an exemplar that features pass through. Positions only; pixels stay in the exemplar.
//!
//! Zhou 2007 §5.2. Each branch point and end is a candidate, and every quarter patch along a line, in both directions;
//! each also mirrored, unless that is switched off.

use orograph_core::{Heightfield, Job, Result};

use super::{
    network::{Arm, Network, Role, Site},
    settings::Rules,
    tps::Point,
};

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
    // Every k-th, counted in pairs of directions so that none is lost one-sidedly.
    let keep = pool.paths.len().div_ceil(MAX_PATHS).max(1);
    let mut number = 0;
    pool.paths.retain(|_| {
        number += 1;
        ((number - 1) / 2) % keep == 0
    });
    Ok(pool)
}
