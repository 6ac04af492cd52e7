//! A slider with a field beside it, in which any value can be typed.

use std::ops::RangeInclusive;

use eframe::egui::{self, SliderClamping, emath::Numeric};

use super::named;

/// What came of a slider in this frame.
pub(crate) struct Slid {
    /// The value is another one.
    pub(crate) changed: bool,
    /// It was let go: what it did is one step.
    pub(crate) done: bool,
}

/// The width that is kept for the field.
const FIELD: f32 = 110.0;

/// Draws a slider over `range`; a value typed beyond it is taken as typed. Both parts bear the name `label`.
pub(crate) fn slide<N: Numeric>(
    ui: &mut egui::Ui,
    label: &str,
    value: &mut N,
    range: RangeInclusive<N>,
    suffix: &str,
) -> Slid {
    let (low, high) = (range.start().to_f64(), range.end().to_f64());
    // Over several powers of ten equal steps would make the low end unreachable.
    let wide = low > 0.0 && high / low >= 1000.0;
    let speed = match wide {
        true => value.to_f64().abs().max(low) / 100.0,
        false => (high - low) / 300.0,
    };
    ui.horizontal(|ui| {
        // All but what the field takes: a longer way tells more values apart.
        ui.spacing_mut().slider_width = (ui.available_width() - FIELD).clamp(60.0, 240.0);
        let before = *value;
        let slider = egui::Slider::new(value, range)
            .clamping(SliderClamping::Never)
            .logarithmic(wide)
            .show_value(false);
        let slider = named(ui.add(slider), label);
        // Whoever clicks right looks for a menu, and means no value.
        let other = ui.input(|input| input.pointer.secondary_down() || input.pointer.middle_down());
        if other {
            *value = before;
        }
        let slid = slider.changed() && !other;
        let field = named(ui.add(egui::DragValue::new(value).speed(speed).suffix(suffix)), label);
        let over = |part: &egui::Response| part.drag_stopped() || part.lost_focus();
        Slid { changed: slid || field.changed(), done: over(&slider) || over(&field) }
    })
    .inner
}
