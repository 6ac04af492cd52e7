//! Terrain in three dimensions: orbit, exaggeration, sun, and the pane's picture laid over it.
//!
//! A height field seen from above the ground needs no depth buffer: drawn from the far rows and columns towards the
//! eye, what is nearer covers what is behind. So it is a plain mesh of the window, wherever that is drawn.

use eframe::egui::{self, Color32, Mesh, Pos2, Rect, Vec2, epaint::Vertex, pos2, vec2};
use glam::Vec3;
use orograph_core::Heightfield;

/// Most rows and columns that are drawn; more would cost more than a frame has.
const MOST: usize = 257;

/// Terrain, and where one looks at it from.
pub struct Ground {
    rows: usize,
    cols: usize,
    /// Places in the world, its larger side 2 long, the middle at 0; NaN heights are voids.
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    azimuth: f32,
    tilt: f32,
    zoom: f32,
    exaggeration: f32,
    sun: (f32, f32),
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            rows: 0,
            cols: 0,
            points: Vec::new(),
            normals: Vec::new(),
            azimuth: 200.0,
            tilt: 35.0,
            zoom: 1.0,
            exaggeration: 1.0,
            sun: (315.0, 45.0),
        }
    }
}

impl Ground {
    pub(super) fn show(&mut self, terrain: Option<&Heightfield>) {
        (self.rows, self.cols) = (0, 0);
        let Some(terrain) = terrain else { return };
        let (rows, cols) = (terrain.rows(), terrain.cols());
        let Some((low, high)) = terrain.range() else { return };
        if rows < 2 || cols < 2 {
            return;
        }
        (self.rows, self.cols) = (rows.min(MOST), cols.min(MOST));
        let cell = terrain.grid().cell;
        let (width, depth) = (cell.x * (cols - 1) as f64, cell.y * (rows - 1) as f64);
        let scale = 2.0 / width.max(depth);
        let middle = f64::midpoint(f64::from(low), f64::from(high));
        let index = |i: usize, n: usize, of: usize| i * (of - 1) / (n - 1);
        self.points.clear();
        for r in 0..self.rows {
            let row = index(r, self.rows, rows);
            for c in 0..self.cols {
                let col = index(c, self.cols, cols);
                let x = (col as f64 * cell.x - width / 2.0) * scale;
                let y = (row as f64 * cell.y - depth / 2.0) * scale;
                let z = (f64::from(terrain.at(row, col)) - middle) * scale;
                self.points.push(Vec3::new(x as f32, y as f32, z as f32));
            }
        }
        self.light();
    }

    /// Normals of the ground as it is exaggerated.
    fn light(&mut self) {
        self.normals.clear();
        for r in 0..self.rows {
            for c in 0..self.cols {
                let at = |r: usize, c: usize| {
                    self.points[r * self.cols + c] * Vec3::new(1.0, 1.0, self.exaggeration)
                };
                let (west, east) = (at(r, c.saturating_sub(1)), at(r, (c + 1).min(self.cols - 1)));
                let (north, south) = (at(r.saturating_sub(1), c), at((r + 1).min(self.rows - 1), c));
                let normal = (east - west).cross(south - north);
                let normal = if normal.is_finite() { normal.normalize_or(Vec3::Z) } else { Vec3::Z };
                self.normals.push(normal);
            }
        }
    }

