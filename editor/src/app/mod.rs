//! The window: brings document, canvas, inspector and panes together.

mod actions;
mod asks;
mod beside;
mod build_out;
mod command;
mod dialogs;
mod files;
mod fold;
mod follow;
mod gestures;
mod hear;
mod help;
mod menu;
mod nodes;
mod open;
mod progress;
mod recent;
mod recovery;
mod save;
mod search;
mod settings;
mod sketch;
mod typed;
mod variations;
mod words;

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use eframe::egui;
use orograph_core::Context;
use orograph_edit::{
    Badge, Editing, Fault, Interfaces, Journal, Keeper, OpenFile, Runner, Wish, operations,
    operations::Refused,
};
use orograph_engine::{Document, Evaluator, Registry, document::Link, plugin::Found};
use orograph_session::Settings;

pub use command::Command;
pub use dialogs::{Dialogs, NoDialogs, Question};
pub use settings::PluginLoader;

use crate::{
    canvas::{Canvas, NodeView, Wire},
    clicks::Clicks,
    inspector::Inspector,
    views::{Compare, Pane, Tool},
};
use progress::Progress;
use search::Search;

/// What the editor begins with.
pub struct Start {
    /// The node types.
    pub registry: Arc<Registry>,
    /// The libraries of plugins that were looked at for them.
    pub found: Vec<Found>,
    /// How node types are found again.
    pub plugins: PluginLoader,
    /// The settings as they were read.
    pub settings: Settings,
    /// Where changes of them are kept; none to keep them nowhere.
    pub settings_file: Option<PathBuf>,
    /// What evaluates.
    pub evaluator: Arc<Evaluator>,
    /// The graph to open.
    pub file: Option<PathBuf>,
    /// Where unsaved work is kept; none to keep it nowhere.
    pub recoveries: Option<PathBuf>,
    /// The folder that builds write into.
    pub out: PathBuf,
    /// What is to be told at the start.
    pub notes: Vec<String>,
    /// How files are asked for.
    pub dialogs: Dialogs,
}

impl Start {
    /// Begins with node types and an evaluator alone: nothing is open, nothing is kept, and no dialog answers.
    #[must_use]
    pub fn with(registry: Arc<Registry>, evaluator: Arc<Evaluator>) -> Self {
        let known = registry.clone();
        Self {
            registry,
            found: Vec::new(),
            plugins: Arc::new(move |_| Ok(((*known).clone(), Vec::new()))),
            settings: Settings::default(),
            settings_file: None,
            evaluator,
            file: None,
            recoveries: None,
            out: PathBuf::from("out"),
            notes: Vec::new(),
            dialogs: Arc::new(|_, _| Ok(None)),
        }
    }
}

/// The editor.
pub struct App {
    registry: Arc<Registry>,
    interfaces: Interfaces,
    editing: Editing,
    file: Option<OpenFile>,
    runner: Runner,
    journal: Option<Journal>,
    out: PathBuf,
    canvas: Canvas,
    inspector: Inspector,
    panes: Vec<Pane>,
    compare: Compare,
    tool: Tool,
    height: f64,
    /// The parameter that is painted, where a node has several.
    layer: String,
    context: Context,
    thumbnails: bool,
    /// What the canvas draws, made anew when something in it changed.
    drawn: Vec<NodeView>,
    wires: Vec<Wire>,
    stale: bool,
    drawn_state: u64,
    badges: HashMap<String, Badge>,
    faults: Vec<Fault>,
    pictures: HashMap<String, egui::TextureHandle>,
    progress: Progress,
    building: Progress,
    asked: Option<(Arc<Document>, Vec<Wish>, Context)>,
    kept: u64,
    notes: Vec<Note>,
    search: Option<Search>,
    refused: Option<(Refused, Wire)>,
    dialogs: Dialogs,
    dialog: Option<dialogs::Waiting>,
    /// A path is typed, where the system has no dialogs.
    typed: Option<typed::Typed>,
    closing: Option<dialogs::Then>,
    help: Option<help::Page>,
    preferences: settings::Preferences,
    variations: Option<variations::Variations>,
    left: Vec<orograph_edit::Left>,
    watch: recovery::Watch,
    writing: Option<save::Writing>,
    /// A subgraph that is being written.
    folding: Option<fold::Folding>,
    opening: Option<open::Opening>,
    wake: Arc<dyn Fn() + Send + Sync>,
    words: Option<words::Words>,
    clicks: Clicks,
    quit: bool,
    /// What the window is called now.
    called: String,
}

