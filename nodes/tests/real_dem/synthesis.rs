//! Terrain from a drawn sign and real ridges: how well it follows the lines must not hang on how they were drawn, no ground
//! may show too often, seams must not show, and depressions must not be invented.

use std::path::Path;

use orograph_core::{Placement, prelude::*};
use orograph_nodes::{
    PatchSize,
    feature::{
        adherence::{Adherence, AdherenceIn},
        from_sketch::{FromSketch, FromSketchIn},
        ppa::{Ppa, PpaIn},
    },
    io::read_dem::ReadDem,
    measure::realism::{Realism, RealismIn},
    synthesis::{
        settings::Manner,
        synthesise::{Synthesise, SynthesiseIn},
    },
};

use crate::Check;

const EXEMPLAR: &str = "mount_jackson_n39w107_3as_1201.tif";
/// Share of the drawn lines that the terrain's own must follow within 5 cells.
const RECALL: f64 = 0.95;
/// Most of it that another width of the strokes or another size of the patches may cost.
const BY_STROKE: f64 = 0.03;
const BY_PATCH: f64 = 0.05;
/// Most times that ground is taken while there is other.
const MOST_USES: usize = 8;

pub(crate) fn checks() -> Vec<Check> {
    let check = |name: &str, run: fn(&Heightfield) -> Result<(), String>| {
        Check::new(format!("synthesis: {name}"), move |folder| run(&read(&folder.join(EXEMPLAR))?))
    };
    vec![
        check("strokes of 5 to 40 cells are followed alike", |exemplar| {
            let recalls = [5.0, 10.0, 20.0, 30.0, 40.0].map(|stroke| recall(exemplar, stroke, 80));
            alike(recalls, BY_STROKE)
        }),
        check("no ground serves more than eight times", |exemplar| {
            let made = made(exemplar, 1000, 24.0, 80).map_err(|error| error.to_string())?;
            let centers: Vec<[f64; 2]> =
                made.placement.patches.iter().map(|patch| patch.source_center).collect();
            // How often the ground within half a patch had served before.
            let served = |i: usize| {
                let [row, col] = centers[i];
                let near = |at: &&[f64; 2]| libm::hypot(at[0] - row, at[1] - col) <= 40.0;
                centers[..i].iter().filter(near).count()
            };
            let most = (0..centers.len()).map(served).max().unwrap_or(0);
            if centers.len() > 100 && most < MOST_USES { Ok(()) } else { Err(format!("{} times", most + 1)) }
        }),
        check("seams do not show and depressions are not invented", |exemplar| {
            let made = made(exemplar, 512, 12.0, 80).map_err(|error| error.to_string())?;
            real_enough(&made, exemplar)
        }),
        check("patches of 40 to 120 cells follow alike", |exemplar| {
            let recalls = [40, 60, 80, 100, 120].map(|patch| recall(exemplar, 12.0, patch));
            alike(recalls, BY_PATCH)
        }),
    ]
}

/// All at least what is wanted, less what the worst may lose, and no further apart than that.
fn alike(recalls: [Result<f64, String>; 5], most: f64) -> Result<(), String> {
    let recalls: Vec<f64> = recalls.into_iter().collect::<Result<_, _>>()?;
    let best = recalls.iter().copied().fold(0.0, f64::max);
    let worst = recalls.iter().copied().fold(1.0, f64::min);
    if best >= RECALL && best - worst <= most { Ok(()) } else { Err(format!("recalls of {recalls:.3?}")) }
}

