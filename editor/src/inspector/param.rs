//! One widget for each kind of parameter.

use eframe::egui;
use orograph_core::{ParamKind, ParamSpec, ParamValue, Unit};

use super::{
    colour, curve, named,
    slide::{Slid, slide},
};

/// What came of a widget in this frame.
#[derive(Default)]
pub(super) struct Answer {
    /// Another value.
    pub(super) value: Option<ParamValue>,
    /// The widget was let go: what it did is one step.
    pub(super) done: bool,
    /// A file is asked for; to be written when true.
    pub(super) file: Option<bool>,
}

/// Draws the widget for a parameter. `label` is what assistive technology calls it.
pub(super) fn edit(ui: &mut egui::Ui, label: &str, spec: &ParamSpec, value: &ParamValue) -> Answer {
    let unit = match spec.unit.symbol() {
        "1" | "seed" => String::new(),
        symbol => format!(" {symbol}"),
    };
    match (&spec.kind, value) {
        (ParamKind::Number { slider, .. }, ParamValue::Number(number)) => {
            let mut number = *number;
            let slid = slide(ui, label, &mut number, slider.0..=slider.1, &unit);
            slid_to(&slid, ParamValue::Number(number))
        }
        (ParamKind::Integer { range, .. }, ParamValue::Integer(integer)) if spec.unit == Unit::Seed => {
            seed(ui, label, *range, *integer)
        }
        (ParamKind::Integer { slider, .. }, ParamValue::Integer(integer)) => {
            let mut integer = *integer;
            let slid = slide(ui, label, &mut integer, slider.0..=slider.1, &unit);
            slid_to(&slid, ParamValue::Integer(integer))
        }
        (ParamKind::Boolean, ParamValue::Boolean(on)) => {
            let mut on = *on;
            let response = ui.checkbox(&mut on, "");
            let changed = response.changed();
            named(response, label);
            Answer { value: changed.then_some(ParamValue::Boolean(on)), done: changed, file: None }
        }
        (ParamKind::Choice { options }, ParamValue::Text(chosen)) => choice(ui, label, options, chosen),
        (ParamKind::Text, ParamValue::Text(text)) => line(ui, label, text, 220.0),
        (ParamKind::InputPath | ParamKind::OutputPath, ParamValue::Text(text)) => {
            let mut result = Answer::default();
            ui.horizontal(|ui| {
                result = line(ui, label, text, 180.0);
                if named(ui.small_button("…"), &format!("choose a file for {label}")).clicked() {
                    result.file = Some(spec.kind == ParamKind::OutputPath);
                }
            });
            result
        }
        (ParamKind::Colour, ParamValue::Text(text)) => colour::edit(ui, label, text),
        (ParamKind::Gradient, ParamValue::Text(text)) => colour::gradient(ui, label, text),
        (ParamKind::Curve { x, y }, ParamValue::Curve(points)) => curve::edit(ui, label, *x, *y, points),
        (ParamKind::Lines { .. }, ParamValue::Lines(lines)) => {
            let mut result = Answer::default();
            ui.horizontal(|ui| {
                let points: usize = lines.iter().map(Vec::len).sum();
                ui.label(format!("{} lines, {points} points; drawn in the picture", lines.len()));
                if !lines.is_empty() && named(ui.small_button("clear"), &format!("clear {label}")).clicked() {
                    result = Answer { value: Some(ParamValue::Lines(Vec::new())), done: true, file: None };
                }
            });
            result
        }
        _ => {
            ui.weak("a kind of setting that this editor cannot show; edit the file");
            Answer::default()
        }
    }
}

fn slid_to(slid: &Slid, value: ParamValue) -> Answer {
    Answer { value: slid.changed.then_some(value), done: slid.done, file: None }
}

fn answer(response: &egui::Response, label: &str, value: ParamValue) -> Answer {
    named(response.clone(), label);
    Answer {
        value: response.changed().then_some(value),
        done: response.drag_stopped() || response.lost_focus(),
        file: None,
    }
}

fn seed(ui: &mut egui::Ui, label: &str, range: (i64, i64), seed: i64) -> Answer {
    let mut next = seed;
    let mut result = Answer::default();
    ui.horizontal(|ui| {
        let response = ui.add(egui::DragValue::new(&mut next).speed(0.1));
        result = answer(&response, label, ParamValue::Integer(next));
        let die = ui.small_button("🎲").on_hover_text("Another one");
        if named(die, &format!("roll {label}")).clicked() {
            // Another one each time, and the same row of them for everyone.
            let mixed = (seed as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let rolled = ((mixed >> 44) as i64).clamp(range.0, range.1);
            result = Answer { value: Some(ParamValue::Integer(rolled)), done: true, file: None };
        }
    });
    result
}

fn choice(ui: &mut egui::Ui, label: &str, options: &[orograph_core::ChoiceOption], chosen: &str) -> Answer {
    let words = |name: &str| name.replace('_', " ");
    let mut next = None;
    let combo = egui::ComboBox::from_id_salt(label).selected_text(words(chosen));
    let response = combo.show_ui(ui, |ui| {
        for option in options {
            let response = ui.selectable_label(option.name == chosen, words(&option.name));
            if response.on_hover_text(option.doc.as_ref()).clicked() {
                next = Some(option.name.to_string());
            }
        }
    });
    named(response.response, label);
    let value = next.filter(|next| next != chosen).map(ParamValue::Text);
    Answer { done: value.is_some(), value, file: None }
}

fn line(ui: &mut egui::Ui, label: &str, text: &str, width: f32) -> Answer {
    let mut text = text.to_owned();
    let response = ui.add(egui::TextEdit::singleline(&mut text).desired_width(width));
    answer(&response, label, ParamValue::Text(text))
}
