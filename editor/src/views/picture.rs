//! A picture that can be moved, enlarged, measured and drawn upon.

use std::sync::Arc;

use eframe::egui::{self, Color32, Pos2, Rect, Stroke, Vec2, vec2};
use orograph_core::Texture;

use super::{
    Asked, Strokes, Tool,
    legend::Legend,
    probe::Probe,
    tiles::Tiles,
    view::{self, View},
};

/// A picture and where one looks at it.
#[derive(Default)]
pub struct Picture {
    tiles: Option<Tiles>,
    pub(super) size: Vec2,
    pub(super) view: View,
    stroke: Vec<[f64; 2]>,
}

impl Picture {
    pub(super) fn show(&mut self, ctx: &egui::Context, name: &str, texture: Option<Arc<Texture>>) {
        self.tiles = texture.map(|texture| Tiles::new(ctx, name, texture));
        self.size = self.tiles.as_ref().map_or(self.size, Tiles::size);
    }

    /// All of it as one texture, which leaves cells of a large picture out.
    pub(super) fn texture(&self) -> Option<egui::TextureId> {
        self.tiles.as_ref().map(Tiles::whole)
    }

    /// Paints it where it lies.
    pub(super) fn paint(&mut self, painter: &egui::Painter, place: Rect) {
        if let Some(tiles) = &mut self.tiles {
            tiles.paint(painter, place);
        }
    }

    pub(super) fn ui(
        &mut self,
        ui: &mut egui::Ui,
        name: &str,
        probe: &Probe<'_>,
        legend: Option<&Legend>,
        tool: Tool,
        strokes: &Strokes,
    ) -> Vec<Asked> {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Image, true, format!("picture {name}"))
        });
        self.navigate(ui, &response, rect, tool);
        let place = self.place(rect);
        let painter = ui.painter_at(rect);
        self.paint(&painter, place);
        let mut asked = Vec::new();
        if tool != Tool::Look {
            self.draw(&response, place, tool, &mut asked);
            overlay(&painter, place, &strokes.others, FAINT);
            overlay(&painter, place, &strokes.lines, PAINT);
            let stroke = self.stroke.iter().map(|[x, y]| [*x, *y, 0.0]).collect();
            overlay(&painter, place, &[stroke], Color32::WHITE);
        }
        if let Some(grid) = probe.grid() {
            scale_bar(&painter, rect, place.width() / self.size.x.max(1.0), grid.cell.x);
        }
        if let Some(legend) = legend {
            legend.ui(ui, rect, egui::Align::Max, response.id.with("legend"));
        }
        if let Some(pos) = response.hover_pos()
            && let Some(text) = probe.tell(share(place, pos), self.reach(place))
        {
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_value(text.clone()));
            tell(ui, rect, response.id.with("probe"), text);
        }
        asked
    }

    /// Cells within which a line is under the pointer.
    pub(super) fn reach(&self, place: Rect) -> f64 {
        const PIXELS: f32 = 5.0;
        f64::from(PIXELS * self.size.x / place.width().max(1.0)).max(1.0)
    }

    pub(super) fn place(&self, rect: Rect) -> Rect {
        self.view.place(rect, self.size)
    }

    /// Moves and enlarges as the pointer and, with the keyboard here, the keys say.
    pub(super) fn navigate(&mut self, ui: &egui::Ui, response: &egui::Response, rect: Rect, tool: Tool) {
        let pan = response.dragged_by(egui::PointerButton::Middle)
            || (tool == Tool::Look && response.dragged_by(egui::PointerButton::Primary));
        if pan {
            self.view.pan(response.drag_delta(), rect, self.size);
        }
        if response.double_clicked() && tool == Tool::Look {
            self.view = View::default();
        }
        let keys = super::keys::held(ui, response);
        self.view.pan(-keys.arrows * 24.0, rect, self.size);
        if keys.nearer != 0.0 {
            self.view.enlarge(1.0 + 0.2 * keys.nearer, rect.center(), rect, self.size);
        }
        let Some(pos) = response.hover_pos() else { return };
        let factor = ui.input(|input| input.smooth_scroll_delta().y * 0.004 + (input.zoom_delta() - 1.0));
        if factor != 0.0 {
            self.view.enlarge(1.0 + factor, pos, rect, self.size);
        }
    }

    fn draw(&mut self, response: &egui::Response, place: Rect, tool: Tool, asked: &mut Vec<Asked>) {
        /// Points nearer than this, in pixels of the window, are one.
        const STEP: f64 = 3.0;
        let primary = egui::PointerButton::Primary;
        let pointer = response.interact_pointer_pos().map(|pos| share(place, pos));
        match tool {
            Tool::Look => {}
            Tool::Draw => {
                if response.dragged_by(primary)
                    && let Some(at) = pointer
                {
                    let far = |last: &[f64; 2]| {
                        let d = [
                            (at[0] - last[0]) * f64::from(place.width()),
                            (at[1] - last[1]) * f64::from(place.height()),
                        ];
                        d[0] * d[0] + d[1] * d[1] >= STEP * STEP
                    };
                    // A drag is told of once the pointer has moved away from where it began.
                    let begun = response.ctx.input(|input| input.pointer.press_origin());
                    if let Some(begun) = begun.filter(|_| self.stroke.is_empty()) {
                        self.stroke.push(share(place, begun));
                    }
                    if self.stroke.last().is_none_or(far) {
                        self.stroke.push(at);
                    }
                }
                if response.drag_stopped_by(primary) {
                    let stroke = simplified(
                        &std::mem::take(&mut self.stroke),
                        1.0 / f64::from(place.width().max(1.0)),
                    );
                    if stroke.len() > 1 {
                        asked.push(Asked::Stroke(stroke));
                    }
                }
            }
            Tool::Point => {
                if response.clicked()
                    && let Some(at) = pointer
                {
                    asked.push(Asked::Stroke(vec![at]));
                }
            }
            Tool::Erase => {
                if (response.dragged_by(primary) || response.clicked())
                    && let Some(at) = pointer
                {
                    asked.push(Asked::Erase(at, 8.0 / f64::from(place.width().max(1.0))));
                }
                if response.drag_stopped_by(primary) || response.clicked() {
                    asked.push(Asked::Lifted);
                }
            }
        }
    }
}

