//! Realism: a terrain beside the exemplar that it should look like.
//!
//! How far apart two terrains of the same kind may lie is not known beforehand, so the exemplar says it: every
//! distance is held against the same distance between halves of the exemplar, the mean of west against east and
//! north against south.

pub mod picture;
pub mod portrait;
pub mod verdict;

use orograph_core::{ParamValue, Placement, prelude::*};

use picture::Side;
use portrait::Portrait;
use verdict::Bars;

use crate::transform::resize::{Method, resize};

/// Reports how far a terrain is from its exemplar, as a table and as a picture.
///
/// Each distance stands beside the one between halves of the exemplar itself, their ratio, and the most that is
/// good enough. A half is a smaller terrain than the whole, so the comparison is a hard one.
#[derive(Params, Clone, Debug)]
pub struct Realism {
    /// Most that a distance may be, over that between the exemplar's halves.
    #[param(default = 1.5, range = 0.0..=100.0, slider = 1.0..=3.0, unit = "1")]
    pub ratio_bar: f64,
    /// Most that density and depth of closed depressions may be, over the exemplar's.
    #[param(default = 2, range = 0.0..=100.0, slider = 1.0..=4.0, unit = "1")]
    pub pit_bar: f64,
    /// Most that seams may stand out or be ironed flat, as a logarithm; see `measure.seams`.
    #[param(default = 0.25, range = 0.0..=10.0, slider = 0.05..=1.0, unit = "1")]
    pub seam_bar: f64,
    /// What the picture calls the terrain.
    #[param(default = "terrain")]
    pub terrain_label: String,
    /// What the picture calls the exemplar.
    #[param(default = "exemplar")]
    pub exemplar_label: String,
    /// Longer side of each terrain in the picture.
    #[param(default = 480u32, range = 320..=4096, slider = 320..=1200, unit = "px")]
    pub size: u32,
}

/// Inputs of [`Realism`].
#[derive(Inputs)]
pub struct RealismIn<'a> {
    /// Terrain to judge.
    pub terrain: &'a Heightfield,
    /// Terrain that it should look like, of any size.
    pub exemplar: &'a Heightfield,
    /// Which patch each cell of the terrain came from, for its seams.
    pub placement: Option<&'a Placement>,
}

/// Outputs of [`Realism`].
#[derive(Outputs)]
pub struct RealismOut {
    /// One row for each metric: a figure of both, their distance, that between halves, ratio, bar, whether met.
    pub report: Table,
    /// Both terrains shaded, their distributions of slopes, heights, wavelengths and landforms, and the figures.
    pub picture: Texture,
}

impl Node for Realism {
    const ID: &'static str = "measure.realism";
    // 2 draws no picture so small that its texts overlap
    const VERSION: u32 = 3; // 3 looks at both on the same cells, and over the same wavelengths
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = RealismIn<'a>;
    type Outputs = RealismOut;

    fn cost(&self) -> f64 {
        1000.0
    }

    fn upgrade(params: &mut RawParams, _from: u32) -> Result<()> {
        if let Some(ParamValue::Integer(size)) = params.0.get_mut("size") {
            *size = (*size).max(320);
        }
        Ok(())
    }

    fn run(&self, inputs: RealismIn<'_>, job: &Job) -> Result<RealismOut> {
        let RealismIn { terrain, exemplar, placement } = inputs;
        job.check()?;
        terrain.known_range("terrain")?;
        exemplar.known_range("exemplar")?;
        let resampled = on_cells_of(terrain, exemplar, job)?;
        let exemplar = resampled.as_ref().unwrap_or(exemplar);
        let sides = [Portrait::of(terrain, job)?, Portrait::of(exemplar, job)?];
        let halves = verdict::between_halves(exemplar, job)?;
        let bars = Bars { ratio: self.ratio_bar, pits: self.pit_bar, seams: self.seam_bar };
        let lines = verdict::judge((terrain, &sides[0]), &sides[1], halves, placement, bars, job)?;
        let side = |label, terrain, portrait| Side { label, terrain, portrait };
        let picture = picture::draw(
            [side(&self.terrain_label, terrain, &sides[0]), side(&self.exemplar_label, exemplar, &sides[1])],
            &lines,
            self.size,
            job,
        )?;
        Ok(RealismOut { report: verdict::table(&lines)?, picture })
    }
}

/// Cells that differ in area by more than this are of other scales: resampled ground would be all blur, or hardly any.
const SCALES: f64 = 16.0;

