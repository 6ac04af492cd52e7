//! Adding a node by a few letters of its name or of what it does.

use eframe::egui::{self, Key, Pos2};
use orograph_core::{Arity, NodeSpec, ValueType};
use orograph_engine::{Registry, document::Link};

use crate::{inspector::named, theme};

/// A wire that was let go over empty space and wants a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loose {
    /// The port that it starts from.
    pub(crate) port: Link,
    /// That port is an output.
    pub(crate) is_output: bool,
    /// The type of the wire.
    pub(crate) value_type: Option<ValueType>,
}

/// The open search.
pub(crate) struct Search {
    /// Where the node will stand, in the graph.
    pub(crate) place: (f64, f64),
    /// Where the list stands, in the window.
    pub(crate) at: Pos2,
    /// The wire to join.
    pub(crate) loose: Option<Loose>,
    query: String,
    chosen: usize,
    fresh: bool,
}

/// What came of it.
pub(crate) enum Found {
    /// Nothing yet.
    Open,
    /// It was closed.
    Closed,
    /// This type.
    Type(String),
}

impl Search {
    pub(crate) fn new(place: (f64, f64), at: Pos2, loose: Option<Loose>) -> Self {
        Self { place, at, loose, query: String::new(), chosen: 0, fresh: true }
    }

    pub(crate) fn ui(&mut self, ctx: &egui::Context, registry: &Registry) -> Found {
        /// As many as are listed.
        const MOST: usize = 200;
        /// How high the list may be.
        const LIST: f32 = 320.0;
        let mut found = Found::Open;
        let matches = self.matches(registry);
        let (up, down, enter, escape) = ctx.input_mut(|input| {
            let mut pressed = |key| input.consume_key(egui::Modifiers::NONE, key);
            (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter), pressed(Key::Escape))
        });
        if escape {
            return Found::Closed;
        }
        let last = matches.len().min(MOST).saturating_sub(1);
        self.chosen = self.chosen.min(last);
        if down {
            self.chosen = (self.chosen + 1).min(last);
        }
        if up {
            self.chosen = self.chosen.saturating_sub(1);
        }
        if enter && let Some(spec) = matches.get(self.chosen) {
            return Found::Type(spec.id.to_string());
        }
        let area = egui::Area::new("search".into())
            .order(egui::Order::Foreground)
            .fixed_pos(self.at)
            .constrain(true);
        // The click that opened the list fell elsewhere.
        let opened_now = self.fresh;
        let shown = area.show(ctx, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(460.0);
                // As much as the list may take, and not what it took when it was last seen.
                ui.set_max_height(LIST + 60.0);
                if let Some(Loose { value_type: Some(value_type), is_output, .. }) = &self.loose {
                    ui.weak(if *is_output {
                        format!("takes a {value_type}")
                    } else {
                        format!("gives a {value_type}")
                    });
                }
                let edit = egui::TextEdit::singleline(&mut self.query).hint_text("Search nodes");
                let response = named(ui.add(edit.desired_width(f32::INFINITY)), "search nodes");
                if std::mem::take(&mut self.fresh) {
                    response.request_focus();
                }
                if response.changed() {
                    self.chosen = 0;
                }
                egui::ScrollArea::vertical().max_height(LIST).show(ui, |ui| {
                    for (index, spec) in matches.iter().take(MOST).enumerate() {
                        let dark = ui.visuals().dark_mode;
                        let text = egui::RichText::new(spec.id.as_ref()).color(if dark {
                            theme::family(spec.family(), false)
                        } else {
                            theme::family(spec.family(), true)
                        });
                        let line = ui.horizontal(|ui| {
                            let row = ui.selectable_label(index == self.chosen, text);
                            let summary = egui::RichText::new(spec.summary()).weak();
                            ui.add(egui::Label::new(summary).truncate().selectable(false));
                            row
                        });
                        let row = line.inner.on_hover_text(spec.summary());
                        if index == self.chosen && (up || down) {
                            row.scroll_to_me(None);
                        }
                        if row.clicked() {
                            found = Found::Type(spec.id.to_string());
                        }
                    }
                    if matches.is_empty() {
                        ui.weak("No node of that name fits here.");
                    }
                });
            });
        });
        if matches!(found, Found::Open) && shown.response.clicked_elsewhere() && !opened_now {
            found = Found::Closed;
        }
        found
    }

    /// The types that fit the wire and the words: first the one of just that name, then those whose name begins so, then
    /// those that hold the words in their name, then those that hold them in what they do.
    fn matches<'r>(&self, registry: &'r Registry) -> Vec<&'r NodeSpec> {
        let words: Vec<String> = self.query.to_lowercase().split_whitespace().map(str::to_owned).collect();
        let mut ranked: Vec<(usize, &NodeSpec)> = registry
            .iter()
            .map(|node_type| node_type.spec())
            .filter(|spec| self.loose.as_ref().is_none_or(|loose| takes(spec, loose)))
            .filter_map(|spec| Some((rank(spec, &words)?, spec)))
            .collect();
        ranked.sort_by_key(|(rank, spec)| (*rank, spec.id.clone()));
        ranked.into_iter().map(|(_, spec)| spec).collect()
    }
}

fn rank(spec: &NodeSpec, words: &[String]) -> Option<usize> {
    let id = spec.id.replace('_', " ");
    let algorithm = id.rsplit('.').next().unwrap_or(&id);
    let doc = spec.doc.to_lowercase();
    if algorithm.split(' ').eq(words) {
        return Some(0);
    }
    if words.first().is_some_and(|word| algorithm.starts_with(word.as_str()))
        && words.iter().all(|w| id.contains(w))
    {
        return Some(1);
    }
    if words.iter().all(|word| id.contains(word.as_str())) {
        return Some(2);
    }
    words.iter().all(|word| id.contains(word.as_str()) || doc.contains(word.as_str())).then_some(3)
}

fn takes(spec: &NodeSpec, loose: &Loose) -> bool {
    port_for(spec, loose).is_some()
}

/// The port of a type that a loose wire joins: needed ones before others.
pub(crate) fn port_for(spec: &NodeSpec, loose: &Loose) -> Option<String> {
    let ports = if loose.is_output { &spec.inputs } else { &spec.outputs };
    let fits =
        |port: &&orograph_core::PortSpec| loose.value_type.is_none_or(|wanted| port.value_type == wanted);
    let needed = ports.iter().filter(fits).find(|port| port.arity == Arity::One);
    needed.or_else(|| ports.iter().find(fits)).map(|port| port.name.to_string())
}

impl super::App {
    pub(super) fn search_ui(&mut self, ctx: &egui::Context) {
        let Some(search) = &mut self.search else { return };
        match search.ui(ctx, &self.registry) {
            Found::Open => {}
            Found::Closed => self.search = None,
            Found::Type(id) => {
                if let Some(search) = self.search.take() {
                    self.add_found(&id, &search);
                }
            }
        }
    }
}
