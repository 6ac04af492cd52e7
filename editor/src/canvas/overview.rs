//! The whole graph in a corner; a click there looks at that place.

use eframe::egui::{self, Color32, Rect, Stroke, StrokeKind, vec2};

const SIZE: egui::Vec2 = vec2(150.0, 100.0);

/// Draws the overview, and gives the part of the graph to look at when the user says so.
pub(super) fn show(ui: &mut egui::Ui, canvas: Rect, nodes: &[(Rect, Color32)], seen: Rect) -> Option<Rect> {
    let all = nodes.iter().map(|(rect, _)| *rect).reduce(Rect::union)?;
    if canvas.width() < 3.0 * SIZE.x || canvas.height() < 2.0 * SIZE.y || seen.contains_rect(all) {
        return None;
    }
    let all = all.union(seen).expand(20.0);
    let place = Rect::from_min_size(canvas.right_bottom() - SIZE - vec2(8.0, 8.0), SIZE);
    let scale = (SIZE.x / all.width()).min(SIZE.y / all.height());
    let small = |rect: Rect| {
        let min = place.center() + (rect.min - all.center()) * scale;
        Rect::from_min_size(min, rect.size() * scale)
    };
    let area = egui::Area::new(egui::Id::new("overview")).fixed_pos(place.min).order(egui::Order::Middle);
    let response = area.show(ui.ctx(), |ui| {
        let (rect, response) = ui.allocate_exact_size(SIZE, egui::Sense::click_and_drag());
        let visuals = ui.visuals();
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 4.0, visuals.extreme_bg_color.gamma_multiply(0.85));
        for (node, colour) in nodes {
            painter.rect_filled(small(*node), 1.0, *colour);
        }
        let stroke = Stroke::new(1.0, visuals.strong_text_color());
        painter.rect_stroke(small(seen).intersect(rect), 0.0, stroke, StrokeKind::Inside);
        response
    });
    let response = response.inner;
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, "overview of the graph"));
    let pointer = response.interact_pointer_pos()?;
    let target = all.center() + (pointer - place.center()) / scale;
    Some(Rect::from_center_size(target, seen.size()))
}
