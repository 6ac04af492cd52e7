//! Colours: chosen from a field of them or typed, and gradients by their stops.

use eframe::egui::{self, Color32, Mesh, Pos2, Rect, Stroke, pos2, vec2};
use orograph_core::{Colour, Gradient, ParamValue};

use super::{named, param::Answer};

/// A colour, as a graph writes it.
pub(super) fn edit(ui: &mut egui::Ui, label: &str, text: &str) -> Answer {
    let mut result = Answer::default();
    ui.horizontal(|ui| {
        let colour = text.parse().unwrap_or(Colour::rgb(0));
        let (chosen, done) = swatch(ui, &format!("choose {label}"), colour);
        let typed = hex(ui, label, text);
        let chosen = chosen.map(|colour| ParamValue::Text(colour.to_string()));
        result = Answer { value: chosen.or(typed.value), done: done || typed.done, file: None };
    });
    result
}

/// A button that opens a field of colours; another colour, and whether the choice is over.
fn swatch(ui: &mut egui::Ui, label: &str, colour: Colour) -> (Option<Colour>, bool) {
    let [r, g, b, a] = colour.0;
    let mut shown = Color32::from_rgba_unmultiplied(r, g, b, a);
    let alpha = egui::color_picker::Alpha::OnlyBlend;
    let response = egui::color_picker::color_edit_button_srgba(ui, &mut shown, alpha);
    let response = named(response, label);
    let under_way = response.id.with("under way");
    if response.changed() {
        ui.data_mut(|data| data.insert_temp(under_way, true));
    }
    // The field is another widget: that the hand lets go is all that is known of its end.
    let lets_go = ui.input(|input| input.pointer.any_released());
    let done = lets_go && ui.data_mut(|data| data.remove_temp::<bool>(under_way)).is_some();
    let chosen = (response.changed()).then(|| Colour(shown.to_srgba_unmultiplied()));
    (chosen, done)
}

/// A line for the colour's text. What is no colour yet stays in the line while it is typed.
fn hex(ui: &mut egui::Ui, label: &str, text: &str) -> Answer {
    let id = ui.id().with((label, "draft"));
    let mut draft = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| text.to_owned());
    let response = ui.add(egui::TextEdit::singleline(&mut draft).desired_width(90.0));
    let response = named(response, label);
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, draft.clone()));
    }
    let ends = response.lost_focus();
    if ends {
        ui.data_mut(|data| data.remove::<String>(id));
    }
    let is_colour = draft.parse::<Colour>().is_ok();
    let tells = if is_colour { response.changed() || ends } else { ends };
    Answer { value: (tells && draft != text).then_some(ParamValue::Text(draft)), done: ends, file: None }
}

const BAR: egui::Vec2 = vec2(240.0, 36.0);
/// Height of what shows the colours; the stops stand below.
const COLOURS: f32 = 22.0;
const REACH: f32 = 8.0;
/// Stops are no nearer to each other.
const GAP: f64 = 1e-3;