    pub(super) fn ui(&mut self, ui: &mut egui::Ui, name: &str, texture: Option<egui::TextureId>) {
        ui.horizontal(|ui| {
            let height =
                egui::Slider::new(&mut self.exaggeration, 0.1..=10.0).logarithmic(true).text("height");
            if ui.add(height).changed() {
                self.light();
            }
            ui.add(
                egui::Slider::new(&mut self.sun.0, 0.0..=360.0)
                    .text("sun from")
                    .suffix("°")
                    .fixed_decimals(0),
            );
            ui.add(
                egui::Slider::new(&mut self.sun.1, 0.0..=90.0)
                    .text("sun height")
                    .suffix("°")
                    .fixed_decimals(0),
            );
        });
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Image, true, format!("ground {name}"))
        });
        if response.dragged() {
            let delta = response.drag_delta();
            self.azimuth = (self.azimuth - delta.x * 0.5).rem_euclid(360.0);
            self.tilt = (self.tilt + delta.y * 0.5).clamp(5.0, 89.0);
        }
        if response.double_clicked() {
            (self.azimuth, self.tilt, self.zoom) = (200.0, 35.0, 1.0);
        }
        if response.hovered() {
            let scroll = ui.input(|input| input.smooth_scroll_delta().y);
            self.zoom = (self.zoom * (1.0 + scroll * 0.003)).clamp(0.2, 20.0);
        }
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
        if let Some(mesh) = self.mesh(rect, texture) {
            painter.add(egui::Shape::mesh(mesh));
        }
    }

    fn mesh(&self, rect: Rect, texture: Option<egui::TextureId>) -> Option<Mesh> {
        if self.points.is_empty() || self.rows < 2 {
            return None;
        }
        let camera = Camera::new(self.azimuth, self.tilt, rect, self.zoom);
        let (azimuth, altitude) = (self.sun.0.to_radians(), self.sun.1.to_radians());
        let level = libm::cosf(altitude);
        // y runs south.
        let sun = Vec3::new(libm::sinf(azimuth) * level, -libm::cosf(azimuth) * level, libm::sinf(altitude));
        let mut mesh = texture.map_or_else(Mesh::default, Mesh::with_texture);
        mesh.vertices.reserve(self.points.len());
        for (index, (point, normal)) in self.points.iter().zip(&self.normals).enumerate() {
            let (row, col) = (index / self.cols, index % self.cols);
            let place = camera.place(*point * Vec3::new(1.0, 1.0, self.exaggeration));
            let light = 0.35 + 0.65 * normal.dot(sun).max(0.0);
            let uv = match texture {
                Some(_) => pos2(col as f32 / (self.cols - 1) as f32, row as f32 / (self.rows - 1) as f32),
                None => egui::epaint::WHITE_UV,
            };
            mesh.vertices.push(Vertex { pos: place, uv, color: Color32::from_gray((light * 255.0) as u8) });
        }
        // Far before near: towards the row and the column that the eye stands over, from both sides.
        let rows = towards(camera.eye.y, self.rows, |r| self.points_of(r, 0).y);
        let cols = towards(camera.eye.x, self.cols, |c| self.points_of(0, c).x);
        for &row in &rows {
            for &col in &cols {
                let corner = row * self.cols + col;
                let quad = [corner, corner + 1, corner + self.cols, corner + self.cols + 1];
                if quad.iter().any(|index| self.points[*index].z.is_nan()) {
                    continue;
                }
                let [a, b, c, d] = quad.map(|index| u32::try_from(index).unwrap_or(0));
                mesh.indices.extend([a, b, c, b, d, c]);
            }
        }
        Some(mesh)
    }

    fn points_of(&self, row: usize, col: usize) -> Vec3 {
        self.points[row * self.cols + col]
    }
}

/// The intervals between `n` places, the ones furthest from `eye` first.
fn towards(eye: f32, n: usize, place: impl Fn(usize) -> f32) -> Vec<usize> {
    let before = (0..n - 1).take_while(|i| place(*i) < eye).count();
    (0..before).chain((before..n - 1).rev()).collect()
}

/// An eye that looks at the middle.
struct Camera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    ahead: Vec3,
    centre: Pos2,
    scale: f32,
}

impl Camera {
    fn new(azimuth: f32, tilt: f32, rect: Rect, zoom: f32) -> Self {
        const DISTANCE: f32 = 4.0;
        let (azimuth, tilt) = (azimuth.to_radians(), tilt.to_radians());
        let level = libm::cosf(tilt);
        let from = Vec3::new(libm::sinf(azimuth) * level, -libm::cosf(azimuth) * level, libm::sinf(tilt));
        let ahead = -from;
        // y runs south, so the axes are left-handed, and so is this product.
        let right = Vec3::Z.cross(ahead).normalize_or(Vec3::X);
        let up = ahead.cross(right);
        let Vec2 { x, y } = rect.size();
        Self {
            eye: from * DISTANCE,
            right,
            up,
            ahead,
            centre: rect.center(),
            scale: x.min(y * 1.4) * 1.2 * zoom,
        }
    }

    fn place(&self, point: Vec3) -> Pos2 {
        let from_eye = point - self.eye;
        let depth = from_eye.dot(self.ahead).max(0.1);
        let at = vec2(from_eye.dot(self.right), -from_eye.dot(self.up)) / depth;
        self.centre + at * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearer_is_drawn_later() {
        let order = towards(10.0, 5, |i| i as f32);
        assert_eq!(order, [0, 1, 2, 3], "an eye beyond the last place");
        let order = towards(-10.0, 5, |i| i as f32);
        assert_eq!(order, [3, 2, 1, 0], "an eye before the first");
        let order = towards(1.5, 5, |i| i as f32);
        assert_eq!(order, [0, 1, 3, 2], "an eye over the ground");
    }

    #[test]
    fn seen_from_the_south_east_lies_to_the_right_and_north_above() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(100.0, 100.0));
        let camera = Camera::new(180.0, 40.0, rect, 1.0);
        let middle = camera.place(Vec3::ZERO);
        assert!(camera.place(Vec3::X).x > middle.x);
        assert!(camera.place(-Vec3::Y).y < middle.y);
        assert!(camera.place(Vec3::Z).y < middle.y);
        let (near, far) = (camera.place(Vec3::new(1.0, 1.0, 0.0)), camera.place(Vec3::new(1.0, -1.0, 0.0)));
        assert!(near.x > far.x, "what is nearer is larger");
    }
}
