//! Ridges and valleys as lines that lie on the ground; what ground hides is not drawn.

use eframe::egui::{Color32, Mesh, Pos2, Rect, Vec2};
use glam::Vec3;
use orograph_core::{FeatureKind, Features};

use super::{
    camera::{Camera, Stand},
    relief::Relief,
};

/// Colours of ridges and of valleys, told apart from ground in any light.
const RIDGE: Color32 = Color32::from_rgb(0xff, 0x5a, 0x3c);
const VALLEY: Color32 = Color32::from_rgb(0x3c, 0x96, 0xff);

/// Lines are cut into no more pieces than this.
const MOST: usize = 40_000;

/// How far above the ground lines run, so that it does not hide them.
const ABOVE: f32 = 0.006;

/// Lines on terrain, as x and y.
pub(super) struct Lines {
    lines: Vec<Vec<[f32; 2]>>,
    color: Color32,
}

impl Lines {
    /// The lines of features on the net of the terrain that they lie on.
    pub(super) fn new(features: &Features, relief: &Relief) -> Self {
        let color = if features.kind == FeatureKind::Ridge { RIDGE } else { VALLEY };
        let placed: Vec<Vec<[f32; 2]>> = features
            .lines
            .iter()
            .map(|line| line.vertices.iter().map(|place| relief.locate(*place)).collect())
            .collect();
        let length: f32 =
            placed.iter().flat_map(|line| line.windows(2)).map(|pair| far(pair[0], pair[1])).sum();
        // Pieces as long as an interval of the net, so that they follow the ground.
        let interval = 2.0 / (relief.rows().max(relief.cols()) - 1) as f32;
        let piece = interval.max(length / MOST as f32);
        Self { lines: placed.iter().map(|line| cut(line, piece)).collect(), color }
    }

    /// The lines as they are seen.
    pub(super) fn mesh(&self, relief: &Relief, stand: &Stand, rect: Rect) -> Mesh {
        let exaggeration = stand.exaggeration;
        let camera = Camera::new(stand, rect, relief.bounds(exaggeration));
        let mut mesh = Mesh::default();
        for line in &self.lines {
            let mut before: Option<Pos2> = None;
            for [x, y] in line {
                let z = relief.height(*x, *y, exaggeration);
                let place = z.map(|z| Vec3::new(*x, *y, z + ABOVE));
                let seen = place.filter(|place| relief.is_seen(*place, camera.eye, exaggeration));
                let at = seen.map(|place| camera.place(place));
                if let (Some(from), Some(to)) = (before, at) {
                    stroke(&mut mesh, from, to, self.color);
                }
                before = at;
            }
        }
        mesh
    }
}

fn far(a: [f32; 2], b: [f32; 2]) -> f32 {
    Vec2::new(b[0] - a[0], b[1] - a[1]).length()
}

/// The line with so many vertices more that none is further than `piece` from the next.
fn cut(line: &[[f32; 2]], piece: f32) -> Vec<[f32; 2]> {
    let mut vertices: Vec<[f32; 2]> = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let pieces = (far(a, b) / piece).ceil().clamp(1.0, MOST as f32) as usize;
        for i in 1..=pieces {
            let share = i as f32 / pieces as f32;
            vertices.push([a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]);
        }
    }
    vertices
}

/// A straight piece with soft edges.
fn stroke(mesh: &mut Mesh, from: Pos2, to: Pos2, color: Color32) {
    const HALF: f32 = 1.0;
    const SOFT: f32 = 0.8;
    let along = to - from;
    if along.length_sq() < 1e-6 {
        return;
    }
    let across = along.normalized().rot90();
    let Ok(first) = u32::try_from(mesh.vertices.len()) else { return };
    for end in [from, to] {
        mesh.colored_vertex(end - across * (HALF + SOFT), Color32::TRANSPARENT);
        mesh.colored_vertex(end - across * HALF, color);
        mesh.colored_vertex(end + across * HALF, color);
        mesh.colored_vertex(end + across * (HALF + SOFT), Color32::TRANSPARENT);
    }
    for strip in 0..3 {
        let at = first + strip;
        mesh.add_triangle(at, at + 1, at + 4);
        mesh.add_triangle(at + 1, at + 5, at + 4);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use eframe::egui::{pos2, vec2};
    use orograph_core::Polyline;

    use super::{super::relief::tests::terrain, *};

    #[test]
    fn a_line_is_cut_where_the_ground_hides_it() {
        // A wall from north to south, and a line from west to east across it.
        let field = terrain(101, 101, |_, col| if col == 50 { 1000.0 } else { 0.0 });
        let relief = Relief::new(&field).unwrap();
        let vertices = vec![[50.0, 10.0], [50.0, 90.0]];
        let features = Features {
            grid: field.grid().clone(),
            kind: FeatureKind::Valley,
            points: Vec::new(),
            lines: vec![Polyline { from: 0, to: 0, vertices, profiles: Vec::new() }],
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 0.0,
        };
        let lines = Lines::new(&features, &relief);
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 400.0));
        let pieces = |tilt: f32| {
            let stand = Stand { azimuth: 90.0, tilt, ..Stand::default() };
            lines.mesh(&relief, &stand, rect).vertices.len() / 8
        };
        assert_eq!(pieces(89.0), 80, "from above all of it is seen, the wall as well");
        let (low, middle) = (pieces(10.0), pieces(40.0));
        assert!((40..=46).contains(&low), "from the east, low, the western half lies behind the wall: {low}");
        // The wall is 10 cells high: seen at 40° it hides 10 / tan 40° = 12 cells.
        assert!((64..=70).contains(&middle), "{middle}");
    }

    #[test]
    fn pieces_are_no_longer_than_asked() {
        let line = cut(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.05]], 0.1);
        assert_eq!(line.len(), 12);
        assert!(line.windows(2).all(|pair| far(pair[0], pair[1]) <= 0.1 + 1e-6));
    }
}