/// A gradient: stops are dragged, added by a double click and taken away by a right click.
pub(super) fn gradient(ui: &mut egui::Ui, label: &str, text: &str) -> Answer {
    let gradient: Gradient = text.parse().unwrap_or_default();
    if gradient.stops().is_empty() {
        let mut result = Answer::default();
        ui.horizontal(|ui| {
            ui.weak("none");
            if named(ui.small_button("make one"), &format!("make {label}")).clicked() {
                let value = Some(ParamValue::Text("0 #000000, 1 #ffffff".into()));
                result = Answer { value, done: true, file: None };
            }
        });
        return result;
    }
    let mut stops = gradient.stops().to_vec();
    let (rect, response) = ui.allocate_exact_size(BAR, egui::Sense::click_and_drag());
    let response = named(response, label)
        .on_hover_text("Drag a stop; a double click adds one, a right click takes one away");
    let chosen_id = response.id.with("chosen");
    let mut chosen = ui.data(|data| data.get_temp::<usize>(chosen_id)).unwrap_or(0).min(stops.len() - 1);
    let bar = Rect::from_min_size(rect.min, vec2(rect.width(), COLOURS)).shrink2(vec2(REACH, 0.0));
    paint(ui, bar, &gradient, chosen);
    let mut done = response.drag_stopped();
    if let Some(pointer) = response.interact_pointer_pos() {
        let share = |pos: Pos2| f64::from((pos.x - bar.left()) / bar.width()).clamp(0.0, 1.0);
        let x = |stop: &(f64, Colour)| bar.left() + stop.0 as f32 * bar.width();
        let near = |pos: Pos2| stops.iter().position(|stop| (x(stop) - pos.x).abs() <= REACH);
        let begun = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
        if response.drag_started() {
            match near(begun) {
                Some(index) => chosen = index,
                None => {
                    ui.data_mut(|data| data.insert_temp(response.id, true));
                }
            }
        } else if response.dragged() && ui.data(|data| data.get_temp::<bool>(response.id)).is_none() {
            // Stops keep their order: none passes its neighbours.
            let low = if chosen > 0 { stops[chosen - 1].0 + GAP } else { 0.0 };
            let high = stops.get(chosen + 1).map_or(1.0, |after| after.0 - GAP);
            if low <= high {
                // Thousandths are as fine as a hand is.
                stops[chosen].0 = ((share(pointer) * 1e3).round() / 1e3).clamp(low, high);
            }
        } else if response.double_clicked() {
            let at = (share(pointer) * 1e3).round() / 1e3;
            let index = stops.partition_point(|stop| stop.0 < at);
            let apart = |stop: Option<&(f64, Colour)>| stop.is_none_or(|stop| (stop.0 - at).abs() >= GAP);
            if apart(stops.get(index)) && apart(index.checked_sub(1).and_then(|before| stops.get(before))) {
                stops.insert(index, (at, gradient.at(at).unwrap_or(Colour::rgb(0))));
                (chosen, done) = (index, true);
            }
        } else if response.secondary_clicked() && stops.len() > 1 {
            if let Some(index) = near(pointer) {
                stops.remove(index);
                (chosen, done) = (chosen.min(stops.len() - 1), true);
            }
        } else if response.clicked()
            && let Some(index) = near(pointer)
        {
            chosen = index;
        }
    }
    if response.drag_stopped() {
        ui.data_mut(|data| data.remove::<bool>(response.id));
    }
    ui.data_mut(|data| data.insert_temp(chosen_id, chosen));
    let mut refused = None;
    ui.horizontal(|ui| {
        let (colour, over) = swatch(ui, &format!("choose the stop of {label}"), stops[chosen].1);
        if let Some(colour) = colour {
            stops[chosen].1 = colour;
        }
        done |= over;
        let typed = hex(ui, &format!("colour of the stop of {label}"), &stops[chosen].1.to_string());
        if let Some(ParamValue::Text(text)) = typed.value {
            match text.parse() {
                Ok(colour) => stops[chosen].1 = colour,
                // The refusal says why.
                Err(_) => refused = Some(format!("{} {text}", stops[chosen].0)),
            }
        }
        done |= typed.done;
        ui.weak(format!("at {}", stops[chosen].0));
    });
    let next = Gradient::new(stops).ok().filter(|next| *next != gradient);
    let text = refused.or_else(|| next.map(|next| next.to_string()));
    Answer { value: text.map(ParamValue::Text), done, file: None }
}

/// The colours from left to right, and marks where stops stand.
fn paint(ui: &egui::Ui, bar: Rect, gradient: &Gradient, chosen: usize) {
    const STEPS: u32 = 96;
    let mut mesh = Mesh::default();
    for step in 0..=STEPS {
        let share = f64::from(step) / f64::from(STEPS);
        let Colour([r, g, b, a]) = gradient.at(share).unwrap_or(Colour::rgb(0));
        let colour = Color32::from_rgba_unmultiplied(r, g, b, a);
        let x = bar.left() + share as f32 * bar.width();
        mesh.colored_vertex(pos2(x, bar.top()), colour);
        mesh.colored_vertex(pos2(x, bar.bottom()), colour);
        if step > 0 {
            let at = 2 * step;
            mesh.add_triangle(at - 2, at - 1, at);
            mesh.add_triangle(at - 1, at, at + 1);
        }
    }
    let painter = ui.painter();
    painter.add(mesh);
    let visuals = ui.visuals();
    for (index, (place, Colour([r, g, b, _]))) in gradient.stops().iter().enumerate() {
        let x = bar.left() + *place as f32 * bar.width();
        let mark =
            [pos2(x, bar.bottom()), pos2(x - 5.0, bar.bottom() + 11.0), pos2(x + 5.0, bar.bottom() + 11.0)];
        let stroke =
            if index == chosen { visuals.selection.stroke } else { Stroke::new(1.0, visuals.text_color()) };
        painter.add(egui::Shape::convex_polygon(mark.to_vec(), Color32::from_rgb(*r, *g, *b), stroke));
    }
}
