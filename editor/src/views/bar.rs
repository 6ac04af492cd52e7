//! The bar over a pane: which output it shows, whether it stays with it, and how it shows it.

use eframe::egui;
use orograph_core::ValueType;
use orograph_edit::looks;
use orograph_engine::{Registry, document::Link};

use super::{Asked, Mode, Offer, Pane};
use crate::inspector::named;

impl Pane {
    /// What it shows, and how; `other` is what the other pane shows.
    pub(super) fn bar(
        &self,
        ui: &mut egui::Ui,
        registry: &Registry,
        offer: &Offer,
        other: Option<&Link>,
        asked: &mut Vec<Asked>,
    ) {
        ui.horizontal(|ui| {
            let own = self.output.as_ref().map_or_else(|| "nothing".to_owned(), ToString::to_string);
            let against = other.filter(|_| self.compares());
            let title = against.map_or_else(|| own.clone(), |other| format!("{own} − {other}"));
            if offer.outputs.len() > 1 {
                let text = egui::RichText::new(title).strong();
                let salt = (&self.name, "output");
                let shown = egui::ComboBox::from_id_salt(salt).selected_text(text).show_ui(ui, |ui| {
                    for output in &offer.outputs {
                        let chosen = self.output.as_ref() == Some(output);
                        if ui.selectable_label(chosen, &output.port).clicked() {
                            asked.push(Asked::Output(output.clone()));
                        }
                    }
                });
                named(shown.response, &format!("output in {}", self.name));
            } else {
                ui.strong(title);
            }
            let mut pinned = self.pinned.is_some();
            if ui.checkbox(&mut pinned, "pin").on_hover_text("Stay with this output").changed() {
                asked.push(Asked::Pin(pinned));
            }
            if let Some(value_type) = offer.value_type {
                self.ways(ui, registry, value_type, other, asked);
            }
        });
    }

    /// The ways to show a value of the type.
    fn ways(
        &self,
        ui: &mut egui::Ui,
        registry: &Registry,
        value_type: ValueType,
        other: Option<&Link>,
        asked: &mut Vec<Asked>,
    ) {
        if value_type == ValueType::Table {
            let plot = self.mode == Mode::Plot;
            if ui.selectable_label(!plot, "table").clicked() {
                asked.push(Asked::Mode(Mode::First));
            }
            if ui.selectable_label(plot, "plot").clicked() {
                asked.push(Asked::Mode(Mode::Plot));
            }
            return;
        }
        let looks = looks::of(registry, value_type);
        if looks.is_empty() {
            return;
        }
        let comparable = other.is_some() && looks::can_be_compared(value_type);
        let now = match comparable && self.compares() {
            true => looks::DIFFERENCE.to_owned(),
            false => self.look(registry, value_type).unwrap_or_default(),
        };
        let short = |id: &str| match id {
            looks::DIFFERENCE => "difference".to_owned(),
            _ => id.rsplit('.').next().unwrap_or(id).replace('_', " "),
        };
        let mut choose = |id: &str| {
            asked.push(Asked::Mode(match &self.mode {
                Mode::Ground(_) => Mode::Ground(Some(id.to_owned())),
                _ => Mode::Look(id.to_owned()),
            }));
        };
        let salt = (&self.name, "look");
        let shown = egui::ComboBox::from_id_salt(salt).selected_text(short(&now)).show_ui(ui, |ui| {
            for spec in &looks {
                let response =
                    ui.selectable_label(*spec.id == *now, short(&spec.id)).on_hover_text(spec.summary());
                if response.clicked() {
                    choose(&spec.id);
                }
            }
            if comparable {
                let response = ui.selectable_label(now == looks::DIFFERENCE, "difference");
                if response.on_hover_text("How far this lies above what the other view shows").clicked() {
                    choose(looks::DIFFERENCE);
                }
            }
        });
        named(shown.response, &format!("look of {}", self.name));
        if value_type == ValueType::Heightfield || self.ground.has_terrain() {
            let solid = matches!(self.mode, Mode::Ground(_));
            if ui.selectable_label(!solid, "2D").clicked() {
                asked.push(Asked::Mode(Mode::Look(now.clone())));
            }
            if ui.selectable_label(solid, "3D").clicked() {
                asked.push(Asked::Mode(Mode::Ground(Some(now))));
            }
        }
    }
}
