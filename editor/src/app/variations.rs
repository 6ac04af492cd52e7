//! Pictures for several values of one parameter; a click takes one.

use std::collections::HashMap;

use eframe::egui;
use orograph_core::{ParamKind, ParamSpec, ParamValue, Unit};
use orograph_edit::{Beside, Fault, Shown, Wish};
use orograph_engine::document::{Link, Literal};

use super::App;
use crate::{inspector::named, views::thumbnail};

/// Values in a grid of pictures.
const SIDE: usize = 3;

/// The open grid.
pub(super) struct Variations {
    param: Link,
    output: Link,
    look: String,
    values: Vec<ParamValue>,
    pictures: HashMap<String, Result<egui::TextureHandle, String>>,
}

impl Variations {
    /// Nine values over what the slider offers; of a seed the next nine.
    pub(super) fn new(param: Link, spec: &ParamSpec, output: Link, look: String) -> Self {
        let n = SIDE * SIDE;
        let share = |i: usize| i as f64 / (n - 1) as f64;
        let mut values: Vec<ParamValue> = match &spec.kind {
            ParamKind::Number { slider: (low, high), .. } => {
                (0..n).map(|i| ParamValue::Number(low + share(i) * (high - low))).collect()
            }
            ParamKind::Integer { .. } if spec.unit == Unit::Seed => {
                (0..n).map(|i| ParamValue::Integer(i as i64)).collect()
            }
            ParamKind::Integer { slider: (low, high), .. } => {
                let at = |i| *low + (share(i) * (high - low) as f64).round() as i64;
                (0..n).map(|i| ParamValue::Integer(at(i))).collect()
            }
            ParamKind::Choice { options } => {
                options.iter().take(n).map(|option| ParamValue::Text(option.name.to_string())).collect()
            }
            _ => Vec::new(),
        };
        values.dedup();
        Self { param, output, look, values, pictures: HashMap::new() }
    }

    fn name(&self, index: usize) -> String {
        format!("variation {index} of {}", self.param)
    }

    /// Whether an answer of this name belongs here.
    pub(super) fn has(&self, name: &str) -> bool {
        (0..self.values.len()).any(|index| self.name(index) == name)
    }

    pub(super) fn wishes(&self) -> Vec<Wish> {
        let wish = |(index, value): (usize, &ParamValue)| Wish {
            name: self.name(index),
            output: self.output.clone(),
            look: Some(self.look.clone()),
            beside: Beside::Nothing,
            overrides: vec![(self.param.to_string(), Literal::from(value).to_ron())],
        };
        self.values.iter().enumerate().map(wish).collect()
    }

    pub(super) fn take(&mut self, ctx: &egui::Context, name: &str, result: Result<Shown, Vec<Fault>>) {
        let picture = match result {
            Ok(shown) => thumbnail(ctx, name, &shown).ok_or_else(|| "no picture".to_owned()),
            Err(faults) => Err(faults.into_iter().map(|fault| fault.message).collect::<Vec<_>>().join("; ")),
        };
        self.pictures.insert(name.to_owned(), picture);
    }
}

impl App {
    pub(super) fn variations_ui(&mut self, ctx: &egui::Context) {
        let Some(variations) = &self.variations else { return };
        let (mut open, mut chosen) = (true, None);
        let title = format!("Variations of {}", variations.param);
        egui::Window::new(title).id("variations".into()).open(&mut open).resizable(false).show(ctx, |ui| {
            egui::Grid::new("grid of variations").show(ui, |ui| {
                for (index, value) in variations.values.iter().enumerate() {
                    ui.vertical(|ui| {
                        ui.set_min_size(egui::vec2(130.0, 150.0));
                        let text = Literal::from(value).to_ron();
                        match variations.pictures.get(&variations.name(index)) {
                            Some(Ok(picture)) => {
                                let image = egui::Image::new((picture.id(), egui::vec2(128.0, 128.0)));
                                let button = ui.add(egui::Button::image(image));
                                if named(button, &format!("take {text}")).clicked() {
                                    chosen = Some(value.clone());
                                }
                            }
                            Some(Err(reason)) => {
                                ui.colored_label(crate::theme::FAULT, reason);
                            }
                            None => {
                                ui.spinner();
                            }
                        }
                        ui.label(text);
                    });
                    if (index + 1) % SIDE == 0 {
                        ui.end_row();
                    }
                }
            });
        });
        if let Some(value) = chosen {
            let param = variations.param.clone();
            self.set(&param, &value);
            self.editing.end_gesture();
            open = false;
        }
        if !open {
            self.variations = None;
        }
    }
}