/// Something that is told at the foot of the window.
struct Note {
    text: String,
    bad: bool,
}

impl App {
    /// Opens the window's contents.
    #[must_use]
    pub fn new(ctx: &egui::Context, start: Start) -> Self {
        let Start { registry, evaluator, file, recoveries, out, notes, dialogs, .. } = start;
        let wake: Arc<dyn Fn() + Send + Sync> = {
            let ctx = ctx.clone();
            Arc::new(move || ctx.request_repaint())
        };
        let keeper = Keeper::new(start.settings, start.settings_file, wake.clone());
        let preferences = settings::Preferences::new(keeper, evaluator.clone(), start.plugins, start.found);
        let runner = Runner::new(evaluator, registry.clone(), wake.clone());
        let mut app = Self {
            interfaces: Interfaces::new(registry.clone(), PathBuf::new()),
            editing: Editing::new(Document::new()),
            file: None,
            runner,
            journal: None,
            out,
            canvas: Canvas::default(),
            inspector: Inspector::default(),
            panes: vec![Pane::new("view")],
            compare: Compare::default(),
            tool: Tool::Look,
            height: 1.0,
            layer: String::new(),
            context: Context { seed: 0, resolution: Some(512) },
            thumbnails: true,
            drawn: Vec::new(),
            wires: Vec::new(),
            stale: true,
            drawn_state: u64::MAX,
            badges: HashMap::new(),
            faults: Vec::new(),
            pictures: HashMap::new(),
            progress: Progress::default(),
            building: Progress::default(),
            asked: None,
            kept: 0,
            notes: notes.into_iter().map(|text| Note { text, bad: true }).collect(),
            search: None,
            refused: None,
            dialogs,
            dialog: None,
            typed: None,
            closing: None,
            help: None,
            preferences,
            variations: None,
            left: Vec::new(),
            watch: recovery::Watch::default(),
            writing: None,
            folding: None,
            opening: None,
            wake,
            words: None,
            clicks: Clicks::default(),
            quit: false,
            called: String::new(),
            registry,
        };
        app.look_for_recoveries(recoveries);
        if let Some(file) = file {
            app.open(&file);
        }
        app
    }

    /// The document.
    #[must_use]
    pub fn document(&self) -> &Arc<Document> {
        self.editing.document()
    }

    /// Whether there is something to save.
    #[must_use]
    pub fn is_dirty(&self) -> bool {
        self.editing.is_dirty()
    }

    /// The selected nodes.
    #[must_use]
    pub fn selection(&self) -> Vec<String> {
        self.canvas.selection.iter().cloned().collect()
    }

    /// What is told at the foot of the window, the newest last.
    #[must_use]
    pub fn told(&self) -> Vec<String> {
        self.notes.iter().map(|note| note.text.clone()).collect()
    }

    /// From places in the graph to places in the window, for whoever points at nodes from outside.
    #[must_use]
    pub fn to_window(&self) -> egui::emath::TSTransform {
        self.canvas.to_window()
    }

