//! Area details: smooth patches get the multiresolution details of ground near by.
//!
//! Wecker, Samavati and Gavrilova (2007), final variant: the void's box and a box of measured ground are taken apart by
//! reverse Chaikin subdivision, and the details of the one go over the coarse form of the other. Departures, each of which
//! can be switched off: sources are searched farther away and in all orientations; details are as strong as the ground
//! around the void is rough, and are added to the patch instead of replacing what little it has, so that the rim keeps its
//! slope.

mod frame;
mod search;
mod source;
mod strength;
mod texture;

use orograph_core::{Cells, Column, Unit, prelude::*};
use rayon::prelude::*;

use super::voids::{self, Void, around};
use crate::filter::chaikin::{Boundary, Surface};
pub(super) use frame::Frame;
pub(super) use source::{Source, Turn};
use strength::Strength;
use texture::Texture;

/// How strong details are.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// As the ground around the void is rough, and added to the patch.
    Surroundings,
    /// As they were found, in place of the patch's own: the paper's rule.
    Source,
}

/// Where details are taken from.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// From the box within reach, turned and mirrored, whose rim and texture fit best.
    Search,
    /// From the best of the eight boxes beside the void's: the paper's rule.
    Neighbours,
}

/// How voids get details.
#[derive(Params, Clone, Copy, Debug, PartialEq)]
pub struct Details {
    /// Times that ground is halved; each brings forms of twice the size. More looks richer and lies farther from the truth.
    #[param(default = 2u32, range = 1..=6, unit = "1")]
    pub levels: u32,
    /// How the ends of boxes are treated when they are halved.
    #[param(default = Boundary::Natural)]
    pub boundary: Boundary,
    /// Cells that a void's box reaches over the ground around.
    #[param(default = 2u32, range = 0..=64, slider = 0..=8, unit = "cells")]
    pub margin: u32,
    /// What details are multiplied by.
    #[param(default = 1, range = 0.0..=2.0, unit = "1")]
    pub detail_gain: f64,
    /// How strong details are before that.
    #[param(default = Match::Surroundings)]
    pub strength: Match,
    /// Where details are taken from.
    #[param(default = From::Search)]
    pub source: From,
    /// How far away they are searched; at least as far as the void's box is long.
    #[param(default = 3000, range = 0.0..=1_000_000.0, slider = 0.0..=20_000.0, unit = "m")]
    pub reach: f64,
}

/// Gives filled voids the details of ground near by, so that they are as rough as their surroundings.
///
/// Known heights stay to the bit. Voids in a raster too small for a box and its neighbour keep the smooth patch.
#[derive(Params, Clone, Debug)]
pub struct AreaDetails {
    /// How voids get details.
    #[param(flatten)]
    pub details: Details,
}

/// Inputs of [`AreaDetails`].
#[derive(Inputs)]
pub struct AreaDetailsIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
    /// The same, its voids filled smoothly.
    pub smooth: &'a Heightfield,
}

/// Outputs of [`AreaDetails`].
#[derive(Outputs)]
pub struct AreaDetailsOut {
    /// Terrain with its voids filled.
    pub terrain: Heightfield,
    /// The same, but that known cells beside voids have the height that the patch would have there: what `repair.feather`
    /// needs to know.
    pub patch: Heightfield,
    /// One row for each void: its cells, its box, the levels used, where details came from, and their gain in its middle.
    pub report: Table,
}

impl Node for AreaDetails {
    const ID: &'static str = "repair.area_details";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = AreaDetailsIn<'a>;
    type Outputs = AreaDetailsOut;

    fn cost(&self) -> f64 {
        50.0
    }

    fn run(&self, inputs: AreaDetailsIn<'_>, job: &Job) -> Result<AreaDetailsOut> {
        let AreaDetailsIn { terrain, smooth } = inputs;
        terrain.grid().match_size("terrain", smooth.grid(), "smooth")?;
        let (patch, report) = transplant(terrain, smooth, &self.details, job)?;
        let terrain = voids::fill_by_cell(terrain, job, |row, col| patch.at(row, col))?;
        Ok(AreaDetailsOut { terrain, patch, report })
    }
}

/// Details for all voids of `terrain`, which `smooth` has filled: heights for the voids and the known cells beside them,
/// everything else as in `terrain`; and a row for each void.
///
/// # Errors
/// Those of the search for voids.
pub fn transplant(
    terrain: &Heightfield,
    smooth: &Heightfield,
    details: &Details,
    job: &Job<'_>,
) -> Result<(Heightfield, Table)> {
    let size = terrain.grid().size();
    let voids = voids::find(size, 0, |i| terrain.cells()[i].is_nan(), job)?;
    let done = job.stage(voids.len() as u64);
    let patches: Vec<Patch> = voids
        .par_iter()
        .map(|void| {
            let patch = Patch::new(terrain, smooth, void, details, job)?;
            done.advance(1);
            Ok(patch)
        })
        .collect::<Result<_>>()?;
    let mut out = terrain.map(job, |height| height)?;
    // Where two voids share a rim the later one tells what lies there; its own cells no other reaches.
    patches
        .iter()
        .flat_map(|patch| &patch.heights)
        .for_each(|&(cell, height)| out.cells_mut()[cell] = height);
    let bare = patches.iter().filter(|patch| patch.source.is_none()).count();
    if bare > 0 {
        job.warn(format!("{bare} voids have no ground within reach to take details from and stay smooth"));
    }
    Ok((out, report(&voids, &patches)?))
}

