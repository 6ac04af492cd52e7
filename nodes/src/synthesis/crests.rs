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
/// Distances across a line, in sixteenths of a patch, at which no ground is to rival it: up to where what looks for lines
/// in working cells would follow that ground instead.
const BESIDE: [f64; 5] = [0.8, 1.2, 1.6, 2.0, 2.4];
/// What such ground lies lower by at least, as a share of what the line is to stand out by.
const CLEAR: f64 = 0.15;

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
    let lines: Vec<Vec<Station>> =
        (0..network.chains.len()).map(|chain| stations(network, chain, REACH * unit, canvas.size)).collect();
    let on_lines = near(&lines, BESIDE[0] * unit, canvas.size);
    let mut moved = vec![0.0_f64; canvas.heights.len()];
    for _ in 0..ROUNDS {
        let mut added = vec![0.0_f64; moved.len()];
        for stations in &lines {
            job.check()?;
            let lacks: Vec<f64> = stations
                .iter()
                .map(|station| {
                    let wanted = wanted(station.at);
                    station.lack(canvas, sign, unit, wanted, &on_lines).clamp(0.0, MOST * wanted.max(0.0))
                })
                .collect();
            for (station, lack) in stations.iter().zip(smooth(&lacks, unit)) {
                station.lift(station.share * lack, REACH * unit, canvas.size, &mut added);
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
    /// Of what it lacks, what is added: less towards an end, where lines of real ground run out.
    share: f64,
}

/// Places about a cell apart. Towards ends of the line that are not ends of the ground, less and less is added over
/// `reach` cells.
fn stations(network: &Network, chain: usize, reach: f64, (rows, cols): (usize, usize)) -> Vec<Station> {
    let Chain { ends, .. } = network.chains[chain];
    let chain = &network.chains[chain];
    let inside = |at: f64, n: usize| at >= reach && at <= n as f64 - 1.0 - reach;
    let runs_out = ends.map(|end| {
        let is_ring = network.rings.iter().flatten().any(|&ring| ring == end);
        network.knots.get(end).is_some_and(|knot| {
            knot.chains.len() == 1 && !is_ring && inside(knot.at[0], rows) && inside(knot.at[1], cols)
        })
    });
    let length = chain.length();
    let n = length.ceil().max(1.0);
    (0..=n as usize)
        .map(|i| {
            let at = i as f64 / n * length;
            let (a, b) = (chain.position(at - 2.0), chain.position(at + 2.0));
            let apart = libm::hypot(b[0] - a[0], b[1] - a[1]).max(f64::MIN_POSITIVE);
            let to_end = [at, length - at];
            let share = (0..2)
                .filter(|&end| runs_out[end])
                .map(|end| 0.25 + 0.75 * to_end[end] / reach)
                .fold(1.0, f64::min);
            let along = [(b[0] - a[0]) / apart, (b[1] - a[1]) / apart];
            Station { at: chain.position(at), along, share }
        })
        .collect()
}

/// Cells within `reach` cells of a station.
fn near(lines: &[Vec<Station>], reach: f64, (rows, cols): (usize, usize)) -> Vec<bool> {
    let mut near = vec![false; rows * cols];
    for station in lines.iter().flatten() {
        for (row, col, square) in station.around(reach, (rows, cols)) {
            near[row * cols + col] |= square <= reach * reach;
        }
    }
    near
}

impl Station {
    /// How much more the place should stand out by: the ground is to fall by `wanted` on both sides, and nothing close
    /// beside the line, but for lines of the network, is to come near its height. Nothing where only one side is known.
    fn lack(&self, canvas: &Canvas, sign: f64, unit: f64, wanted: f64, lines: &[bool]) -> f64 {
        let heights: [f32; ACROSS.len()] =
            std::array::from_fn(|i| self.height(canvas, sign, ACROSS[i] * unit));
        let crest = heights[3].max(heights[4]).max(heights[5]);
        let known = |side: &[f32]| side.iter().any(|height| !height.is_nan());
        if crest.is_nan() || !known(&heights[..3]) || !known(&heights[6..]) {
            return 0.0;
        }
        let is_line = |[row, col]: Point| {
            let at = (row.round().max(0.0) as usize).min(canvas.size.0 - 1) * canvas.size.1;
            lines[at + (col.round().max(0.0) as usize).min(canvas.size.1 - 1)]
        };
        let beside = BESIDE
            .into_iter()
            .flat_map(|by| [-by * unit, by * unit])
            .filter(|&by| !is_line(self.beside(by)))
            // The maximum passes over what is not known.
            .fold(f64::NEG_INFINITY, |most, by| most.max(f64::from(self.height(canvas, sign, by))));
        (wanted - fall(|i| heights[i])).max(beside - f64::from(crest) + CLEAR * wanted)
    }

    /// The place `by` cells across the line.
    fn beside(&self, by: f64) -> Point {
        [self.at[0] + by * self.along[1], self.at[1] - by * self.along[0]]
    }

    /// The mean height of five cells along the line, `by` cells across it; of those that are known.
    fn height(&self, canvas: &Canvas, sign: f64, by: f64) -> f32 {
        let [row, col] = self.beside(by);
        let heights = [0.0, -1.0, 1.0, -2.0, 2.0]
            .map(|k| height_at(canvas, [row + k * self.along[0], col + k * self.along[1]]));
        let known = heights.into_iter().filter(|height| !height.is_nan());
        let (sum, n) = known.fold((0.0, 0.0), |(sum, n), height| (sum + height, n + 1.0));
        sign as f32 * sum / n
    }

    /// Notes `lack` at the place, and less of it around up to `reach` cells, where nothing more is noted.
    fn lift(&self, lack: f64, reach: f64, (rows, cols): (usize, usize), added: &mut [f64]) {
        if lack <= 0.0 {
            return;
        }
        for (row, col, square) in self.around(reach, (rows, cols)) {
            let near = (1.0 - square / (reach * reach)).max(0.0);
            let added = &mut added[row * cols + col];
            *added = added.max(lack * near * near);
        }
    }

    /// The cells of the square of twice `reach` around it, and the squares of their distances.
    fn around(
        &self,
        reach: f64,
        (rows, cols): (usize, usize),
    ) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        let span = |at: f64, n: usize| {
            let (from, to) = ((at - reach).ceil().max(0.0), (at + reach).floor().min(n as f64 - 1.0));
            (from as usize)..((to + 1.0).max(0.0) as usize)
        };
        let (at, columns) = (self.at, span(self.at[1], cols));
        span(at[0], rows).flat_map(move |row| {
            columns.clone().map(move |col| {
                let (down, across) = (row as f64 - at[0], col as f64 - at[1]);
                (row, col, down * down + across * across)
            })
        })
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
    use crate::{synthesis::network::Knot, test_fields::field};

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
        let fall = |station: &Station| fall(|i| station.height(canvas, sign, 5.0 * ACROSS[i]));
        stations(network, 0, 14.0, canvas.size).iter().map(fall).collect()
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
    fn a_line_overtops_what_runs_close_beside_it() {
        // A crest of 30 m along the line and a higher one six cells off, between the places that falls are taken at.
        let ground = |row: usize, _: usize| {
            let tent = |at: f64, top: f64| top - 3.0 * (row as f64 - at).abs();
            tent(60.0, 30.0).max(tent(66.5, 34.0)).max(-60.0)
        };
        let (mut canvas, network) = (canvas(ground), line(FeatureKind::Ridge));
        raise(&mut canvas, &network, |_| 30.0, 80, &Job::detached()).unwrap();
        for col in 25..135 {
            let column = |row: usize| canvas.heights[row * 160 + col];
            let highest = (46..75).max_by(|&a, &b| column(a).total_cmp(&column(b))).unwrap();
            assert!(highest.abs_diff(60) <= 2, "{col}: {highest}");
        }
    }

    #[test]
    fn a_line_stands_out_up_to_the_border_and_runs_out_where_it_ends() {
        let track = vec![[60.0, 0.0], [60.0, 100.0]];
        let chain = Chain { ends: [0, 1], track, along: vec![0.0, 100.0] };
        let knot = |at, starts| Knot { at, height: 0.0, chains: vec![(0, starts)] };
        let knots = vec![knot([60.0, 0.0], true), knot([60.0, 100.0], false)];
        let network = Network { kind: FeatureKind::Ridge, knots, chains: vec![chain], rings: Vec::new() };
        let mut canvas = canvas(|_, _| 100.0);
        raise(&mut canvas, &network, |_| 30.0, 80, &Job::detached()).unwrap();
        let above = |col: usize| canvas.heights[60 * 160 + col] - 100.0;
        assert!(above(0) > 25.0 && above(50) > 25.0, "{} {}", above(0), above(50));
        assert!(above(100) < above(95) && above(95) < above(88) && above(100) > 3.0);
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