/// Steps and bends at seams are within a quarter of those beside them, as logarithms, and depressions at most twice as dense
/// and as deep as the exemplar's.
fn real_enough(made: &Made, exemplar: &Heightfield) -> Result<(), String> {
    let inputs = RealismIn { terrain: &made.terrain, exemplar, placement: Some(&made.placement) };
    let report = Realism::default().run(inputs, &Job::detached()).map_err(|error| error.to_string())?.report;
    let column = |name: &str| report.column(name).map(|column| column.cells.clone());
    let (Some(Cells::Texts(metrics)), Some(Cells::Numbers(values))) = (column("metric"), column("value"))
    else {
        return Err("the report has other columns".into());
    };
    for (name, most) in
        [("seam_step", 0.25), ("seam_bend", 0.25), ("pit_density_ratio", 2.0), ("pit_depth_ratio", 2.0)]
    {
        let value = metrics.iter().position(|metric| metric == name).map_or(f64::NAN, |row| values[row]);
        if value.is_nan() || value.abs() > most {
            return Err(format!("{name} of {value:.3}"));
        }
    }
    Ok(())
}

fn read(file: &Path) -> Result<Heightfield, String> {
    let read = ReadDem { file: InputPath(file.display().to_string()), ..ReadDem::default() };
    Ok(read.run((), &Job::detached()).map_err(|error| error.to_string())?.terrain)
}

/// A half-life sign on `side` × `side` cells: a ring around a lambda, drawn `stroke` cells wide.
fn sign(side: u32, stroke: f64) -> Result<Heightfield, Error> {
    let unit = f64::from(side) / 512.0;
    let legs = [[[118.0, 179.0], [400.0, 338.0]], [[261.0, 256.0], [400.0, 179.0]]];
    let to_leg = |at: [f64; 2], [a, b]: [[f64; 2]; 2]| {
        let (d, f) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
        let t = ((d[0] * f[0] + d[1] * f[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        libm::hypot(f[0] - t * d[0], f[1] - t * d[1])
    };
    let cells = (0..side * side).map(|i| {
        let at = [i / side, i % side].map(|at| f64::from(at) / unit);
        let to_ring = (libm::hypot(at[0] - 256.0, at[1] - 256.0) - 200.0).abs();
        let off = legs.iter().fold(to_ring, |off, leg| off.min(to_leg(at, *leg)));
        f32::from(u8::from(off * unit <= stroke / 2.0))
    });
    Heightfield::new(Grid::new(side as usize, side as usize, CellSize::square(1.0))?, cells.collect())
}

/// A sign, and the terrain that was made from it.
struct Made {
    drawn: Features,
    terrain: Heightfield,
    placement: Placement,
}

fn made(exemplar: &Heightfield, side: u32, stroke: f64, patch: u32) -> Result<Made, Error> {
    let job = Job::detached();
    let patches = PatchSize { patch };
    let sketch = FromSketch { patches, ..FromSketch::default() };
    let drawn = sketch.run(FromSketchIn { sketch: &sign(side, stroke)? }, &job)?.features;
    let found = Ppa { patches, ..Ppa::default() }.run(PpaIn { terrain: exemplar }, &job)?.features;
    let manner = Manner { patches, ..Synthesise::default().manner };
    let inputs = SynthesiseIn {
        sketches: vec![&drawn],
        exemplars: vec![exemplar],
        features: vec![&found],
        styles: None,
        given: None,
        constraints: None,
    };
    let out = Synthesise { manner, ..Synthesise::default() }.run(inputs, &job)?;
    Ok(Made { drawn, terrain: out.terrain, placement: out.placement })
}

/// The share of the sign's lines that terrain made from it follows.
fn recall(exemplar: &Heightfield, stroke: f64, patch: u32) -> Result<f64, String> {
    let measured = || -> Result<f64, Error> {
        let Made { drawn, terrain, .. } = made(exemplar, 512, stroke, patch)?;
        let measure = Adherence { patches: PatchSize { patch }, ..Adherence::default() };
        let inputs = AdherenceIn { drawn: &drawn, terrain: &terrain, found: None };
        Ok(measure.run(inputs, &Job::detached())?.report.metric("recall").unwrap_or(f64::NAN))
    };
    measured().map_err(|error| format!("strokes of {stroke} cells, patches of {patch}: {error}"))
}