/// A place in the window as a share of the picture.
pub(super) fn share(place: Rect, pos: Pos2) -> [f64; 2] {
    let share = view::share(place, pos);
    [f64::from(share.x), f64::from(share.y)]
}

/// Words at the foot of a view, on whatever picture.
pub(super) fn tell(ui: &egui::Ui, rect: Rect, id: egui::Id, text: String) {
    let painter = ui.painter_at(rect);
    let galley = painter.layout_no_wrap(text.clone(), egui::FontId::monospace(12.0), Color32::WHITE);
    let at = rect.left_bottom() + vec2(6.0, -6.0);
    let ground = Rect::from_min_size(at - vec2(3.0, galley.size().y + 3.0), galley.size() + vec2(6.0, 6.0));
    painter.rect_filled(ground, 2.0, Color32::from_black_alpha(170));
    painter.galley(ground.min + vec2(3.0, 3.0), galley, Color32::WHITE);
    let response = ui.interact(ground, id, egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Label, true, text.clone()));
}

/// The stroke without vertices that lie within `tolerance` of the line without them (Douglas and Peucker 1973).
fn simplified(stroke: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (stroke.first(), stroke.last()) else { return Vec::new() };
    if stroke.len() < 3 {
        return stroke.to_vec();
    }
    let distance = |point: &[f64; 2]| {
        let (dx, dy) = (last[0] - first[0], last[1] - first[1]);
        let (px, py) = (point[0] - first[0], point[1] - first[1]);
        let length = dx * dx + dy * dy;
        let along = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
        let (ex, ey) = (px - along * dx, py - along * dy);
        ex * ex + ey * ey
    };
    let inner = &stroke[1..stroke.len() - 1];
    let furthest = inner.iter().enumerate().max_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    match furthest {
        Some((index, point)) if distance(point) > tolerance * tolerance => {
            let middle = index + 1;
            let mut line = simplified(&stroke[..=middle], tolerance);
            line.pop();
            line.extend(simplified(&stroke[middle..], tolerance));
            line
        }
        _ => vec![*first, *last],
    }
}

/// What is under the brush, and what is not.
const PAINT: Color32 = Color32::from_rgb(0xff, 0xd0, 0x40);
const FAINT: Color32 = Color32::from_rgb(0x70, 0xb8, 0xc8);

fn overlay(painter: &egui::Painter, place: Rect, lines: &[Vec<[f64; 3]>], colour: Color32) {
    let at = |x: f64, y: f64| place.min + vec2(x as f32 * place.width(), y as f32 * place.height());
    for line in lines {
        match line.as_slice() {
            [point] => {
                painter.circle_filled(at(point[0], point[1]), 4.0, colour);
            }
            points => {
                let points = points.iter().map(|point| at(point[0], point[1])).collect();
                painter.line(points, Stroke::new(2.0, colour));
            }
        }
    }
}

/// A length of 1, 2 or 5 times a power of ten metres, about a fifth of the view wide.
pub(super) fn scale_bar(painter: &egui::Painter, rect: Rect, pixels_per_cell: f32, metres_per_cell: f64) {
    let pixels_per_metre = f64::from(pixels_per_cell) / metres_per_cell;
    let wanted = f64::from(rect.width()) / 5.0 / pixels_per_metre;
    if !wanted.is_finite() || wanted <= 0.0 {
        return;
    }
    let power = libm::pow(10.0, libm::log10(wanted).floor());
    let metres = [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|m| *m <= wanted).unwrap_or(power);
    let width = (metres * pixels_per_metre) as f32;
    let end = rect.right_bottom() + vec2(-12.0, -12.0);
    let stroke = Stroke::new(2.0, Color32::WHITE);
    painter.line_segment([end - vec2(width, 0.0), end], Stroke::new(4.0, Color32::from_black_alpha(170)));
    painter.line_segment([end - vec2(width, 0.0), end], stroke);
    let text = if metres >= 1000.0 { format!("{} km", metres / 1000.0) } else { format!("{metres} m") };
    let at = end - vec2(width / 2.0, 4.0);
    let font = egui::FontId::proportional(12.0);
    let galley = painter.layout_no_wrap(text, font, Color32::WHITE);
    let ground = egui::Align2::CENTER_BOTTOM.anchor_size(at, galley.size());
    painter.rect_filled(ground.expand(2.0), 2.0, Color32::from_black_alpha(170));
    painter.galley(ground.min, galley, Color32::WHITE);
}

#[cfg(test)]
mod tests {
    use super::simplified;

    #[test]
    fn a_straight_stroke_keeps_its_ends_alone_and_a_corner_stays() {
        let straight: Vec<_> = (0..50).map(|i| [f64::from(i) / 50.0, f64::from(i) / 100.0]).collect();
        assert_eq!(simplified(&straight, 1e-3), vec![straight[0], straight[49]]);
        let corner = [[0.0, 0.0], [0.25, 0.0], [0.5, 0.0], [0.5, 0.25], [0.5, 0.5]];
        assert_eq!(simplified(&corner, 1e-3), vec![corner[0], corner[2], corner[4]]);
    }
}
