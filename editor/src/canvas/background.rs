//! What stands behind and between the nodes: frames and comments.

use eframe::egui::{self, Rect, Response, Vec2, pos2, vec2};
use orograph_engine::document::{Comment, Frame};

use super::{Canvas, Gesture, id};

/// What is being dragged, other than nodes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Held {
    /// A frame, with what stands in it.
    Frame(usize),
    /// A comment.
    Comment(usize),
    /// A place that a wire is led through.
    Bend(super::Wire, usize),
}

impl Canvas {
    pub(super) fn frames(&mut self, ui: &mut egui::Ui, frames: &[Frame], gestures: &mut Vec<Gesture>) {
        for (index, frame) in frames.iter().enumerate() {
            let (x, y, width, height) = frame.rect;
            let rect = Rect::from_min_size(pos2(x as f32, y as f32), vec2(width as f32, height as f32));
            let rect = rect.translate(self.offset_of(&Held::Frame(index)));
            let visuals = ui.visuals();
            ui.painter().rect(
                rect,
                6.0,
                visuals.faint_bg_color.gamma_multiply(1.5),
                egui::Stroke::new(1.0, visuals.weak_text_color()),
                egui::StrokeKind::Inside,
            );
            let bar = Rect::from_min_size(rect.min, vec2(rect.width(), 24.0));
            ui.painter().text(
                bar.min + vec2(8.0, 4.0),
                egui::Align2::LEFT_TOP,
                &frame.title,
                egui::FontId::proportional(15.0),
                visuals.strong_text_color(),
            );
            let response = ui.interact(bar, id().with(("frame", index)), egui::Sense::click_and_drag());
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::WidgetType::Button, true, format!("frame {}", frame.title))
            });
            if response.double_clicked() {
                gestures.push(Gesture::RenameFrame(index));
            }
            if let Some(offset) = self.held(&response, Held::Frame(index)) {
                gestures.push(Gesture::MoveFrame(index, offset));
            }
        }
    }

    pub(super) fn comments(&mut self, ui: &mut egui::Ui, comments: &[Comment], gestures: &mut Vec<Gesture>) {
        const WIDTH: f32 = 260.0;
        for (index, comment) in comments.iter().enumerate() {
            let at = pos2(comment.at.0 as f32, comment.at.1 as f32) + self.offset_of(&Held::Comment(index));
            let visuals = ui.visuals();
            let colour = visuals.text_color();
            let font = egui::FontId::proportional(14.0);
            let text = ui.painter().layout(comment.text.clone(), font, colour, WIDTH);
            let rect = Rect::from_min_size(at, text.size()).expand2(vec2(8.0, 6.0));
            ui.painter().rect_filled(rect, 4.0, visuals.faint_bg_color);
            let edge = Rect::from_min_size(rect.min, vec2(3.0, rect.height()));
            ui.painter().rect_filled(edge, 1.0, visuals.warn_fg_color);
            ui.painter().galley(at, text, colour);
            let response = ui.interact(rect, id().with(("comment", index)), egui::Sense::click_and_drag());
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::WidgetType::Button, true, format!("comment {}", comment.text))
            });
            if response.double_clicked() {
                gestures.push(Gesture::EditComment(index));
            }
            if let Some(offset) = self.held(&response, Held::Comment(index)) {
                gestures.push(Gesture::MoveComment(index, offset));
            }
        }
    }

    /// How far something was dragged so far.
    pub(super) fn offset_of(&self, what: &Held) -> Vec2 {
        self.held.as_ref().filter(|(held, _)| held == what).map_or(Vec2::ZERO, |(_, offset)| *offset)
    }

    /// Follows a drag; when it ends, how far it went.
    pub(super) fn held(&mut self, response: &Response, what: Held) -> Option<(f64, f64)> {
        if response.dragged() {
            let offset = self.offset_of(&what) + response.drag_delta();
            self.held = Some((what, offset));
            return None;
        }
        if !response.drag_stopped() {
            return None;
        }
        let (_, offset) = self.held.take().filter(|(held, _)| *held == what)?;
        Some((f64::from(offset.x), f64::from(offset.y)))
    }
}
