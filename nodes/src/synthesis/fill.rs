//! Fill: voids filled with windows of an exemplar, outwards from what is known.

use orograph_core::prelude::*;
use orograph_core::{Placement, Unit};

use super::{
    canvas::Canvas,
    exemplar::Exemplar,
    fill_windows::{self, Layout, Sources},
    gradient_merge::merge,
    matching::Uses,
    network::Network,
    settings::{Manner, seed_of},
    ssd::Searcher,
};
use crate::Chance;

/// Fills the voids of a terrain with ground of an exemplar that fits what is around.
///
/// Known cells stay to the bit, and so seams lie within what is filled.
#[derive(Params, Clone, Debug)]
pub struct Fill {
    /// Whose rules are followed, and on what scale.
    #[param(flatten)]
    pub manner: Manner,
    /// The first window where nothing is known.
    #[param(flatten)]
    pub chance: Chance,
}

/// Inputs of [`Fill`].
#[derive(Inputs)]
pub struct FillIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
    /// Terrain to take ground from, in cells of the same size.
    pub exemplar: &'a Heightfield,
    /// Lines on the exemplar, which fills then keep clear of.
    pub features: Option<&'a Features>,
}

/// Outputs of [`Fill`].
#[derive(Outputs)]
pub struct FillOut {
    /// Terrain without voids.
    pub terrain: Heightfield,
    /// Which window went where.
    pub placement: Placement,
    /// Windows pasted, and cells that nothing fitted.
    pub report: Table,
}

impl Node for Fill {
    const ID: &'static str = "synthesis.fill";
    const VERSION: u32 = 3; // 2 solves seams by another multigrid; 3 cuts seams where slopes agree
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = FillIn<'a>;
    type Outputs = FillOut;

    fn cost(&self) -> f64 {
        1000.0
    }

    fn run(&self, inputs: FillIn<'_>, job: &Job) -> Result<FillOut> {
        let exemplars = [Exemplar::new(inputs.exemplar, job)?];
        let exemplar = &exemplars[0].terrain;
        let most = exemplar.rows().min(exemplar.cols()).max(1);
        let mut rules = self.manner.rules(most);
        rules.seed = seed_of(self.chance, job);
        let networks: Vec<Network> = match inputs.features {
            Some(features) => {
                inputs.exemplar.grid().match_size("exemplar", &features.grid, "features")?;
                vec![Network::new(features, exemplars[0].scale)]
            }
            None => Vec::new(),
        };
        let searchers = [Searcher::new(&exemplars[0], &networks.iter().collect::<Vec<_>>(), job)?];
        let mut canvas = Canvas::new(inputs.terrain.grid().size(), job)?;
        canvas.freeze(inputs.terrain);
        let side = rules.fill_window().min(most);
        let most_lines = if networks.is_empty() { f64::INFINITY } else { side as f64 / 4.0 };
        let step = rules.fill_step().min((side * 2 / 3).max(1));
        let layout = Layout { side, step, raster: false, most_lines, balanced: false };
        let sources = Sources { exemplars: &exemplars, searchers: &searchers };
        let mut uses = Uses::default();
        let counts = fill_windows::fill(&mut canvas, &sources, &layout, &|_, _| 0, &mut uses, &rules, job)?;
        if let Some(reach) = rules.merge {
            merge(&mut canvas, reach, job)?;
        }
        if counts.smoothed > 0 {
            job.warn(format!("{} cells found nothing that fits and are filled smoothly", counts.smoothed));
        }
        let report = Table::metrics([
            ("windows", Unit::One, counts.pasted as f64),
            ("smoothed_cells", Unit::Cell, counts.smoothed as f64),
        ])?;
        let (terrain, placement) = canvas.finish(inputs.terrain.grid().clone(), &exemplars)?;
        Ok(FillOut { terrain, placement, report })
    }
}
