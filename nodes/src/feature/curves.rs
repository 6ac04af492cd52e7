//! Curves as a mesh: vertices snapped together, edges split where they meet, loops opened.

use std::collections::VecDeque;

use orograph_core::prelude::*;
use petgraph::unionfind::UnionFind;

use super::{
    chains::distance,
    network::{between, unit},
};

/// Vertices and the straight edges between them.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    /// Row, column and height of each vertex.
    pub(crate) places: Vec<[f64; 3]>,
    /// Pairs of vertices, the lower number first, each once, in the order in which they were drawn.
    edges: Vec<[usize; 2]>,
}

/// Most vertices that are compared with each other.
const MOST: usize = 20_000;
/// Most edges after they were cut to cells.
const MOST_CELLS: f64 = 1e7;

impl Mesh {
    /// The mesh of some curves of (row, column, height).
    ///
    /// # Errors
    /// [`Error::Invalid`] for places that are no numbers, and for too many; [`Error::Cancelled`].
    pub(crate) fn new(curves: &[Vec<[f64; 3]>], snap: f64, job: &Job) -> Result<Self> {
        if curves.iter().flatten().flatten().any(|at| !at.is_finite()) {
            return Err(Error::invalid("a curve has a place that is no number", "give finite coordinates"));
        }
        let n: usize = curves.iter().map(Vec::len).sum();
        if n > MOST {
            return Err(Error::invalid(
                format!(
                    "the curves have {n} vertices, more than the {MOST} that are compared with each other"
                ),
                "simplify the curves",
            ));
        }
        let mut mesh = Self { places: Vec::new(), edges: Vec::new() };
        let mut drawn: Vec<[usize; 2]> = Vec::new();
        for curve in curves {
            job.check()?;
            let vertices: Vec<usize> = curve.iter().map(|&place| mesh.vertex(place, snap)).collect();
            drawn
                .extend(vertices.windows(2).filter(|pair| pair[0] != pair[1]).map(|pair| [pair[0], pair[1]]));
        }
        for (i, &a) in drawn.iter().enumerate() {
            job.check()?;
            for &b in &drawn[..i] {
                if let Some(place) = mesh.crossing(a, b) {
                    mesh.vertex(place, snap);
                }
            }
        }
        for &[from, to] in &drawn {
            job.check()?;
            let stops = mesh.stops(from, to, snap);
            for pair in stops.windows(2) {
                mesh.edges.push([pair[0].min(pair[1]), pair[0].max(pair[1])]);
            }
        }
        let mut order: Vec<usize> = (0..mesh.edges.len()).collect();
        order.sort_by_key(|&i| (mesh.edges[i], i));
        order.dedup_by_key(|i| mesh.edges[*i]);
        order.sort_unstable();
        mesh.edges = order.into_iter().map(|i| mesh.edges[i]).collect();
        Ok(mesh)
    }

    fn at(&self, vertex: usize) -> [f64; 2] {
        [self.places[vertex][0], self.places[vertex][1]]
    }

    /// The first vertex nearer than `snap`, or a new one.
    fn vertex(&mut self, place: [f64; 3], snap: f64) -> usize {
        let at = [place[0], place[1]];
        let near = |&vertex: &usize| {
            let far = distance(self.at(vertex), at);
            far < snap || far == 0.0
        };
        if let Some(vertex) = (0..self.places.len()).find(near) {
            return vertex;
        }
        self.places.push(place);
        self.places.len() - 1
    }

    /// Where two edges without a common vertex cross.
    fn crossing(&self, [a, b]: [usize; 2], [c, d]: [usize; 2]) -> Option<[f64; 3]> {
        if [c, d].contains(&a) || [c, d].contains(&b) {
            return None;
        }
        let (p, q) = (self.at(a), self.at(c));
        let along = |from: usize, to: usize| [0, 1].map(|k| self.places[to][k] - self.places[from][k]);
        let (r, s) = (along(a, b), along(c, d));
        let cross = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
        let area = cross(r, s);
        let gap = [q[0] - p[0], q[1] - p[1]];
        let (t, u) = (cross(gap, s) / area, cross(gap, r) / area);
        // Parallel edges divide by zero, and neither NaN nor infinity lies between 0 and 1.
        let inside = (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u);
        let height = self.places[a][2] + (self.places[b][2] - self.places[a][2]) * t;
        inside.then(|| [p[0] + t * r[0], p[1] + t * r[1], height])
    }

    /// The vertices on an edge, both ends included, in order.
    fn stops(&self, from: usize, to: usize, snap: f64) -> Vec<usize> {
        let (a, b) = (self.at(from), self.at(to));
        let length = distance(a, b);
        let Some(along) = unit(a, b) else { return vec![from] };
        let mut stops: Vec<(f64, usize)> = vec![(0.0, from), (length, to)];
        for vertex in (0..self.places.len()).filter(|&vertex| vertex != from && vertex != to) {
            let at = self.at(vertex);
            let t = (at[0] - a[0]) * along[0] + (at[1] - a[1]) * along[1];
            let on = between(a, b, t / length);
            // A crossing's own vertex may lie off by a rounding.
            if t > 0.0 && t < length && distance(on, at) < snap.max(1e-9) {
                stops.push((t, vertex));
            }
        }
        stops.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        stops.into_iter().map(|stop| stop.1).collect()
    }