/// What goes into one void.
struct Patch {
    /// Heights of the void's cells and of the known ones beside them.
    heights: Vec<(usize, f32)>,
    frame: Option<Frame>,
    source: Option<Source>,
    gain: f64,
}

impl Patch {
    fn new(
        terrain: &Heightfield,
        smooth: &Heightfield,
        void: &Void,
        details: &Details,
        job: &Job<'_>,
    ) -> Result<Self> {
        job.check()?;
        let size = terrain.grid().size();
        let mut patch = Self { heights: Vec::new(), frame: None, source: None, gain: 0.0 };
        patch.frame = Frame::around(void, details.margin as usize, details.levels, size);
        let Some(frame) = patch.frame else { return Ok(patch.bare(smooth, void)) };
        job.admit(frame.len() as u64 * 80, || format!("a void's box of {} cells", frame.len()))?;
        // The paper's rules look at no texture.
        let looks = details.source == From::Search || details.strength == Match::Surroundings;
        let around = if looks { Texture::around(terrain, void) } else { Texture::default() };
        patch.source = match details.source {
            From::Neighbours => source::neighbour(terrain, smooth, &frame),
            From::Search => {
                let reach = frame.reach(details.reach, terrain.grid().cell);
                search::search(terrain, &frame, reach, &around, job)?
            }
        };
        let Some(source) = patch.source else { return Ok(patch.bare(smooth, void)) };
        let over = |i: usize| {
            let [row, col] = source.over(i, &frame);
            let known = terrain.at(row, col);
            f64::from(if known.is_nan() { smooth.at(row, col) } else { known })
        };
        let size = (frame.size[0], frame.size[1]);
        let ground = Surface { size, cells: (0..frame.len()).map(over).collect() };
        let mut added = ground.details(frame.levels, details.boundary, job)?;
        added.cells.iter_mut().for_each(|detail| *detail *= details.detail_gain);
        let at = |i: usize| {
            let [row, col] = frame.cell(i);
            f64::from(smooth.at(row, col))
        };
        let base = Surface { size, cells: (0..frame.len()).map(at).collect() };
        let surface: Vec<f64> = match details.strength {
            Match::Source => {
                let own = base.details(frame.levels, details.boundary, job)?;
                patch.gain = details.detail_gain;
                (0..frame.len()).map(|i| base.cells[i] - own.cells[i] + added.cells[i]).collect()
            }
            Match::Surroundings => {
                let wanted = around.rough * details.detail_gain * details.detail_gain;
                let strength = Strength::new(smooth, void, &frame, &added, wanted);
                patch.gain = strength.middle() * details.detail_gain;
                (0..frame.len()).map(|i| base.cells[i] + strength.at(i) * added.cells[i]).collect()
            }
        };
        patch.heights =
            reached(void, &frame, terrain.grid().size()).map(|(cell, i)| (cell, surface[i] as f32)).collect();
        Ok(patch)
    }

    /// The void as it was filled.
    fn bare(mut self, smooth: &Heightfield, void: &Void) -> Self {
        self.heights = void.cells.iter().map(|&cell| (cell, smooth.cells()[cell])).collect();
        self
    }
}

/// The void's cells and those beside them, as far as they lie in the box, with their numbers there. Known cells come first.
fn reached<'a>(
    void: &'a Void,
    frame: &'a Frame,
    size: (usize, usize),
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let beside = move |&cell: &usize| around(cell, size).into_iter().flatten();
    let inside = |cell: usize| frame.find(void.place(cell)).map(|i| (cell, i));
    let rim = void.cells.iter().flat_map(beside).filter(|cell| void.cells.binary_search(cell).is_err());
    rim.chain(void.cells.iter().copied()).filter_map(inside)
}

fn report(voids: &[Void], patches: &[Patch]) -> Result<Table> {
    let column =
        |name: &str, unit, cells: Vec<f64>| Column { name: name.into(), unit, cells: Cells::Numbers(cells) };
    let of_frame = |of: &dyn Fn(&Frame) -> f64| {
        patches.iter().map(|patch| patch.frame.as_ref().map_or(f64::NAN, of)).collect::<Vec<f64>>()
    };
    let of_source = |of: &dyn Fn(&Source) -> f64| {
        patches.iter().map(|patch| patch.source.as_ref().map_or(f64::NAN, of)).collect::<Vec<f64>>()
    };
    let levels = patches.iter().map(|patch| match (patch.frame, patch.source) {
        (Some(frame), Some(_)) => f64::from(frame.levels),
        _ => 0.0,
    });
    let turns = patches.iter().map(|patch| patch.source.map_or("", |source| source.turn.name()).to_owned());
    Table::new(vec![
        column("cells", Unit::Cell, voids.iter().map(|void| void.cells.len() as f64).collect()),
        column("row", Unit::Cell, of_frame(&|frame| frame.first[0] as f64)),
        column("col", Unit::Cell, of_frame(&|frame| frame.first[1] as f64)),
        column("rows", Unit::Cell, of_frame(&|frame| frame.size[0] as f64)),
        column("cols", Unit::Cell, of_frame(&|frame| frame.size[1] as f64)),
        column("levels", Unit::One, levels.collect()),
        column("source_row", Unit::Cell, of_source(&|source| source.first[0] as f64)),
        column("source_col", Unit::Cell, of_source(&|source| source.first[1] as f64)),
        Column { name: "source_turn".into(), unit: Unit::One, cells: Cells::Texts(turns.collect()) },
        column("gain", Unit::One, patches.iter().map(|patch| patch.gain).collect()),
    ])
}

#[cfg(test)]
mod tests;
