//! The net as triangles of the window, the far ones first, with walls down to a foot along the near sides.

use eframe::egui::{Color32, Mesh, Pos2, Rect, TextureId, epaint::Vertex, pos2};
use glam::Vec3;

use super::{
    camera::{Camera, Stand},
    relief::Relief,
};

/// Light where the sun does not shine, on bare ground, and on pictures, most of which are shaded already.
const SHADE: (f32, f32) = (0.35, 0.6);
/// Of the light on walls, so that they do not look like ground.
const WALL: f32 = 0.55;

/// The net as it is seen, with a picture of the terrain laid on it where there is one.
pub(super) fn mesh(
    relief: &Relief,
    normals: &[Vec3],
    stand: &Stand,
    rect: Rect,
    texture: Option<TextureId>,
) -> Mesh {
    let exaggeration = stand.exaggeration;
    let camera = Camera::new(stand, rect, relief.bounds(exaggeration));
    let (sun, shade) = (stand.sun_direction(), if texture.is_some() { SHADE.1 } else { SHADE.0 });
    let (rows, cols) = (relief.rows(), relief.cols());
    let mut mesh = texture.map_or_else(Mesh::default, Mesh::with_texture);
    mesh.vertices.reserve(rows * cols);
    let uv = |row: usize, col: usize| match texture {
        Some(_) => pos2(relief.us[col], relief.vs[row]),
        None => eframe::egui::epaint::WHITE_UV,
    };
    for row in 0..rows {
        for col in 0..cols {
            let point = relief.point(row, col, exaggeration);
            // No triangle takes the corner that a void is.
            let pos = if point.z.is_nan() { Pos2::ZERO } else { camera.place(point) };
            let light = brightness(normals[row * cols + col], sun, shade);
            mesh.vertices.push(Vertex { pos, uv: uv(row, col), color: grey(light) });
        }
    }
    // Far before near: towards the row and the column that the eye stands over, from both sides.
    let (down, across) = (towards(camera.eye.y, &relief.ys), towards(camera.eye.x, &relief.xs));
    mesh.indices.reserve(down.len() * across.len() * 6);
    for &row in &down {
        for &col in &across {
            let corner = row * cols + col;
            let quad = [(row, col), (row, col + 1), (row + 1, col), (row + 1, col + 1)];
            if quad.iter().any(|(row, col)| relief.z(*row, *col).is_nan()) {
                continue;
            }
            let [a, b, c, d] = [corner, corner + 1, corner + cols, corner + cols + 1].map(index);
            mesh.indices.extend([a, b, c, b, d, c]);
        }
    }
    walls(&mut mesh, relief, &camera, stand, &uv);
    mesh
}

/// Walls along the sides that face the eye: in front of all ground, so they are drawn last.
fn walls(
    mesh: &mut Mesh,
    relief: &Relief,
    camera: &Camera,
    stand: &Stand,
    uv: &dyn Fn(usize, usize) -> Pos2,
) {
    let (rows, cols) = (relief.rows(), relief.cols());
    let (east, south) = (relief.xs[cols - 1], relief.ys[rows - 1]);
    let foot = relief.bounds(stand.exaggeration).low;
    let sun = stand.sun_direction();
    let along_row = |row: usize| (0..cols).map(|col| (row, col)).collect::<Vec<_>>();
    let along_col = |col: usize| (0..rows).map(|row| (row, col)).collect::<Vec<_>>();
    let sides = [
        (camera.eye.y < -south, -Vec3::Y, along_row(0)),
        (camera.eye.y > south, Vec3::Y, along_row(rows - 1)),
        (camera.eye.x < -east, -Vec3::X, along_col(0)),
        (camera.eye.x > east, Vec3::X, along_col(cols - 1)),
    ];
    for (_, normal, border) in sides.into_iter().filter(|(faces, ..)| *faces) {
        let color = grey(brightness(normal, sun, SHADE.0) * WALL);
        let first = mesh.vertices.len();
        for (row, col) in &border {
            let top = relief.point(*row, *col, stand.exaggeration);
            let known = !top.z.is_nan();
            for point in [top, Vec3::new(top.x, top.y, foot)] {
                let pos = if known { camera.place(point) } else { Pos2::ZERO };
                mesh.vertices.push(Vertex { pos, uv: uv(*row, *col), color });
            }
        }
        for (i, pair) in border.windows(2).enumerate() {
            if pair.iter().any(|(row, col)| relief.z(*row, *col).is_nan()) {
                continue;
            }
            let at = first + 2 * i;
            let [a, b, c, d] = [at, at + 1, at + 2, at + 3].map(index);
            mesh.indices.extend([a, b, c, b, d, c]);
        }
    }
}