/// The exemplar on cells of the terrain's size: slopes, curvatures and landforms depend on how closely one looks. `None` if
/// it has them, to a hundredth, or is of another scale, which is remarked.
fn on_cells_of(terrain: &Heightfield, exemplar: &Heightfield, job: &Job) -> Result<Option<Heightfield>> {
    let [own, other] = [terrain, exemplar].map(|field| field.grid().cell);
    let alike = |a: f64, b: f64| (a / b - 1.0).abs() < 0.01;
    if alike(own.x, other.x) && alike(own.y, other.y) {
        return Ok(None);
    }
    let share = other.x * other.y / (own.x * own.y);
    if !(1.0 / SCALES..=SCALES).contains(&share) {
        job.warn(format!(
            "cells of {} × {} m are held against cells of {} × {} m: slopes and curvatures depend on their size",
            own.x, own.y, other.x, other.y
        ));
        return Ok(None);
    }
    job.warn(format!(
        "the exemplar's cells of {:.1} × {:.1} m are resampled to the terrain's {:.1} × {:.1} m before both are measured",
        other.x, other.y, own.x, own.y
    ));
    let cells = |n: usize, ratio: f64| (n as f64 * ratio).round().max(1.0) as usize;
    let (rows, cols) = (cells(exemplar.rows(), other.y / own.y), cells(exemplar.cols(), other.x / own.x));
    resize(exemplar, rows, cols, Method::Auto, job).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::{
            curvature::{Curvature, CurvatureIn},
            drainage::{Drainage, DrainageIn},
            geomorphons::{Geomorphons, GeomorphonsIn},
            hypsometry::{Hypsometry, HypsometryIn},
            slope_distribution::{SlopeDistribution, SlopeDistributionIn},
            spectrum::{Spectrum, SpectrumIn},
            variogram::{Variogram, VariogramIn},
        },
        test_fields::field,
    };

    fn hills(scale: f64) -> Heightfield {
        field(96, 100, |row, col| {
            let bump = 30.0 * libm::sin(row as f64 / scale) * libm::cos(col as f64 / (0.7 * scale));
            bump + 2.0 * orograph_core::gaussian(1, 3, row as i64, col as i64)
        })
    }

    fn numbers<'a>(table: &'a Table, name: &str) -> &'a [f64] {
        match &table.column(name).unwrap().cells {
            Cells::Numbers(cells) => cells,
            Cells::Texts(_) => panic!(),
        }
    }

    #[test]
    fn figures_are_those_of_the_nodes_that_measure_them_alone() {
        let (terrain, exemplar) = (hills(5.0), hills(9.0));
        let job = Job::detached();
        let inputs = RealismIn { terrain: &terrain, exemplar: &exemplar, placement: None };
        let out = Realism::default().run(inputs, &job).unwrap();
        let (terrain, reference) = (&terrain, Some(&exemplar));
        let alone = [
            SlopeDistribution::default()
                .run(SlopeDistributionIn { terrain, reference }, &job)
                .unwrap()
                .metrics,
            Curvature::default().run(CurvatureIn { terrain, reference }, &job).unwrap().metrics,
            Hypsometry::default().run(HypsometryIn { terrain, reference }, &job).unwrap().metrics,
            Spectrum::default().run(SpectrumIn { terrain, reference }, &job).unwrap().metrics,
            Variogram::default().run(VariogramIn { terrain, reference }, &job).unwrap().metrics,
            Geomorphons::default().run(GeomorphonsIn { terrain, reference }, &job).unwrap().metrics,
            Drainage::default().run(DrainageIn { terrain, reference, valleys: None }, &job).unwrap().metrics,
        ];
        let Cells::Texts(names) = &out.report.column("metric").unwrap().cells else { panic!() };
        assert_eq!(names.len(), 14);
        let Cells::Texts(figures) = &out.report.column("figure").unwrap().cells else { panic!() };
        for (figure, &value) in figures.iter().zip(numbers(&out.report, "terrain")) {
            let name = figure.split(',').next().unwrap();
            let found = alone.iter().find_map(|table| table.metric(name)).unwrap_or(f64::NAN);
            assert!(found == value || found.is_nan() && value.is_nan(), "{name}: {found} and {value}");
            assert_eq!(name.is_empty(), !alone.iter().any(|table| table.column(name).is_some()));
        }
        for (name, &value) in names.iter().zip(numbers(&out.report, "value")) {
            let found = alone.iter().find_map(|table| table.metric(name)).unwrap();
            assert!(found == value || found.is_nan() && value.is_nan(), "{name}: {found} and {value}");
        }
    }

    #[test]
    fn an_exemplar_on_other_cells_is_looked_at_as_closely_as_the_terrain() {
        let job = Job::detached();
        let exemplar = hills(9.0);
        let finer = resize(&exemplar, 2 * exemplar.rows(), 2 * exemplar.cols(), Method::Auto, &job).unwrap();
        let report = |exemplar| {
            let inputs = RealismIn { terrain: &finer, exemplar, placement: None };
            Realism::default().run(inputs, &job).unwrap().report
        };
        let (own, coarse) = (report(&finer), report(&exemplar));
        assert_eq!(numbers(&own, "exemplar")[0], numbers(&coarse, "exemplar")[0]);
        assert!(numbers(&coarse, "value")[..12].iter().all(|&value| value == 0.0 || value.is_nan()));
    }

    #[test]
    fn an_exemplar_of_another_scale_is_measured_as_it_is() {
        let exemplar = hills(9.0);
        let fine = Grid::new(exemplar.rows(), exemplar.cols(), CellSize::square(0.5)).unwrap();
        let fine = Heightfield::new(fine, exemplar.cells().to_vec()).unwrap();
        assert!(on_cells_of(&fine, &exemplar, &Job::detached()).unwrap().is_none());
        assert!(on_cells_of(&exemplar, &fine, &Job::detached()).unwrap().is_none());
    }

    #[test]
    fn an_exemplar_beside_itself_meets_every_bar() {
        let exemplar = hills(9.0);
        let inputs = RealismIn { terrain: &exemplar, exemplar: &exemplar, placement: None };
        let report = Realism::default().run(inputs, &Job::detached()).unwrap().report;
        let Cells::Texts(met) = &report.column("met").unwrap().cells else { panic!() };
        assert!(met.iter().all(|met| met != "no"), "{met:?}");
        assert!(numbers(&report, "value")[..12].iter().all(|&value| value == 0.0 || value.is_nan()));
        assert!(numbers(&report, "halves")[0] > 0.0);
    }

    #[test]
    fn older_graphs_get_a_picture_that_can_be_read() {
        let lifted = |size| {
            let mut params = RawParams([("size".to_owned(), ParamValue::Integer(size))].into());
            Realism::upgrade(&mut params, 1).unwrap();
            params.0.remove("size")
        };
        assert_eq!(
            (lifted(240), lifted(700)),
            (Some(ParamValue::Integer(320)), Some(ParamValue::Integer(700)))
        );
    }
}
