//! Features as a graph: what meets where, how long lines are, and the arms of a place.

use orograph_core::prelude::*;

use super::chains::distance;

/// A line seen from one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incidence {
    /// Index of the line.
    pub line: usize,
    /// Whether the line starts at the point at hand, and not ends there.
    pub starts: bool,
}

/// Where a line that leaves a place crosses the circle about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// The crossing, as (row, column): the control point of a warp. Where the line ends first it is that end, or the
    /// place on the circle that lies in the end's direction.
    pub position: [f64; 2],
    /// The place half the radius along the line, where a new patch joins one already placed.
    pub joint: [f64; 2],
    /// Unit vector (rows, columns) along the line at the joint, outward.
    pub tangent: [f64; 2],
    /// Index of the line by which the arm leaves.
    pub line: usize,
    /// Whether the line reaches the circle.
    pub whole: bool,
    /// Angle of [`position`](Self::position) about the place, from 0 below 2π, growing from east over south.
    pub angle: f64,
}

/// Features with the lines that meet at each point.
#[derive(Clone, Debug)]
pub struct Network<'a> {
    features: &'a Features,
    incidences: Vec<Vec<Incidence>>,
    /// For each line the length up to each vertex.
    lengths: Vec<Vec<f64>>,
    /// For each point the end that closes a ring with it.
    partners: Vec<Option<usize>>,
}

/// Points that an arm passes at most before it must have reached its circle.
const MOST_HOPS: usize = 3;

impl<'a> Network<'a> {
    /// The graph of some features.
    ///
    /// # Errors
    /// [`Error::Invalid`] for lines or rings between points that are not there, lines of less than two vertices, and
    /// places that are no numbers.
    pub fn new(features: &'a Features) -> Result<Self> {
        let n = features.points.len();
        let wrong = |what: &str| {
            Error::invalid(
                format!("the features are damaged: {what}"),
                "make them with a node of the `feature` family",
            )
        };
        let finite = |place: &[f64; 2]| place.iter().all(|at| at.is_finite());
        if !features.points.iter().all(|point| finite(&[point.row, point.col])) {
            return Err(wrong("a point lies nowhere"));
        }
        let mut incidences = vec![Vec::new(); n];
        let mut lengths = Vec::with_capacity(features.lines.len());
        for (i, line) in features.lines.iter().enumerate() {
            if line.vertices.len() < 2 || !line.vertices.iter().all(finite) {
                return Err(wrong("a line has less than two vertices, or some that lie nowhere"));
            }
            for (point, starts) in [(line.from, true), (line.to, false)] {
                let at = incidences.get_mut(point as usize);
                at.ok_or_else(|| wrong("a line ends at no point"))?.push(Incidence { line: i, starts });
            }
            let mut length = 0.0;
            let mut so_far = Vec::with_capacity(line.vertices.len());
            so_far.push(0.0);
            for pair in line.vertices.windows(2) {
                length += distance(pair[0], pair[1]);
                so_far.push(length);
            }
            lengths.push(so_far);
        }
        let mut partners = vec![None; n];
        for &[a, b] in &features.rings {
            let (a, b) = (a as usize, b as usize);
            if a >= n || b >= n {
                return Err(wrong("a ring closes at no point"));
            }
            (partners[a], partners[b]) = (Some(b), Some(a));
        }
        Ok(Self { features, incidences, lengths, partners })
    }

