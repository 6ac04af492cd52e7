//! Lines that the patches left flat are made to stand out.
//!
//! Zhou 2007 has no such step: where no candidate fits well, or seams and lifts took the crest away, a drawn line has a
//! gap. Where the ground does not fall on both sides of a line as far as it usually does in the exemplar, what is missing
//! is added along the line, falling off smoothly to both sides; from talwegs it is taken away.

use orograph_core::prelude::*;

use super::{
    canvas::Canvas,
    matching::height_at,
    network::{Chain, Network},
    patches::{ACROSS, fall},
    tps::Point,
};

/// Looks at the line: what one adds to a side takes away from the other.
const ROUNDS: usize = 3;
/// Most that is added in a round, as a multiple of what is wanted.
const MOST: f64 = 2.0;
/// Reach of what is added, in sixteenths of a patch: the ground that a line is compared with goes a little further.
const REACH: f64 = 2.8;

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Raised {
    /// Cells that moved.
    pub cells: usize,
    /// The farthest that one moved, in metres.
    pub most: f64,
}

/// Makes the lines of `network` stand out from both sides by what `wanted` says of a place, in metres, for patches of
/// `patch` cells. Given ground stays.
///
/// # Errors
/// Cancellation.
pub(super) fn raise(
    canvas: &mut Canvas,
    network: &Network,
    wanted: impl Fn(Point) -> f64,
    patch: usize,
    job: &Job<'_>,
) -> Result<Raised> {
    let unit = patch as f64 / 16.0;
    let sign = if network.kind == FeatureKind::Ridge { 1.0 } else { -1.0 };
    let lines: Vec<Vec<Station>> = network.chains.iter().map(stations).collect();
    let mut moved = vec![0.0_f64; canvas.heights.len()];
    for _ in 0..ROUNDS {
        let mut added = vec![0.0_f64; moved.len()];
        for stations in &lines {
            job.check()?;
            let lacks: Vec<f64> = stations
                .iter()
                .map(|station| {
                    let wanted = wanted(station.at);
                    station.lack(canvas, sign, unit, wanted).clamp(0.0, MOST * wanted.max(0.0))
                })
                .collect();
            for (station, lack) in stations.iter().zip(smooth(&lacks, unit)) {
                station.lift(lack, REACH * unit, canvas.size, &mut added);
            }
        }
        for (i, added) in added.iter().enumerate() {
            if *added > 0.0 && !canvas.heights[i].is_nan() && !canvas.is_frozen(i) {
                canvas.heights[i] = (f64::from(canvas.heights[i]) + sign * added) as f32;
                moved[i] += added;
            }
        }
    }
    let cells = moved.iter().filter(|&&moved| moved > 0.0).count();
    Ok(Raised { cells, most: moved.iter().copied().fold(0.0, f64::max) })
}

/// A place on a line and the unit vector along it.
struct Station {
    at: Point,
    along: Point,
}

/// Places about a cell apart.
fn stations(chain: &Chain) -> Vec<Station> {
    let length = chain.length();
    let n = length.ceil().max(1.0);
    (0..=n as usize)
        .map(|i| {
            let at = i as f64 / n * length;
            let (a, b) = (chain.position(at - 2.0), chain.position(at + 2.0));
            let apart = libm::hypot(b[0] - a[0], b[1] - a[1]).max(f64::MIN_POSITIVE);
            Station { at: chain.position(at), along: [(b[0] - a[0]) / apart, (b[1] - a[1]) / apart] }
        })
        .collect()
}

impl Station {
    /// How much more the place should stand out by: the ground is to fall by `wanted` on both sides, and no crest close
    /// beside the line is to overtop it. Nothing beside the border, where there is nothing to compare with.
    fn lack(&self, canvas: &Canvas, sign: f64, unit: f64, wanted: f64) -> f64 {
        let Some(heights) = self.across(canvas, sign, unit) else { return 0.0 };
        let crest = heights[3].max(heights[4]).max(heights[5]);
        let beside =
            [1, 2, 6, 7].map(|i| f64::from(heights[i])).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let overtopped = beside - f64::from(crest);
        (wanted - fall(|i| heights[i])).max(overtopped)
    }