    /// Cuts edges into equal pieces no longer than about `step`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there would be too many; [`Error::Cancelled`].
    pub(crate) fn densify(&mut self, step: f64, job: &Job) -> Result<()> {
        let whole: f64 = self.edges.iter().map(|edge| distance(self.at(edge[0]), self.at(edge[1]))).sum();
        if whole / step > MOST_CELLS {
            return Err(Error::invalid(
                format!("the curves are {whole:.0} cells long together"),
                "keep them near the grid: check `coordinates`",
            ));
        }
        let mut pieces = Vec::new();
        for &[from, to] in &self.edges {
            job.check()?;
            let n = (distance(self.at(from), self.at(to)) / step).ceil().max(1.0) as usize;
            let (a, b) = (self.places[from], self.places[to]);
            let mut last = from;
            for i in 1..n {
                let share = i as f64 / n as f64;
                self.places.push([0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share));
                pieces.push([last, self.places.len() - 1]);
                last = self.places.len() - 1;
            }
            pieces.push([last, to]);
        }
        self.edges = pieces;
        Ok(())
    }

    /// How many edges meet at each vertex.
    pub(crate) fn degrees(&self) -> Vec<usize> {
        let mut degrees = vec![0; self.places.len()];
        self.edges.iter().flatten().for_each(|&vertex| degrees[vertex] += 1);
        degrees
    }

    /// For each vertex the edges that meet there.
    fn meeting(&self) -> Vec<Vec<usize>> {
        let mut meeting = vec![Vec::new(); self.places.len()];
        for (i, edge) in self.edges.iter().enumerate() {
            edge.iter().for_each(|&vertex| meeting[vertex].push(i));
        }
        meeting
    }

    /// Takes away the least important edge of every loop: the lowest for ridges, the highest for valleys; of equals
    /// the furthest from junctions and ends, and the last drawn.
    pub(crate) fn break_loops(&mut self, ridge: bool) {
        let meeting = self.meeting();
        let mut hops = vec![usize::MAX; self.places.len()];
        let mut queue = VecDeque::new();
        for (vertex, edges) in meeting.iter().enumerate().filter(|(_, edges)| edges.len() != 2) {
            hops[vertex] = 0;
            if !edges.is_empty() {
                queue.push_back(vertex);
            }
        }
        while let Some(vertex) = queue.pop_front() {
            for &edge in &meeting[vertex] {
                let other = self.other(edge, vertex);
                if hops[other] == usize::MAX {
                    hops[other] = hops[vertex] + 1;
                    queue.push_back(other);
                }
            }
        }
        let importance = |edge: [usize; 2]| {
            let sum = self.places[edge[0]][2] + self.places[edge[1]][2];
            if ridge { sum } else { -sum }
        };
        let far = |edge: [usize; 2]| hops[edge[0]].saturating_add(hops[edge[1]]);
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        order.sort_by(|&a, &b| {
            let (x, y) = (self.edges[a], self.edges[b]);
            importance(y).total_cmp(&importance(x)).then(far(x).cmp(&far(y))).then(a.cmp(&b))
        });
        let mut trees = UnionFind::new(self.places.len());
        let mut kept = Vec::with_capacity(self.edges.len());
        for i in order {
            let [a, b] = self.edges[i];
            if trees.union(a, b) {
                kept.push(i);
            }
        }
        kept.sort_unstable();
        self.edges = kept.into_iter().map(|i| self.edges[i]).collect();
    }

    fn other(&self, edge: usize, vertex: usize) -> usize {
        let [a, b] = self.edges[edge];
        if a == vertex { b } else { a }
    }

    /// Runs of vertices between those that are no mere passage, each once.
    pub(crate) fn chains(&self) -> Vec<Vec<usize>> {
        let meeting = self.meeting();
        let mut gone = vec![false; self.edges.len()];
        let mut chains = Vec::new();
        for start in (0..meeting.len()).filter(|&vertex| meeting[vertex].len() != 2) {
            for &first in &meeting[start] {
                let mut chain = vec![start];
                let mut edge = Some(first).filter(|&first| !gone[first]);
                while let Some(next) = edge {
                    gone[next] = true;
                    let vertex = self.other(next, chain[chain.len() - 1]);
                    chain.push(vertex);
                    let onward = meeting[vertex].iter().copied().find(|&other| !gone[other]);
                    edge = onward.filter(|_| meeting[vertex].len() == 2);
                }
                if chain.len() > 1 {
                    chains.push(chain);
                }
            }
        }
        chains
    }
}
