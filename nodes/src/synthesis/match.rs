//! Match: the candidates for one place of a sketch, ranked.

use orograph_core::Unit;
use orograph_core::prelude::*;

use super::{
    canvas::Canvas,
    exemplar::Exemplar,
    matching::{Scene, Uses, choose},
    network::Network,
    patches::extract,
    settings::{Manner, Rules, UserTerms},
    synthesise::output_grid,
};
use crate::adjust::elevation_constraints::Wanted;

/// Ranks what an exemplar has to offer for one place of a sketch, beside the ground that is there.
#[derive(Params, Clone, Debug)]
pub struct Match {
    /// Whose rules are followed, and on what scale.
    #[param(flatten)]
    pub manner: Manner,
    /// Number of the place, from 1, in the order of placement.
    #[param(default = 1u32, range = 1..=1_000_000, slider = 1..=200, unit = "1")]
    pub place: u32,
    /// Candidates that are ranked.
    #[param(default = 10u32, range = 1..=1000, slider = 1..=50, unit = "1")]
    pub candidates: u32,
    /// What candidates are judged by beside the paper's costs.
    #[param(flatten)]
    pub terms: UserTerms,
}

/// Inputs of [`Match`].
#[derive(Inputs)]
pub struct MatchIn<'a> {
    /// Lines to follow.
    pub sketch: &'a Features,
    /// Terrain to take patches from.
    pub exemplar: &'a Heightfield,
    /// Lines found on it.
    pub features: &'a Features,
    /// Ground that is there already, on the sketch's grid; nothing when unconnected.
    pub ground: Option<&'a Heightfield>,
    /// Wanted heights, on the sketch's grid, void where the terrain is free.
    pub constraints: Option<&'a Heightfield>,
}

/// Outputs of [`Match`].
#[derive(Outputs)]
pub struct MatchOut {
    /// The best patch, warped to its place, on the sketch's rows and columns; voids elsewhere.
    pub patch: Heightfield,
    /// One row for each candidate, best first: centre, whether mirrored, bending, seam mismatch and total cost.
    pub ranking: Table,
}

impl Node for Match {
    const ID: &'static str = "synthesis.match";
    // 2 counts bends at joins, and falls back in more ways
    const VERSION: u32 = 3; // 3 cuts seams where slopes agree
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = MatchIn<'a>;
    type Outputs = MatchOut;

    fn cost(&self) -> f64 {
        100.0
    }

    fn run(&self, inputs: MatchIn<'_>, job: &Job) -> Result<MatchOut> {
        inputs.exemplar.grid().match_size("exemplar", &inputs.features.grid, "features")?;
        let exemplars = [Exemplar::new(inputs.exemplar, job)?];
        let n = self.candidates as usize;
        let mut rules =
            Rules { n_branch: n, n_path: n, n_cut: n, variety: 1, ..self.manner.rules(usize::MAX) };
        if !rules.strict() {
            rules.terms = self.terms;
        }
        let mut canvas = Canvas::new(inputs.sketch.grid.size(), job)?;
        if let Some(ground) = inputs.ground {
            inputs.sketch.grid.match_size("sketch", ground.grid(), "ground")?;
            canvas.lay(ground);
        }
        let grid = output_grid(&inputs.sketch.grid, &exemplars[0], job);
        let wanted = Wanted::of(&grid, inputs.constraints, None, job)?;
        let mut patch = Heightfield::filled(grid, f32::NAN, job)?;
        let network = Network::new(inputs.features, exemplars[0].scale);
        let pool = extract(&network, 0, &exemplars[0].terrain, &exemplars[0].voids, &rules, job)?;
        let plan = Network::new(inputs.sketch, [1.0; 2]).plan(rules.patch as f64);
        let mut ranked = Vec::new();
        if let Some(site) = plan.get(self.place as usize - 1) {
            let uses = Uses::default();
            let scene = Scene {
                canvas: &canvas,
                exemplars: &exemplars,
                kind: inputs.sketch.kind,
                uses: &uses,
                wanted: &wanted,
                rules: &rules,
            };
            match choose(site, &pool, &scene, 0.0, job)? {
                Some(chosen) => {
                    for (i, &height) in chosen.piece.sheet.heights.iter().enumerate() {
                        patch.cells_mut()[canvas.index(&chosen.piece.sheet.window, i)] = height;
                    }
                    ranked = chosen.considered;
                }
                None => job.warn("no candidate can be warped to that place"),
            }
        } else {
            job.warn(format!("the sketch has only {} places", plan.len()));
        }
        ranked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let scale = exemplars[0].scale;
        let column = |name: &str, unit, of: &dyn Fn(&super::matching::Ranked) -> f64| Column {
            name: name.into(),
            unit,
            cells: Cells::Numbers(ranked.iter().map(of).collect()),
        };
        let ranking = Table::new(vec![
            column("row", Unit::Cell, &|ranked| (ranked.center[0] + 0.5) / scale[0] - 0.5),
            column("col", Unit::Cell, &|ranked| (ranked.center[1] + 0.5) / scale[1] - 0.5),
            column("mirrored", Unit::One, &|ranked| f64::from(u8::from(ranked.mirrored))),
            column("bending", Unit::One, &|ranked| ranked.bend),
            column("seam_mismatch", Unit::Metre, &|ranked| ranked.seam),
            column("cost", Unit::One, &|ranked| ranked.cost),
        ])?;
        Ok(MatchOut { patch, ranking })
    }
}