    /// The features themselves.
    #[must_use]
    pub fn features(&self) -> &'a Features {
        self.features
    }

    /// The lines that meet at a point, by index; a line that starts and ends there comes twice.
    ///
    /// # Panics
    /// Beyond the last point, as slices do.
    #[must_use]
    pub fn incidences(&self, point: usize) -> &[Incidence] {
        &self.incidences[point]
    }

    /// The point at the other end of a line.
    #[must_use]
    pub fn far(&self, incidence: Incidence) -> usize {
        let line = &self.features.lines[incidence.line];
        (if incidence.starts { line.to } else { line.from }) as usize
    }

    /// The end that closes a ring with this one.
    #[must_use]
    pub fn partner(&self, point: usize) -> Option<usize> {
        self.partners[point]
    }

    /// Row and column of a point.
    #[must_use]
    pub fn place(&self, point: usize) -> [f64; 2] {
        let point = &self.features.points[point];
        [point.row, point.col]
    }

    /// Length of a line in cells.
    #[must_use]
    pub fn length(&self, line: usize) -> f64 {
        self.lengths[line].last().copied().unwrap_or(0.0)
    }

    /// The place at a length along a line, held between its ends.
    #[must_use]
    pub fn at(&self, line: usize, length: f64) -> [f64; 2] {
        let (vertices, lengths) = (&self.features.lines[line].vertices, &self.lengths[line]);
        let after = lengths.partition_point(|&so_far| so_far < length).clamp(1, vertices.len() - 1);
        let (start, end) = (lengths[after - 1], lengths[after]);
        let share = if end > start { ((length - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        between(vertices[after - 1], vertices[after], share)
    }

    /// The arms of a point within a radius, by ascending angle. A line that comes to another point before it
    /// reaches the circle goes on along the line that turns least there, or across the gap of a ring. One that ends
    /// nearer than half the radius gives no arm, unless it is the only one.
    #[must_use]
    pub fn arms(&self, point: usize, radius: f64) -> Vec<Arm> {
        let centre = self.place(point);
        let mut reached: Vec<Reach> = Vec::new();
        for &incidence in &self.incidences[point] {
            let start = if incidence.starts { 0.0 } else { self.length(incidence.line) };
            reached.push(self.walk(centre, incidence, start, radius));
        }
        if let Some(partner) = self.partners[point] {
            reached.extend(self.cross_gap(centre, partner, radius));
        }
        let only = reached.len() == 1;
        let long = |reach: &Reach| only || reach.whole || distance(centre, reach.end) >= radius / 2.0;
        let mut arms: Vec<Arm> =
            reached.into_iter().filter(long).filter_map(|reach| arm(centre, reach, radius)).collect();
        arms.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.line.cmp(&b.line)));
        arms
    }

    /// The two arms of the place at a length along a line: towards the line's start, towards its end. A line that
    /// ends too near gives an arm in the end's direction.
    #[must_use]
    pub fn arms_along(&self, line: usize, length: f64, radius: f64) -> Vec<Arm> {
        let centre = self.at(line, length);
        [false, true]
            .into_iter()
            .filter_map(|starts| {
                arm(centre, self.walk(centre, Incidence { line, starts }, length, radius), radius)
            })
            .collect()
    }

    /// Middle of a ring's gap and its two arms, by the ring's index.
    #[must_use]
    pub fn arms_of_ring(&self, ring: usize, radius: f64) -> ([f64; 2], Vec<Arm>) {
        let ends = self.features.rings[ring].map(|point| point as usize);
        let centre = between(self.place(ends[0]), self.place(ends[1]), 0.5);
        let arms = ends.iter().filter_map(|&end| arm(centre, self.cross_gap(centre, end, radius)?, radius));
        (centre, arms.collect())
    }

    /// From a place in a ring's gap over one of its ends and along the line there.
    fn cross_gap(&self, centre: [f64; 2], end: usize, radius: f64) -> Option<Reach> {
        let &incidence = self.incidences[end].first()?;
        let start = if incidence.starts { 0.0 } else { self.length(incidence.line) };
        Some(self.walk(centre, incidence, start, radius))
    }

    /// Follows a line from a length along it, forward if it `starts` there, until the circle about `centre`.
    fn walk(&self, centre: [f64; 2], incidence: Incidence, from: f64, radius: f64) -> Reach {
        let mut trail = Trail::new(centre, radius);
        let (mut incidence, mut from) = (incidence, from);
        let line = incidence.line;
        for hop in 0..=MOST_HOPS {
            if self.follow(incidence, from, &mut trail) {
                break;
            }
            let point = self.far(incidence);
            let next = if hop < MOST_HOPS { self.onward(point, incidence, radius) } else { None };
            let Some(next) = next else { break };
            incidence = next;
            from = if next.starts { 0.0 } else { self.length(next.line) };
        }
        Reach { end: trail.at, whole: trail.crossed, joint: trail.joint, tangent: trail.tangent, line }
    }

    /// Extends the trail to the line's far end; true once the circle is crossed.
    fn follow(&self, Incidence { line, starts }: Incidence, from: f64, trail: &mut Trail) -> bool {
        let (vertices, lengths) = (&self.features.lines[line].vertices, &self.lengths[line]);
        if trail.to(self.at(line, from)) {
            return true;
        }
        if starts {
            let first = lengths.partition_point(|&length| length <= from);
            vertices[first.min(vertices.len())..].iter().any(|&vertex| trail.to(vertex))
        } else {
            let after = lengths.partition_point(|&length| length < from);
            vertices[..after].iter().rev().any(|&vertex| trail.to(vertex))
        }
    }

    /// The line by which a walk that arrives at a point goes on.
    fn onward(&self, point: usize, arrived: Incidence, radius: f64) -> Option<Incidence> {
        let back = Incidence { starts: !arrived.starts, ..arrived };
        let come = self.direction(back, radius);
        let straightness = |incidence: &Incidence| {
            let go = self.direction(*incidence, radius);
            -(come[0] * go[0] + come[1] * go[1])
        };
        let others = self.incidences[point].iter().filter(|&&incidence| incidence != back);
        let straight =
            others.max_by(|a, b| straightness(a).total_cmp(&straightness(b)).then(b.line.cmp(&a.line)));
        straight.or_else(|| self.incidences[self.partners[point]?].first()).copied()
    }

    /// Unit vector in which a line leaves its end, over a quarter of the radius.
    fn direction(&self, Incidence { line, starts }: Incidence, radius: f64) -> [f64; 2] {
        let length = self.length(line);
        let reach = (radius / 4.0).min(length);
        let (a, b) = if starts { (0.0, reach) } else { (length, length - reach) };
        unit(self.at(line, a), self.at(line, b)).unwrap_or_default()
    }
}

