//! The wheel of a mouse enlarges what is under the pointer, as in other programs of this kind. Two fingers on a
//! touchpad move about; with Ctrl either enlarges.

use eframe::egui::{self, Event, MouseWheelUnit, Pos2, Rect};

/// Scales between which one looks at the graph.
pub(super) const SCALES: std::ops::RangeInclusive<f32> = 0.1..=2.0;

/// The wheel over the canvas.
#[derive(Default)]
pub(super) struct Wheel {
    /// What was turned last tells of fine steps: a touchpad.
    touchpad: bool,
}

impl Wheel {
    /// Takes the turn of the wheel, when it is over the canvas and nothing stands above it, from the widgets to come.
    pub(super) fn take(&mut self, ui: &egui::Ui, canvas: Rect) -> f32 {
        let ctx = ui.ctx();
        let pos = ctx.input(|input| input.pointer.latest_pos()).filter(|pos| canvas.contains(*pos));
        let layer = pos.and_then(|pos| ctx.layer_id_at(pos));
        // The graph and its nodes are layers of the panel's own order.
        let over = layer.is_some_and(|layer| layer.order == ui.layer_id().order);
        ctx.input_mut(|input| {
            for event in &input.events {
                if let Event::MouseWheel { unit, .. } = event {
                    self.touchpad = *unit == MouseWheelUnit::Point;
                }
            }
            match over && !self.touchpad {
                true => std::mem::take(&mut input.smooth_scroll_delta.y),
                false => 0.0,
            }
        })
    }
}

/// What is seen after a turn at the place `at` of the graph, when it was seen at the scale `now` before.
pub(super) fn enlarged(seen: Rect, at: Pos2, now: f32, turned: f32) -> Rect {
    let next = (now * libm::expf(turned / 200.0)).clamp(*SCALES.start(), *SCALES.end());
    let share = now / next;
    Rect::from_min_max(at + (seen.min - at) * share, at + (seen.max - at) * share)
}

#[cfg(test)]
mod tests {
    use eframe::egui::{pos2, vec2};

    use super::*;

    #[test]
    fn what_is_under_the_pointer_stays_there_and_the_scale_keeps_its_limits() {
        let seen = Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 300.0));
        let at = pos2(110.0, 245.0);
        let near = enlarged(seen, at, 1.0, 100.0);
        assert!(near.width() < seen.width());
        let share = |rect: Rect| (at - rect.min) / rect.size();
        assert!((share(near) - share(seen)).length() < 1e-4);
        assert!((enlarged(seen, at, 1.0, 1e4).width() - 200.0).abs() < 1e-2);
        assert!((enlarged(seen, at, 1.0, -1e4).width() - 4000.0).abs() < 1.0);
    }
}