fn brightness(normal: Vec3, sun: Vec3, shade: f32) -> f32 {
    shade + (1.0 - shade) * normal.dot(sun).max(0.0)
}

fn grey(light: f32) -> Color32 {
    Color32::from_gray((light * 255.0) as u8)
}

fn index(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(0)
}

/// The intervals between ascending places, the ones furthest from `eye` first.
fn towards(eye: f32, places: &[f32]) -> Vec<usize> {
    let n = places.len();
    let before = places[..n - 1].iter().take_while(|place| **place < eye).count();
    (0..before).chain((before..n - 1).rev()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use eframe::egui::vec2;

    use super::{super::relief::tests::terrain, *};

    fn drawn(relief: &Relief, azimuth: f32) -> Mesh {
        let stand = Stand { azimuth, exaggeration: 10.0, ..Stand::default() };
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 300.0));
        mesh(relief, &relief.normals(10.0), &stand, rect, None)
    }

    #[test]
    fn what_is_nearer_is_drawn_later() {
        let places = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(towards(10.0, &places), [0, 1, 2, 3], "an eye beyond the last place");
        assert_eq!(towards(-10.0, &places), [3, 2, 1, 0], "an eye before the first");
        assert_eq!(towards(1.5, &places), [0, 1, 3, 2], "an eye over the ground");
    }

    #[test]
    fn every_square_is_two_triangles_and_a_void_takes_those_around_it() {
        let whole = Relief::new(&terrain(10, 12, |row, col| (row * col) as f32)).unwrap();
        let ground = |mesh: &Mesh| mesh.indices.chunks(3).filter(|of| of.iter().all(|i| *i < 120)).count();
        assert_eq!(ground(&drawn(&whole, 200.0)), 9 * 11 * 2);
        let holed = |row, col| if (row, col) == (5, 5) { f32::NAN } else { 1.0 };
        let holed = Relief::new(&terrain(10, 12, holed)).unwrap();
        assert_eq!(ground(&drawn(&holed, 200.0)), (9 * 11 - 4) * 2);
    }

    #[test]
    fn walls_stand_on_the_sides_that_face_the_eye_alone() {
        let relief = Relief::new(&terrain(10, 12, |row, col| (row * col) as f32)).unwrap();
        let walls = |azimuth: f32| (drawn(&relief, azimuth).vertices.len() - 120) / 2;
        assert_eq!(walls(0.0), 12, "the northern one");
        assert_eq!(walls(90.0), 10, "the eastern one");
        assert_eq!(walls(225.0), 22, "the southern and the western one");
    }

    #[test]
    fn from_every_side_every_corner_is_in_the_window_and_every_index_is_a_corner() {
        let fields = [
            terrain(2, 2, |row, col| (row + col) as f32),
            terrain(300, 40, |row, col| (row * col) as f32),
            terrain(5, 5, |_, _| 7.0),
            terrain(5, 5, |row, _| [3e38, -3e38, 0.0, 1.0, 2.0][row]),
            terrain(5, 5, |row, col| if row + col == 3 { f32::NAN } else { 1e6 * row as f32 }),
        ];
        for field in fields {
            let relief = Relief::new(&field).unwrap();
            for azimuth in 0..36u8 {
                let mesh = drawn(&relief, f32::from(azimuth) * 10.0);
                assert!(mesh.is_valid());
                assert!(mesh.vertices.iter().all(|vertex| vertex.pos.is_finite()));
                let inside = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 300.0));
                let seen = mesh.indices.iter().map(|i| mesh.vertices[*i as usize].pos);
                assert!(seen.into_iter().all(|pos| inside.contains(pos)));
            }
        }
    }
}
