//! Terrain in three dimensions: orbit, exaggeration, sun, and the pane's picture laid over it.
//!
//! A height field seen from above the ground needs no depth buffer: drawn from the far rows and columns towards the
//! eye, what is nearer covers what is behind. So it is a plain mesh of the window, wherever that is drawn.

mod camera;
mod lines;
mod mesh;
mod relief;

use std::sync::Arc;

use eframe::egui::{self, Mesh, Rect, Shape, TextureId};
use glam::Vec3;
use orograph_core::{Features, Heightfield};

pub(super) use camera::Stand;
use lines::Lines;
use relief::Relief;

use super::{keys, legend::Legend, picture};

/// Terrain, and where one looks at it from.
#[derive(Default)]
pub struct Ground {
    relief: Option<Result<Relief, &'static str>>,
    lines: Option<Lines>,
    pub(super) stand: Stand,
    /// Normals, and the factor on heights that they are of.
    normals: Option<(f32, Vec<Vec3>)>,
    drawn: Option<Drawn>,
}

/// What was drawn last, and what it depends on.
struct Drawn {
    rect: Rect,
    stand: Stand,
    texture: Option<TextureId>,
    ground: Arc<Mesh>,
    lines: Option<Arc<Mesh>>,
}

impl Ground {
    /// Takes terrain, and what lies on it.
    pub(super) fn show(&mut self, terrain: Option<&Heightfield>, features: Option<&Features>) {
        self.relief = terrain.map(Relief::new);
        self.lines = match (&self.relief, features) {
            (Some(Ok(relief)), Some(features)) => Some(Lines::new(features, relief)),
            _ => None,
        };
        (self.normals, self.drawn) = (None, None);
    }

    /// Whether there is terrain to be seen.
    pub(super) fn has_terrain(&self) -> bool {
        self.relief.is_some()
    }

    pub(super) fn ui(
        &mut self,
        ui: &mut egui::Ui,
        name: &str,
        texture: Option<TextureId>,
        legend: Option<&Legend>,
    ) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().slider_width = 64.0;
            let stand = &mut self.stand;
            let degrees = |value, range| egui::Slider::new(value, range).suffix("°").fixed_decimals(0);
            ui.add(egui::Slider::new(&mut stand.exaggeration, 0.1..=10.0).logarithmic(true).text("height"));
            ui.add(degrees(&mut stand.sun.0, 0.0..=360.0).text("sun from"));
            ui.add(degrees(&mut stand.sun.1, 0.0..=90.0).text("sun height"));
        });
        match &self.relief {
            Some(Ok(relief)) if relief.squeezed > 1.0 => {
                let times = super::numbers::readable(relief.squeezed);
                ui.weak(format!("Heights are drawn {times} times lower than they are"));
            }
            Some(Err(reason)) => {
                ui.label(*reason);
                return;
            }
            Some(Ok(_)) => {}
            None => return,
        }
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Image, true, format!("ground {name}"))
        });
        self.walk(ui, &response, rect);
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
        self.draw(rect, texture);
        if let Some(drawn) = &self.drawn {
            // The window's painter stops the program at a mesh that has corners and no triangle.
            let meshes = [Some(&drawn.ground), drawn.lines.as_ref()].into_iter().flatten();
            for mesh in meshes.filter(|mesh| !mesh.indices.is_empty()) {
                painter.add(Shape::Mesh(mesh.clone()));
            }
        }
        if let Some(legend) = legend {
            legend.ui(ui, rect, egui::Align::Max, response.id.with("legend"));
        }
        picture::tell(ui, rect, response.id.with("stand"), self.stand.words());
    }

    /// Goes around it, as the pointer and, with the keyboard here, the arrows say.
    fn walk(&mut self, ui: &egui::Ui, response: &egui::Response, rect: Rect) {
        /// Degrees for a press of an arrow.
        const STEP: f32 = 5.0;
        let stand = &mut self.stand;
        if response.dragged_by(egui::PointerButton::Primary) {
            let delta = response.drag_delta();
            stand.orbit(-delta.x * 0.5, delta.y * 0.5);
        } else if response.dragged() {
            stand.shift += response.drag_delta() / rect.size();
        }
        if response.double_clicked() {
            stand.reset();
        }
        let keys = keys::held(ui, response);
        stand.orbit(keys.arrows.x * STEP, -keys.arrows.y * STEP);
        stand.enlarge(1.0 + 0.2 * keys.nearer);
        if response.hovered() {
            let scroll = ui.input(|input| input.smooth_scroll_delta().y);
            stand.enlarge(1.0 + scroll * 0.003);
        }
    }

    /// Makes the meshes anew, when something that they depend on changed.
    fn draw(&mut self, rect: Rect, texture: Option<TextureId>) {
        let Some(Ok(relief)) = &self.relief else { return };
        let stand = self.stand;
        let same = |drawn: &Drawn| drawn.rect == rect && drawn.stand == stand && drawn.texture == texture;
        if self.drawn.as_ref().is_some_and(same) {
            return;
        }
        let normals = match self.normals.take() {
            Some((exaggeration, normals)) if exaggeration == stand.exaggeration => normals,
            _ => relief.normals(stand.exaggeration),
        };
        let ground = Arc::new(mesh::mesh(relief, &normals, &stand, rect, texture));
        let lines = self.lines.as_ref().map(|lines| Arc::new(lines.mesh(relief, &stand, rect)));
        self.normals = Some((stand.exaggeration, normals));
        self.drawn = Some(Drawn { rect, stand, texture, ground, lines });
    }
}