    /// Heights across the line, each the mean of five cells along it; `None` beside the border.
    fn across(&self, canvas: &Canvas, sign: f64, unit: f64) -> Option<[f32; ACROSS.len()]> {
        let [down, across] = self.along;
        let mean = |i: usize| {
            let by = ACROSS[i] * unit;
            let at = |k: f64| [self.at[0] + k * down + by * across, self.at[1] + k * across - by * down];
            let sum: f32 = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| height_at(canvas, at(k))).iter().sum();
            sign as f32 * sum / 5.0
        };
        let heights: [f32; ACROSS.len()] = std::array::from_fn(mean);
        heights.iter().all(|height| !height.is_nan()).then_some(heights)
    }

    /// Notes `lack` at the place, and less of it around up to `reach` cells, where nothing more is noted.
    fn lift(&self, lack: f64, reach: f64, (rows, cols): (usize, usize), added: &mut [f64]) {
        if lack <= 0.0 {
            return;
        }
        let span = |at: f64, n: usize| {
            let (from, to) = ((at - reach).ceil().max(0.0), (at + reach).floor().min(n as f64 - 1.0));
            (from as usize)..(to as usize + 1)
        };
        for row in span(self.at[0], rows) {
            for col in span(self.at[1], cols) {
                let (down, across) = (row as f64 - self.at[0], col as f64 - self.at[1]);
                let near = (1.0 - (down * down + across * across) / (reach * reach)).max(0.0);
                let added = &mut added[row * cols + col];
                *added = added.max(lack * near * near);
            }
        }
    }
}

/// The largest lack around each station, then means: a gap is closed over its whole length and the ends run out.
fn smooth(lacks: &[f64], unit: f64) -> Vec<f64> {
    let reach = unit.ceil() as usize;
    let around = |i: usize| i.saturating_sub(reach)..(i + reach + 1).min(lacks.len());
    let largest: Vec<f64> =
        (0..lacks.len()).map(|i| lacks[around(i)].iter().copied().fold(0.0, f64::max)).collect();
    (0..lacks.len())
        .map(|i| {
            let near = &largest[around(i)];
            near.iter().sum::<f64>() / near.len() as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn canvas(height: impl Fn(usize, usize) -> f64) -> Canvas {
        let mut canvas = Canvas::new((120, 160), &Job::detached()).unwrap();
        canvas.lay(&field(120, 160, height));
        canvas
    }

    fn line(kind: FeatureKind) -> Network {
        let track = vec![[60.0, 20.0], [60.0, 140.0]];
        let chain = Chain { ends: [0, 1], track, along: vec![0.0, 120.0] };
        Network { kind, knots: Vec::new(), chains: vec![chain], rings: Vec::new() }
    }

    fn falls(canvas: &Canvas, network: &Network) -> Vec<f64> {
        let sign = if network.kind == FeatureKind::Ridge { 1.0 } else { -1.0 };
        let fall = |station: &Station| {
            station.across(canvas, sign, 5.0).map_or(f64::INFINITY, |heights| fall(|i| heights[i]))
        };
        stations(&network.chains[0]).iter().map(fall).collect()
    }

    #[test]
    fn a_line_stands_out_afterwards_on_flat_sloping_and_gapped_ground() {
        let grounds: [&dyn Fn(usize, usize) -> f64; 3] =
            [&|_, _| 100.0, &|row, _| 2.0 * row as f64, &|row, col| {
                if (60..90).contains(&col) { 50.0 } else { -4.0 * (row as f64 - 60.0).abs() }
            }];
        for ground in grounds {
            for kind in [FeatureKind::Ridge, FeatureKind::Valley] {
                let (mut canvas, network) = (canvas(ground), line(kind));
                raise(&mut canvas, &network, |_| 30.0, 80, &Job::detached()).unwrap();
                let least = falls(&canvas, &network).into_iter().fold(f64::INFINITY, f64::min);
                assert!(least > 25.0, "{kind:?}: {least}");
            }
        }
    }

    #[test]
    fn what_stands_out_already_and_what_is_far_stay_to_the_bit() {
        let (mut sharp, network) =
            (canvas(|row, _| -8.0 * (row as f64 - 60.0).abs()), line(FeatureKind::Ridge));
        let before = sharp.heights.clone();
        let raised = raise(&mut sharp, &network, |_| 30.0, 80, &Job::detached()).unwrap();
        assert_eq!((raised, &sharp.heights), (Raised::default(), &before));
        let mut flat = canvas(|_, _| 100.0);
        let raised = raise(&mut flat, &network, |_| 30.0, 80, &Job::detached()).unwrap();
        let far = |i: usize| (i / 160).abs_diff(60) > 14;
        assert!((0..flat.heights.len()).filter(|&i| far(i)).all(|i| flat.heights[i] == 100.0));
        assert!(raised.most >= 30.0 && raised.most < 60.0 && raised.cells > 0, "{raised:?}");
    }

    #[test]
    fn given_ground_stays() {
        let mut given = Canvas::new((120, 160), &Job::detached()).unwrap();
        given.freeze(&field(120, 160, |_, _| 7.0));
        raise(&mut given, &line(FeatureKind::Ridge), |_| 30.0, 80, &Job::detached()).unwrap();
        assert!(given.heights.iter().all(|&height| height == 7.0));
    }
}
