//! A feature network as synthesis walks it: chains by arc length, arms around a point, and the order of placement.
//!
//! Zhou 2007 §5.1: patches are placed breadth first from the most important branch, at every branch point and end and
//! every half patch along the lines between them. Departures: steps are spread evenly over a line; an arm that meets a
//! branch point before the patch's rim goes on along the line that turns least; a ring that was opened to make the
//! network a tree gets a patch at its gap.

use std::collections::VecDeque;

use libm::{atan2, hypot};
use orograph_core::{FeatureKind, Features};

use super::tps::Point;

/// A line of a network, by arc length.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The nodes that it joins.
    pub ends: [usize; 2],
    /// Its vertices, from the first to the second.
    pub track: Vec<Point>,
    /// Arc length at each vertex.
    pub along: Vec<f64>,
}

/// A branch point or end.
#[derive(Clone, Debug)]
pub struct Knot {
    /// Where it lies.
    pub at: Point,
    /// Height in metres.
    pub height: f32,
    /// Incident chains, and whether each starts here.
    pub chains: Vec<(usize, bool)>,
}

/// A network in the cells of one raster.
#[derive(Clone, Debug)]
pub struct Network {
    /// Crests or talwegs.
    pub kind: FeatureKind,
    /// Branch points and ends.
    pub knots: Vec<Knot>,
    /// Lines.
    pub chains: Vec<Chain>,
    /// Pairs of ends where a ring was opened.
    pub rings: Vec<[usize; 2]>,
}

/// A line from a patch's centre outwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// From the centre to the rim.
    pub track: Vec<Point>,
}

/// What a patch is placed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Three or more lines meet.
    Branch,
    /// A line ends.
    End,
    /// A stretch along a line.
    Path,
}

/// A place with the lines around it: in a sketch a patch to be placed, in an exemplar one to be taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// What is there.
    pub role: Role,
    /// Where.
    pub center: Point,
    /// The lines that leave it, by angle.
    pub arms: Vec<Arm>,
}

fn distance(a: Point, b: Point) -> f64 {
    hypot(a[0] - b[0], a[1] - b[1])
}

