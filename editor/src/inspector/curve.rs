//! A curve by its points: dragged, added by a double click, taken away by a right click.

use eframe::egui::{self, Pos2, Rect, Stroke, pos2, vec2};
use orograph_core::ParamValue;

use super::{named, param::Answer};

const SIZE: egui::Vec2 = vec2(240.0, 140.0);
const RADIUS: f32 = 5.0;

pub(super) fn edit(
    ui: &mut egui::Ui,
    label: &str,
    x: (f64, f64),
    y: (f64, f64),
    points: &[[f64; 2]],
) -> Answer {
    let (rect, response) = ui.allocate_exact_size(SIZE, egui::Sense::click_and_drag());
    let response = named(response, label)
        .on_hover_text("Drag a point; a double click adds one, a right click takes one away");
    let view = View { rect: rect.shrink(RADIUS), x: seen(x, points, 0), y: seen(y, points, 1) };
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let line: Vec<Pos2> = points.iter().map(|point| view.place(*point)).collect();
    painter.line(line.clone(), Stroke::new(2.0, ui.visuals().strong_text_color()));
    for place in &line {
        painter.circle_filled(*place, RADIUS, ui.visuals().selection.bg_fill);
    }
    let Some(pointer) = response.interact_pointer_pos() else { return Answer::default() };
    let near = |place: &Pos2| place.distance(pointer) <= 2.5 * RADIUS;
    let held = ui.data(|data| data.get_temp::<usize>(response.id));
    let mut next = points.to_vec();
    let mut done = false;
    // A drag is told of once the pointer has moved away from where it began.
    let begun = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
    if response.drag_started()
        && let Some(index) = line.iter().position(|place| place.distance(begun) <= 2.5 * RADIUS)
    {
        ui.data_mut(|data| data.insert_temp(response.id, index));
    } else if response.dragged()
        && let Some(index) = held.filter(|index| *index < points.len())
    {
        let [px, py] = view.value(pointer);
        // Points keep their order: none passes its neighbours.
        let gap = (view.x.1 - view.x.0) * 1e-3;
        let low = if index > 0 { points[index - 1][0] + gap } else { x.0 };
        let high = points.get(index + 1).map_or(x.1, |after| after[0] - gap);
        if low <= high {
            next[index] = [px.clamp(low, high), py.clamp(y.0, y.1)];
        }
    } else if response.double_clicked() {
        let at = view.value(pointer);
        let index = points.partition_point(|point| point[0] < at[0]);
        if points.get(index).is_none_or(|point| point[0] > at[0]) {
            next.insert(index, [at[0].clamp(x.0, x.1), at[1].clamp(y.0, y.1)]);
        }
        done = true;
    } else if response.secondary_clicked()
        && points.len() > 1
        && let Some(index) = line.iter().position(near)
    {
        next.remove(index);
        done = true;
    }
    if response.drag_stopped() {
        ui.data_mut(|data| data.remove::<usize>(response.id));
        done = true;
    }
    let value = (next != points).then_some(ParamValue::Curve(next));
    Answer { value, done, file: None }
}

/// The part of an axis that is shown: all of a short one, of a long one what the points use.
fn seen(limits: (f64, f64), points: &[[f64; 2]], axis: usize) -> (f64, f64) {
    let used = points.iter().map(|point| point[axis]);
    let low = used.clone().fold(f64::INFINITY, f64::min);
    let high = used.fold(f64::NEG_INFINITY, f64::max);
    let span = high - low;
    if span > 0.0 && limits.1 - limits.0 > 20.0 * span {
        return ((low - span * 0.25).max(limits.0), (high + span * 0.25).min(limits.1));
    }
    if (limits.1 - limits.0).is_finite() { limits } else { (low - 1.0, high + 1.0) }
}

struct View {
    rect: Rect,
    x: (f64, f64),
    y: (f64, f64),
}

impl View {
    fn place(&self, [x, y]: [f64; 2]) -> Pos2 {
        let share = |value: f64, (low, high): (f64, f64)| ((value - low) / (high - low)) as f32;
        let (x, y) = (share(x, self.x), share(y, self.y));
        pos2(self.rect.left() + x * self.rect.width(), self.rect.bottom() - y * self.rect.height())
    }

    fn value(&self, pos: Pos2) -> [f64; 2] {
        let x = f64::from((pos.x - self.rect.left()) / self.rect.width());
        let y = f64::from((self.rect.bottom() - pos.y) / self.rect.height());
        [self.x.0 + x * (self.x.1 - self.x.0), self.y.0 + y * (self.y.1 - self.y.0)]
    }
}
