//! Elevation constraints: terrain that meets wanted heights and keeps its forms.
//!
//! Zhou 2007 names this as future work. In the gradient domain (Guérin, É. et al. (2022), "Gradient Terrain Authoring",
//! Computer Graphics Forum 41 (2)) the terrain's steps `g` are kept as well as wanted heights `z` allow: least
//! `sum over edges of (f_q - f_p - g)² + weight · sum over constraints of (f - z)²`. With `f = terrain + u` that is an
//! equation for the change `u` alone, harmonic off the constraints, so no pit or summit is invented: the membrane. As
//! a membrane pulled at one point is a spike, the default is a change without kinks, a sum of bells.

mod bells;
mod membrane;
#[cfg(test)]
mod tests;
mod wanted;

use orograph_core::{Unit, prelude::*};

use membrane::Ground;
pub use wanted::Wanted;

/// Changes below this, in metres, are none.
const EXACT: f64 = 1e-6;

/// How the change goes on between constraints.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Without kinks, as a sum of bells as wide as the distances between constraints allow.
    Smooth,
    /// As a stretched membrane: nowhere higher or lower than at the constraints, but with a spike at a lone point and a
    /// crease along a line.
    Membrane,
}

/// How well constraints are met.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Exactly.
    Exact,
    /// As their weight says, against the terrain's own steps: for rough or contradictory heights.
    Weighted,
}

/// Bends terrain until it meets wanted heights, such as summits, spot heights or levels along a road.
///
/// Wanted heights come as points, or as a raster that is void where nothing is wanted: `mcmd.sketch` draws one from
/// lines with heights, `feature.to_constraints` from ridges and valleys. Points win over the raster. Voids stay voids.
#[derive(Params, Clone, Copy, Debug)]
pub struct ElevationConstraints {
    /// How the change goes on between constraints.
    #[param(default = Shape::Smooth)]
    pub shape: Shape,
    /// Beyond this distance from every constraint nothing changes; 0 lets the change go as far as the terrain does.
    #[param(default = 0, range = 0.0..=1e7, slider = 0.0..=10_000.0, unit = "m")]
    pub influence: f64,
    /// How well constraints are met.
    #[param(default = Fit::Exact)]
    pub fit: Fit,
    /// Weight of a constraint if they are weighted; at 1 a lone point is met about half.
    #[param(default = 1, range = 1e-6..=1e6, slider = 0.01..=100.0, unit = "1")]
    pub weight: f64,
}

/// Inputs of [`ElevationConstraints`].
#[derive(Inputs)]
pub struct ElevationConstraintsIn<'a> {
    /// Terrain to bend.
    pub terrain: &'a Heightfield,
    /// Wanted heights, void where the terrain is free.
    pub constraints: Option<&'a Heightfield>,
    /// Wanted heights at places in the world; each counts at the nearest cell, several at one cell by their mean.
    pub points: Option<&'a Points>,
}

/// Outputs of [`ElevationConstraints`].
#[derive(Outputs)]
pub struct ElevationConstraintsOut {
    /// The terrain with its wanted heights.
    pub terrain: Heightfield,
    /// What was added to it.
    pub change: Heightfield,
    /// How many constraints there are, how far off they were at most before and after, and the greatest change.
    pub report: Table,
}

impl Node for ElevationConstraints {
    const ID: &'static str = "adjust.elevation_constraints";
    const VERSION: u32 = 3; // 3 solves the membrane by another multigrid
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ElevationConstraintsIn<'a>;
    type Outputs = ElevationConstraintsOut;

    fn cost(&self) -> f64 {
        100.0
    }

    fn run(&self, inputs: ElevationConstraintsIn<'_>, job: &Job) -> Result<ElevationConstraintsOut> {
        job.check()?;
        let terrain = inputs.terrain;
        let wanted = Wanted::of(terrain.grid(), inputs.constraints, inputs.points, job)?;
        let change = change(terrain, &wanted, self, job)?;
        let out = apply(terrain, &change, &wanted, self.fit == Fit::Exact, job)?;
        let off = |field: &Heightfield| {
            let off = wanted.iter().map(|(cell, height)| f64::from((field.cells()[cell] - height).abs()));
            // `max` passes over constraints on voids.
            off.fold(0.0, f64::max)
        };
        let report = Table::metrics([
            ("constraints", Unit::One, wanted.len() as f64),
            ("off_before_max", Unit::Metre, off(terrain)),
            ("off_after_max", Unit::Metre, off(&out)),
            ("change_max", Unit::Metre, change.iter().fold(0.0, |most, change| most.max(change.abs()))),
        ])?;
        let cols = terrain.cols();
        let change = Heightfield::build(terrain.grid().clone(), job, |row, added| {
            for ((added, &change), height) in
                added.iter_mut().zip(&change[row * cols..]).zip(terrain.row(row))
            {
                *added = if height.is_nan() { f32::NAN } else { change as f32 };
            }
            Ok(())
        })?;
        Ok(ElevationConstraintsOut { terrain: out, change, report })
    }
}

