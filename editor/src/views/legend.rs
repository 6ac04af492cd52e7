//! What the colours of a picture mean: a bar of them with numbers.

use eframe::egui::{self, Align, Align2, Color32, Mesh, Rect, Sense, pos2, vec2};
use orograph_core::Choice;
use orograph_edit::looks::{Colours, Scale};
use orograph_nodes::look::{
    colour::{self, PAPER, Palette},
    ticks,
};

use super::numbers::within;

/// Steps that the bar is drawn in.
const STEPS: usize = 64;

/// A bar of colours from a least to a greatest number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Legend {
    colours: Vec<Color32>,
    low: f64,
    high: f64,
    unit: &'static str,
}

impl Legend {
    /// The legend of a scale; none when its palette is not known here.
    pub(super) fn new(scale: &Scale) -> Option<Self> {
        let colour_at: Box<dyn Fn(f64) -> [u8; 4]> = match &scale.colours {
            Colours::Palette(name) => {
                let palette = Palette::parse(name)?;
                Box::new(move |share| palette.at(share))
            }
            Colours::Diverging => Box::new(|share| Palette::Diverging.at(share)),
            Colours::Tint { colour, opacity } => {
                let (tint, opacity) = (colour.parse::<orograph_core::Colour>().ok()?.0, *opacity);
                Box::new(move |share| colour::blend(PAPER, tint, share * opacity))
            }
        };
        let colours = (0..STEPS).map(|i| {
            let [r, g, b, _] = colour_at(i as f64 / (STEPS - 1) as f64);
            Color32::from_rgb(r, g, b)
        });
        let (low, high, unit) = (scale.low, scale.high, scale.unit.symbol());
        Some(Self { colours: colours.collect(), low, high, unit })
    }

    /// Both ends in words.
    pub(super) fn words(&self) -> String {
        let sign = if self.low < 0.0 && self.high > 0.0 { "+" } else { "" };
        let [low, high] = [self.low, self.high].map(|value| within(value, self.high - self.low, self.unit));
        format!("colours from {low} to {sign}{high}")
    }

    /// Draws it into an upper corner of `rect`, the left or the right one.
    pub(super) fn ui(&self, ui: &egui::Ui, rect: Rect, side: Align, id: egui::Id) {
        const BAR: f32 = 14.0;
        let tall = (rect.height() - 60.0).min(180.0);
        if tall < 40.0 {
            return;
        }
        let font = egui::FontId::proportional(11.0);
        let painter = ui.painter_at(rect);
        let marks = self.marks(tall);
        let texts: Vec<_> = marks
            .iter()
            .map(|(value, text)| (*value, painter.layout_no_wrap(text.clone(), font.clone(), Color32::WHITE)))
            .collect();
        let widest = texts.iter().map(|(_, text)| text.size().x).fold(0.0, f32::max);
        let size = vec2(BAR + widest + 20.0, tall + 20.0);
        let ground = Align2([side, Align::Min]).align_size_within_rect(size, rect.shrink(6.0));
        painter.rect_filled(ground, 3.0, Color32::from_black_alpha(170));
        let bar = Rect::from_min_size(ground.min + vec2(6.0, 10.0), vec2(BAR, tall));
        painter.add(self.bar(bar));
        for (value, text) in texts {
            let share = ((value - self.low) / (self.high - self.low)) as f32;
            let y = bar.bottom() - share.clamp(0.0, 1.0) * bar.height();
            let line = [pos2(bar.right(), y), pos2(bar.right() + 3.0, y)];
            painter.line_segment(line, egui::Stroke::new(1.0, Color32::WHITE));
            let at = Align2::LEFT_CENTER.anchor_size(pos2(bar.right() + 6.0, y), text.size());
            painter.galley(at.min, text, Color32::WHITE);
        }
        let words = self.words();
        let response = ui.interact(ground, id, Sense::hover());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Label, true, words.clone()));
    }

    /// Both ends, and round numbers between them that stand clear of the ends.
    fn marks(&self, tall: f32) -> Vec<(f64, String)> {
        let ends = [self.low, self.high].map(|value| (value, self.text(value)));
        let range = self.high - self.low;
        if range.is_nan() || range <= 0.0 {
            return ends[..1].to_vec();
        }
        let clear = f64::from(14.0 / tall) * range;
        let between = ticks::linear(self.low, self.high, f64::from(tall / 36.0));
        let between = between.into_iter().filter(|tick| {
            tick.value - self.low > clear && self.high - tick.value > clear && !tick.label.is_empty()
        });
        let between = between.map(|tick| (tick.value, self.text(tick.value)));
        ends.into_iter().chain(between).collect()
    }

    fn text(&self, value: f64) -> String {
        let text = within(value, self.high - self.low, self.unit);
        if self.low < 0.0 && self.high > 0.0 && value > 0.0 { format!("+{text}") } else { text }
    }

    fn bar(&self, rect: Rect) -> egui::Shape {
        let mut mesh = Mesh::default();
        let last = (self.colours.len().max(2) - 1) as f32;
        for (i, colour) in self.colours.iter().enumerate() {
            let y = rect.bottom() - rect.height() * i as f32 / last;
            mesh.colored_vertex(pos2(rect.left(), y), *colour);
            mesh.colored_vertex(pos2(rect.right(), y), *colour);
            if let Some(before) = u32::try_from(i).unwrap_or(0).checked_sub(1) {
                let at = before * 2;
                mesh.add_triangle(at, at + 1, at + 2);
                mesh.add_triangle(at + 1, at + 3, at + 2);
            }
        }
        egui::Shape::mesh(mesh)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::Unit;

    use super::*;

    #[test]
    fn a_difference_is_white_at_zero_and_as_wide_on_both_sides() {
        let scale = Scale { colours: Colours::Diverging, low: -20.0, high: 20.0, unit: Unit::Metre };
        let legend = Legend::new(&scale).unwrap();
        let [below, above] = [STEPS / 2 - 1, STEPS / 2].map(|i| legend.colours[i]);
        assert!(below.r() > 235 && below.g() > 235 && above.g() > 235, "{below:?} {above:?}");
        assert!(legend.colours[0].b() > legend.colours[0].r(), "blue below");
        assert!(legend.colours[STEPS - 1].r() > legend.colours[STEPS - 1].b(), "red above");
        assert_eq!(legend.words(), "colours from -20 m to +20 m");
    }

    #[test]
    fn numbers_beside_the_bar_are_its_ends_and_round_ones_that_stand_clear() {
        let colours = Colours::Palette("atlas".into());
        let scale = Scale { colours, low: 312.4, high: 1204.0, unit: Unit::Metre };
        let marks = Legend::new(&scale).unwrap().marks(180.0);
        let values: Vec<f64> = marks.iter().map(|(value, _)| *value).collect();
        assert_eq!(values[..2], [312.4, 1204.0]);
        assert!(values[2..].iter().all(|value| value % 100.0 == 0.0), "{values:?}");
        assert!(values[2..].iter().all(|value| (400.0..=1130.0).contains(value)), "{values:?}");
    }

    #[test]
    fn level_ground_has_one_number() {
        let colours = Colours::Palette("atlas".into());
        let scale = Scale { colours, low: 5.0, high: 5.0, unit: Unit::Metre };
        assert_eq!(Legend::new(&scale).unwrap().marks(180.0).len(), 1);
    }
}