    /// Whether nothing goes on beside the window: nothing is computed, written or looked for.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        let computes = self.progress.is_under_way() || self.building.is_under_way();
        let waits = self.writing.is_some() || self.folding.is_some() || self.opening.is_some();
        !computes && !waits && !self.preferences.is_busy()
    }

    /// The settings of the program.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        self.preferences.keeper.settings()
    }

    /// What the first pane shows.
    #[must_use]
    pub fn shown(&self) -> Option<&orograph_core::Value> {
        self.panes.first()?.value()
    }

    /// Draws the window and does what the user asks.
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.hear(&ctx);
        self.saving_answers();
        self.folding_answers();
        self.keys(&ctx);
        egui::Panel::top("menu").show(ui, |ui| self.menu(ui));
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui));
        egui::Panel::right("inspector").default_size(330.0).show(ui, |ui| self.inspect(ui));
        // What is made deserves as much room as how it is made.
        let half = ui.available_height() / 2.0;
        egui::Panel::top("views")
            .resizable(true)
            .default_size(half)
            .min_size(80.0)
            .show(ui, |ui| self.views(ui));
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.graph(ui));
        self.floating(&ctx);
        self.catch_up(&ctx);
    }

    fn views(&mut self, ui: &mut egui::Ui) {
        let drawable = self.drawable();
        ui.horizontal(|ui| self.palette(ui, drawable.as_ref()));
        let offers: Vec<_> =
            (0..self.panes.len()).map(|index| self.offer(index, drawable.as_ref())).collect();
        let asked = self.compare.ui(ui, &mut self.panes, &self.registry, &offers, self.tool);
        for (index, asked) in asked {
            self.asked_of_pane(index, asked, drawable.as_ref());
        }
    }

    fn graph(&mut self, ui: &mut egui::Ui) {
        self.redraw();
        let document = self.editing.document().clone();
        let gestures = self.canvas.show(ui, &self.drawn, &self.wires, &document.layout);
        if document.nodes.is_empty() && self.search.is_none() {
            // Over the canvas, which lies in a layer of its own.
            let area = egui::Area::new("empty".into()).order(egui::Order::Middle).interactable(false);
            let area = area.pivot(egui::Align2::CENTER_CENTER).fixed_pos(self.canvas.rect().center());
            area.show(ui.ctx(), |ui| {
                ui.weak("Tab, or a right click, adds a node. F1 tells the keys.");
            });
        }
        for gesture in gestures {
            self.gesture(ui.ctx(), gesture);
        }
    }

    fn inspect(&mut self, ui: &mut egui::Ui) {
        let document = self.editing.document().clone();
        let chosen = self.canvas.selection.last().cloned();
        let asks = match chosen.as_ref().and_then(|name| Some((name, document.nodes.get(name)?))) {
            Some((name, node)) => {
                let interface = self.interfaces.of(name, node, &document);
                let exposed: Vec<(String, Link)> = document
                    .expose
                    .iter()
                    .map(|(name, exposed)| (name.clone(), exposed.param.clone()))
                    .collect();
                self.inspector.node(ui, name, node, &interface, &exposed)
            }
            None => self.inspector.graph(ui, &document),
        };
        for ask in asks {
            self.ask(ask);
        }
    }

    fn floating(&mut self, ctx: &egui::Context) {
        self.search_ui(ctx);
        self.refusal_ui(ctx);
        self.opening_ui(ctx);
        self.recovery_ui(ctx);
        self.closing_ui(ctx);
        self.words_ui(ctx);
        self.variations_ui(ctx);
        self.settings_ui(ctx);
        if let Some(page) = &self.help
            && !page.show(ctx)
        {
            self.help = None;
        }
        self.dialog_answers(ctx);
        self.typed_ui(ctx);
    }

    fn folder(&self) -> PathBuf {
        self.interfaces.folder().to_owned()
    }

    fn tell(&mut self, text: impl Into<String>) {
        self.notes.push(Note { text: text.into(), bad: false });
    }

    fn complain(&mut self, text: impl Into<String>) {
        self.notes.push(Note { text: text.into(), bad: true });
    }

    /// Makes an edit and says why it was not made.
    fn edit<T>(
        &mut self,
        label: &str,
        edit: impl FnOnce(&mut Document, &mut Interfaces) -> Result<T, Refused>,
    ) -> Option<T> {
        let interfaces = &mut self.interfaces;
        match self.editing.edit(label, |document| edit(document, interfaces)) {
            Ok(value) => Some(value),
            Err(refused) => {
                self.complain(refused.to_string());
                None
            }
        }
    }

    /// The nodes that a command is about.
    fn chosen(&self) -> Vec<String> {
        self.canvas.selection.iter().cloned().collect()
    }

    /// Nodes that stand where the canvas put them keep their places from the first move on, so that the graph looks
    /// the same when it is opened again.
    fn settle(document: &mut Document, automatic: &indexmap::IndexMap<String, (f64, f64)>) {
        for name in document.nodes.keys() {
            if let Some(place) = automatic.get(name) {
                document.layout.nodes.entry(name.clone()).or_insert(*place);
            }
        }
    }

    fn remove_chosen(&mut self) {
        let names = self.chosen();
        let wires: Vec<Wire> = self.canvas.wires.iter().cloned().collect();
        self.edit("delete", |document, _| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            operations::remove(document, &names);
            for (from, to) in &wires {
                operations::disconnect(document, from, to);
            }
            Ok(())
        });
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.may_close(ui.ctx());
        Self::ui(self, ui);
    }

    fn raw_input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        if self.clicks.part(&mut input.events) {
            ctx.request_repaint();
        }
    }

    fn on_exit(&mut self) {
        self.runner.stop();
        if let Some(writing) = self.writing.take() {
            writing.wait();
        }
        if let Some(journal) = &self.journal {
            // What is unsaved at this point was given up, or stays to be recovered.
            let _ = journal.flush();
        }
    }
}