/// A cell and what is to be added there, in metres.
#[derive(Clone, Copy, Debug)]
struct Site {
    cell: usize,
    change: f64,
}

/// What is to be added to each cell, in metres, for the terrain to meet what is wanted.
///
/// # Errors
/// [`Error::Invalid`] for infinite heights, [`Error::NotConverged`], [`Error::TooLarge`], or cancellation.
pub fn change(
    terrain: &Heightfield,
    wanted: &Wanted,
    settings: &ElevationConstraints,
    job: &Job<'_>,
) -> Result<Vec<f64>> {
    let grid = terrain.grid();
    let on_ground = |&(cell, _): &(usize, f32)| terrain.cells()[cell].is_finite();
    let site = |(cell, height): (usize, f32)| {
        let change = f64::from(height) - f64::from(terrain.cells()[cell]);
        Site { cell, change }
    };
    let mut sites: Vec<Site> = wanted.iter().filter(on_ground).map(site).collect();
    let passed_over = wanted.len() - sites.len();
    if passed_over > 0 {
        job.warn(format!("{passed_over} constraints lie on voids and are passed over"));
    }
    if sites.iter().all(|site| site.change == 0.0) {
        if sites.is_empty() {
            job.warn("no height is wanted on this terrain: it stays as it is");
        }
        job.admit(grid.len() as u64 * 8, || format!("the change of {} cells", grid.len()))?;
        return Ok(vec![0.0; grid.len()]);
    }
    let ground = Ground::new(terrain, &sites, settings.influence, job)?;
    let side = (grid.rows as f64 * grid.cell.y).max(grid.cols as f64 * grid.cell.x);
    if settings.shape == Shape::Membrane {
        return match settings.fit {
            Fit::Exact => ground.exact(&sites, job),
            Fit::Weighted => ground.weighted(&sites, settings.weight, 0.0, job),
        };
    }
    if settings.fit == Fit::Weighted {
        // Steps alone would lift all of the terrain for one point, so its level weighs too, if little.
        let cells = side / grid.cell.x.min(grid.cell.y);
        let met = ground.weighted(&sites, settings.weight, 1.0 / (cells * cells), job)?;
        sites.iter_mut().for_each(|site| site.change = met[site.cell]);
    }
    let reach = if settings.influence > 0.0 { settings.influence } else { side };
    let (mut change, left) = bells::bells(grid, &sites, reach, job)?;
    if left.iter().any(|left| left.abs() > EXACT) {
        sites.iter_mut().zip(left).for_each(|(site, left)| site.change = left);
        let rest = ground.exact(&sites, job)?;
        change.iter_mut().zip(rest).for_each(|(change, rest)| *change += rest);
    }
    Ok(change)
}

/// The terrain with what is added to it; wanted heights to the bit where they are to be exact.
fn apply(
    terrain: &Heightfield,
    change: &[f64],
    wanted: &Wanted,
    exact: bool,
    job: &Job<'_>,
) -> Result<Heightfield> {
    let cols = terrain.cols();
    let mut out = Heightfield::build(terrain.grid().clone(), job, |row, out| {
        for ((out, &change), &height) in out.iter_mut().zip(&change[row * cols..]).zip(terrain.row(row)) {
            *out = if change == 0.0 { height } else { (f64::from(height) + change) as f32 };
        }
        Ok(())
    })?;
    for (cell, height) in wanted.iter().filter(|_| exact) {
        if terrain.cells()[cell].is_finite() {
            out.cells_mut()[cell] = height;
        }
    }
    Ok(out)
}

/// Terrain that meets what is wanted; voids stay voids.
///
/// # Errors
/// Those of [`change`].
pub fn constrain(
    terrain: &Heightfield,
    wanted: &Wanted,
    settings: &ElevationConstraints,
    job: &Job<'_>,
) -> Result<Heightfield> {
    let change = change(terrain, wanted, settings, job)?;
    apply(terrain, &change, wanted, settings.fit == Fit::Exact, job)
}