fn between(a: Point, b: Point, t: f64) -> Point {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

impl Arm {
    /// Where the arm first is `radius` away from its start; its end when it never is.
    #[must_use]
    pub fn crossing(&self, radius: f64) -> Point {
        let center = self.track[0];
        for pair in self.track.windows(2) {
            if distance(pair[1], center) >= radius {
                return circle_crossing(pair[0], pair[1], center, radius);
            }
        }
        self.track[self.track.len() - 1]
    }

    /// Where the arm ends.
    #[must_use]
    pub fn tip(&self) -> Point {
        self.track[self.track.len() - 1]
    }

    /// Angle of the tip around the centre.
    #[must_use]
    pub fn angle(&self) -> f64 {
        let (center, tip) = (self.track[0], self.tip());
        atan2(tip[0] - center[0], tip[1] - center[1])
    }
}

/// Where the segment from `a`, inside, to `b`, not inside, meets the circle.
fn circle_crossing(a: Point, b: Point, center: Point, radius: f64) -> Point {
    let (d, f) = ([b[0] - a[0], b[1] - a[1]], [a[0] - center[0], a[1] - center[1]]);
    let (aa, bb, cc) =
        (d[0] * d[0] + d[1] * d[1], f[0] * d[0] + f[1] * d[1], f[0] * f[0] + f[1] * f[1] - radius * radius);
    let root = (bb * bb - aa * cc).max(0.0).sqrt();
    let t = if aa > 0.0 { ((root - bb) / aa).clamp(0.0, 1.0) } else { 0.0 };
    between(a, b, t)
}

/// Most branch points that an arm passes.
const HOPS: usize = 3;

impl Network {
    /// The network of `features`, its rows and columns stretched by `scale` about the grid's corner.
    #[must_use]
    pub fn new(features: &Features, scale: [f64; 2]) -> Self {
        let map = |[row, col]: Point| [(row + 0.5) * scale[0] - 0.5, (col + 0.5) * scale[1] - 0.5];
        let usable = |line: &&orograph_core::Polyline| {
            line.vertices.len() > 1
                && (line.from as usize) < features.points.len()
                && (line.to as usize) < features.points.len()
                && line.vertices.iter().flatten().all(|x| x.is_finite())
        };
        let mut knots: Vec<Knot> = features
            .points
            .iter()
            .map(|point| Knot { at: map([point.row, point.col]), height: point.height, chains: Vec::new() })
            .collect();
        let mut chains = Vec::new();
        for line in features.lines.iter().filter(usable) {
            let track: Vec<Point> = line.vertices.iter().map(|&at| map(at)).collect();
            let mut along = vec![0.0];
            for pair in track.windows(2) {
                along.push(along[along.len() - 1] + distance(pair[0], pair[1]));
            }
            if along[along.len() - 1] <= 0.0 {
                continue;
            }
            let ends = [line.from as usize, line.to as usize];
            knots[ends[0]].chains.push((chains.len(), true));
            knots[ends[1]].chains.push((chains.len(), false));
            chains.push(Chain { ends, track, along });
        }
        let known = |pair: &&[u32; 2]| pair.iter().all(|&end| (end as usize) < knots.len());
        let rings = features.rings.iter().filter(known).map(|pair| pair.map(|end| end as usize)).collect();
        Self { kind: features.kind, knots, chains, rings }
    }

    /// Sum of the lengths of all chains.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.chains.iter().map(Chain::length).sum()
    }

    /// The arm that leaves `center`, on chain `chain` at arc length `at`, towards the chain's end or start.
    fn arm(&self, chain: usize, at: f64, forward: bool, radius: f64) -> Option<Arm> {
        let center = self.chains[chain].position(at);
        let mut track = vec![center];
        let (mut chain, mut at, mut forward) = (chain, at, forward);
        for _ in 0..=HOPS {
            let line = &self.chains[chain];
            let n = line.track.len();
            let ahead: Vec<usize> = if forward {
                (0..n).filter(|&i| line.along[i] > at).collect()
            } else {
                (0..n).rev().filter(|&i| line.along[i] < at).collect()
            };
            for i in ahead {
                let (from, to) = (track[track.len() - 1], line.track[i]);
                if distance(to, center) >= radius {
                    track.push(circle_crossing(from, to, center, radius));
                    return Some(Arm { track });
                }
                track.push(to);
            }
            let knot = line.ends[usize::from(forward)];
            let Some((next, starts)) = self.straightest(knot, chain, &track) else { break };
            (chain, forward) = (next, starts);
            at = if starts { 0.0 } else { self.chains[next].length() };
        }
        (track.len() > 1 && distance(track[track.len() - 1], center) >= radius / 2.0).then_some(Arm { track })
    }

    /// The chain at `knot`, other than `chain`, that goes on straightest from the end of `track`.
    fn straightest(&self, knot: usize, chain: usize, track: &[Point]) -> Option<(usize, bool)> {
        let last = track[track.len() - 1];
        let before = track.iter().rev().find(|&&at| distance(at, last) > 3.0).or(track.first())?;
        let heading = [last[0] - before[0], last[1] - before[1]];
        let mut best: Option<(f64, (usize, bool))> = None;
        for &(next, starts) in self.knots[knot].chains.iter().filter(|(next, _)| *next != chain) {
            let line = &self.chains[next];
            let reach = line.length().min(5.0);
            let ahead = line.position(if starts { reach } else { line.length() - reach });
            let way = [ahead[0] - last[0], ahead[1] - last[1]];
            let size = hypot(way[0], way[1]) * hypot(heading[0], heading[1]);
            let straight = if size > 0.0 { (way[0] * heading[0] + way[1] * heading[1]) / size } else { -1.0 };
            if best.is_none_or(|(most, _)| straight > most) {
                best = Some((straight, (next, starts)));
            }
        }
        best.map(|(_, next)| next)
    }

    /// The site of a branch point or end; `None` for one whose lines are too short to tell anything.
    #[must_use]
    pub fn knot_site(&self, knot: usize, radius: f64) -> Option<Site> {
        let Knot { at, chains, .. } = &self.knots[knot];
        let mut arms: Vec<Arm> = chains
            .iter()
            .filter_map(|&(chain, starts)| {
                let from = if starts { 0.0 } else { self.chains[chain].length() };
                self.arm(chain, from, starts, radius)
            })
            .map(|mut arm| {
                arm.track[0] = *at;
                arm
            })
            .collect();
        arms.sort_by(|a, b| a.angle().total_cmp(&b.angle()));
        let role = match arms.len() {
            0 => return None,
            1 => Role::End,
            2 => Role::Path,
            _ => Role::Branch,
        };
        Some(Site { role, center: *at, arms })
    }

    /// The site on a chain at an arc length; the first arm goes back, the second on.
    #[must_use]
    pub fn path_site(&self, chain: usize, at: f64, radius: f64) -> Option<Site> {
        let arms = [self.arm(chain, at, false, radius)?, self.arm(chain, at, true, radius)?];
        Some(Site { role: Role::Path, center: self.chains[chain].position(at), arms: arms.into() })
    }

    /// The sites to place, in the order of placement.
    #[must_use]
    pub fn plan(&self, patch: f64) -> Vec<Site> {
        let radius = (patch - 1.0) / 2.0;
        let mut visited = vec![false; self.knots.len()];
        let mut out = Vec::new();
        for component in self.components() {
            let Some(root) = self.root(&component) else { continue };
            visited[root] = true;
            out.extend(self.knot_site(root, radius));
            let mut queue = VecDeque::from([root]);
            while let Some(knot) = queue.pop_front() {
                let mut chains = self.knots[knot].chains.clone();
                chains.sort_by(|a, b| self.departure(knot, *a).total_cmp(&self.departure(knot, *b)));
                for (chain, starts) in chains {
                    let line = &self.chains[chain];
                    let far = line.ends[usize::from(starts)];
                    if visited[far] {
                        continue;
                    }
                    visited[far] = true;
                    let length = line.length();
                    let n = (length / (patch / 2.0)).ceil().max(1.0) as usize;
                    for step in 1..n {
                        let share = step as f64 / n as f64;
                        let at = if starts { share * length } else { (1.0 - share) * length };
                        out.extend(self.path_site(chain, at, radius));
                    }
                    out.extend(self.knot_site(far, radius));
                    queue.push_back(far);
                }
            }
            out.extend(
                self.rings
                    .iter()
                    .filter(|ring| component.contains(&ring[0]))
                    .filter_map(|ring| self.ring_site(*ring, radius)),
            );
        }
        out
    }

    /// Angle at which a chain leaves a knot.
    fn departure(&self, knot: usize, (chain, starts): (usize, bool)) -> f64 {
        let line = &self.chains[chain];
        let reach = line.length().min(10.0);
        let ahead = line.position(if starts { reach } else { line.length() - reach });
        let at = self.knots[knot].at;
        atan2(ahead[0] - at[0], ahead[1] - at[1])
    }

    /// The gap of a ring: its ends' arms, both from the middle of the gap.
    fn ring_site(&self, ring: [usize; 2], radius: f64) -> Option<Site> {
        let [a, b] = ring.map(|end| self.knots[end].at);
        let center = between(a, b, 0.5);
        let mut arms = Vec::new();
        for end in ring {
            let &(chain, starts) = self.knots[end].chains.first()?;
            let from = if starts { 0.0 } else { self.chains[chain].length() };
            let mut arm = self.arm(chain, from, starts, radius)?;
            arm.track.insert(0, center);
            arms.push(arm);
        }
        Some(Site { role: Role::Path, center, arms })
    }

    /// Knots of each connected part that has a chain, the most important part first.
    fn components(&self) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.knots.len()];
        let mut parts = Vec::new();
        for first in 0..self.knots.len() {
            if seen[first] || self.knots[first].chains.is_empty() {
                continue;
            }
            seen[first] = true;
            let (mut part, mut next) = (vec![first], 0);
            while next < part.len() {
                for &(chain, starts) in &self.knots[part[next]].chains {
                    let far = self.chains[chain].ends[usize::from(starts)];
                    if !seen[far] {
                        seen[far] = true;
                        part.push(far);
                    }
                }
                next += 1;
            }
            parts.push(part);
        }
        let weight = |part: &Vec<usize>| {
            let branches = part.iter().filter(|&&knot| self.knots[knot].chains.len() > 2).count();
            let length: f64 = part.iter().map(|&knot| self.around(knot)).sum();
            (branches, length)
        };
        // Sorting is stable, so equal parts stay in the order of their first knots.
        parts.sort_by(|a, b| {
            let ((branches_a, length_a), (branches_b, length_b)) = (weight(a), weight(b));
            branches_b.cmp(&branches_a).then(length_b.total_cmp(&length_a))
        });
        parts
    }

    /// Sum of the lengths of a knot's chains.
    fn around(&self, knot: usize) -> f64 {
        self.knots[knot].chains.iter().map(|&(chain, _)| self.chains[chain].length()).sum()
    }

    fn root(&self, part: &[usize]) -> Option<usize> {
        let branches = part.iter().copied().filter(|&knot| self.knots[knot].chains.len() > 2);
        let degree = |knot: usize| self.knots[knot].chains.len();
        let place = |knot: usize| self.knots[knot].at;
        let best = branches.min_by(|&a, &b| {
            let (at_a, at_b) = (place(a), place(b));
            degree(b)
                .cmp(&degree(a))
                .then(self.around(b).total_cmp(&self.around(a)))
                .then(at_a[0].total_cmp(&at_b[0]))
                .then(at_a[1].total_cmp(&at_b[1]))
        });
        let crest = |knot: usize| match self.kind {
            FeatureKind::Ridge => self.knots[knot].height,
            FeatureKind::Valley => -self.knots[knot].height,
        };
        best.or_else(|| part.iter().copied().min_by(|&a, &b| crest(b).total_cmp(&crest(a)).then(a.cmp(&b))))
    }
}

impl Chain {
    /// Its length in cells.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.along[self.along.len() - 1]
    }

    /// The point at an arc length.
    #[must_use]
    pub fn position(&self, at: f64) -> Point {
        let next = self.along.partition_point(|&along| along < at).clamp(1, self.track.len() - 1);
        let (from, to) = (self.along[next - 1], self.along[next]);
        let t = if to > from { ((at - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        between(self.track[next - 1], self.track[next], t)
    }
}