/// Where a walk came to.
struct Reach {
    end: [f64; 2],
    whole: bool,
    joint: Option<[f64; 2]>,
    tangent: [f64; 2],
    line: usize,
}

/// The arm that a walk gives; none where it did not leave its centre.
fn arm(centre: [f64; 2], reach: Reach, radius: f64) -> Option<Arm> {
    let towards = unit(centre, reach.end)?;
    let long = reach.whole || distance(centre, reach.end) >= radius / 2.0;
    let position = if long { reach.end } else { [0, 1].map(|k| centre[k] + radius * towards[k]) };
    let angle = libm::atan2(position[0] - centre[0], position[1] - centre[1]);
    let angle = if angle < 0.0 { angle + std::f64::consts::TAU } else { angle };
    Some(Arm {
        position,
        joint: reach.joint.unwrap_or(reach.end),
        tangent: if reach.tangent == [0.0, 0.0] { towards } else { reach.tangent },
        line: reach.line,
        whole: reach.whole,
        // Adding a full turn to a tiny negative angle gives the full turn itself.
        angle: if angle >= std::f64::consts::TAU { 0.0 } else { angle },
    })
}

/// A walk in progress: where it is and what it passed.
struct Trail {
    centre: [f64; 2],
    radius: f64,
    at: [f64; 2],
    length: f64,
    crossed: bool,
    joint: Option<[f64; 2]>,
    tangent: [f64; 2],
}

impl Trail {
    fn new(centre: [f64; 2], radius: f64) -> Self {
        Self { centre, radius, at: centre, length: 0.0, crossed: false, joint: None, tangent: [0.0; 2] }
    }

    /// Goes straight to a place, or to the circle where that comes first; true once the circle is crossed.
    fn to(&mut self, next: [f64; 2]) -> bool {
        let crossing = self.crossing(next);
        let end = crossing.unwrap_or(next);
        let step = distance(self.at, end);
        if step > 0.0 && self.joint.is_none() {
            self.tangent = unit(self.at, end).unwrap_or(self.tangent);
            let wanted = self.radius / 2.0;
            if self.length + step >= wanted {
                self.joint = Some(between(self.at, end, (wanted - self.length) / step));
            }
        }
        self.length += step;
        self.at = end;
        self.crossed = crossing.is_some();
        self.crossed
    }

    /// Where the way to `next` leaves the circle, if it does.
    fn crossing(&self, next: [f64; 2]) -> Option<[f64; 2]> {
        if distance(self.centre, next) < self.radius {
            return None;
        }
        let from = [0, 1].map(|k| self.at[k] - self.centre[k]);
        let along = [0, 1].map(|k| next[k] - self.at[k]);
        let square = along[0] * along[0] + along[1] * along[1];
        if square == 0.0 {
            return Some(next);
        }
        let half = from[0] * along[0] + from[1] * along[1];
        let inside = self.radius * self.radius - from[0] * from[0] - from[1] * from[1];
        let share = ((half * half + square * inside).max(0.0).sqrt() - half) / square;
        Some(between(self.at, next, share.clamp(0.0, 1.0)))
    }
}

/// The place a share of the way from one to another.
pub(crate) fn between(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| a[k] + (b[k] - a[k]) * share)
}

/// Unit vector from one place to another, where they differ.
pub(crate) fn unit(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let far = distance(a, b);
    (far > 0.0).then(|| [0, 1].map(|k| (b[k] - a[k]) / far))
}
