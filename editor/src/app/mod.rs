//! The window: brings document, canvas, inspector and panes together.

mod actions;
mod build_out;
mod command;
mod dialogs;
mod hear;
mod help;
mod nodes;
mod recovery;
mod search;
mod sketch;
mod variations;

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;
use orograph_core::{Context, ValueType};
use orograph_edit::{
    Badge, Delta, Editing, Fault, Interfaces, Journal, OpenFile, Runner, Scene, Wish, operations,
    operations::Refused,
};
use orograph_engine::{
    Document, Evaluator, Registry,
    document::{GRAPH, Link},
};

pub use command::Command;
pub use dialogs::{Dialogs, Question};

use crate::{
    canvas::{Canvas, NodeView, Wire},
    inspector::Inspector,
    views::{Pane, Tool},
};
use command::{ENTRIES, Menu};
use search::Search;

/// What the editor begins with.
pub struct Start {
    /// The node types.
    pub registry: Arc<Registry>,
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

/// The editor.
pub struct App {
    registry: Arc<Registry>,
    interfaces: Interfaces,
    editing: Editing,
    file: Option<OpenFile>,
    runner: Runner,
    journal: Option<Journal>,
    recoveries: Option<PathBuf>,
    out: PathBuf,
    canvas: Canvas,
    inspector: Inspector,
    panes: Vec<Pane>,
    tool: Tool,
    height: f64,
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
    progress: Option<f64>,
    building: Option<f64>,
    asked: Option<(Arc<Document>, Vec<Wish>, Context)>,
    kept: u64,
    notes: Vec<Note>,
    search: Option<Search>,
    refused: Option<(Refused, Wire)>,
    dialogs: Dialogs,
    dialog: Option<dialogs::Waiting>,
    closing: Option<dialogs::Then>,
    help: Option<help::Page>,
    variations: Option<variations::Variations>,
    left: Vec<orograph_edit::Left>,
    watch: recovery::Watch,
    title: Option<(usize, String)>,
    quit: bool,
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
        let Start { registry, evaluator, file, recoveries, out, notes, dialogs } = start;
        let wake = {
            let ctx = ctx.clone();
            Arc::new(move || ctx.request_repaint())
        };
        let runner = Runner::new(evaluator, registry.clone(), wake);
        let mut app = Self {
            interfaces: Interfaces::new(registry.clone(), PathBuf::new()),
            editing: Editing::new(Document::new()),
            file: None,
            runner,
            journal: None,
            recoveries: None,
            out,
            canvas: Canvas::default(),
            inspector: Inspector::default(),
            panes: vec![Pane::new("view")],
            tool: Tool::Look,
            height: 1.0,
            context: Context { seed: 0, resolution: Some(512) },
            thumbnails: true,
            drawn: Vec::new(),
            wires: Vec::new(),
            stale: true,
            drawn_state: u64::MAX,
            badges: HashMap::new(),
            faults: Vec::new(),
            pictures: HashMap::new(),
            progress: None,
            building: None,
            asked: None,
            kept: 0,
            notes: notes.into_iter().map(|text| Note { text, bad: true }).collect(),
            search: None,
            refused: None,
            dialogs,
            dialog: None,
            closing: None,
            help: None,
            variations: None,
            left: Vec::new(),
            watch: recovery::Watch::default(),
            title: None,
            quit: false,
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

    /// Whether nothing is being computed.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.progress.is_none() && self.building.is_none()
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
        self.keys(&ctx);
        egui::Panel::top("menu").show(ui, |ui| self.menu(ui));
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui));
        egui::Panel::right("inspector").default_size(330.0).show(ui, |ui| self.inspect(ui));
        egui::Panel::top("views")
            .resizable(true)
            .default_size(340.0)
            .min_size(80.0)
            .show(ui, |ui| self.views(ui));
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| self.graph(ui));
        self.floating(&ctx);
        self.catch_up(&ctx);
    }

    fn menu(&mut self, ui: &mut egui::Ui) {
        let mut chosen = None;
        egui::MenuBar::new().ui(ui, |ui| {
            for (menu, title) in Menu::ALL {
                ui.menu_button(title, |ui| {
                    for entry in ENTRIES.iter().filter(|entry| entry.menu == menu && !entry.label.is_empty())
                    {
                        let mut button = egui::Button::new(self.label(entry.command, entry.label));
                        if let Some(key) = entry.shortcut() {
                            button = button.shortcut_text(ui.ctx().format_shortcut(&key));
                        }
                        if ui.add_enabled(self.can(entry.command), button).clicked() {
                            chosen = Some(entry.command);
                        }
                    }
                });
            }
            ui.separator();
            if ui.button("Build").on_hover_text("Write every file, as `orograph run` does").clicked() {
                chosen = Some(Command::Build);
            }
            ui.label("preview");
            let text = |cells: Option<u32>| {
                cells.map_or_else(|| "full".to_owned(), |cells| format!("{cells} cells"))
            };
            egui::ComboBox::from_id_salt("resolution").selected_text(text(self.context.resolution)).show_ui(
                ui,
                |ui| {
                    for cells in [Some(128), Some(256), Some(512), Some(1024), Some(2048), None] {
                        ui.selectable_value(&mut self.context.resolution, cells, text(cells));
                    }
                },
            );
            ui.label("seed");
            ui.add(egui::DragValue::new(&mut self.context.seed));
        });
        if let Some(command) = chosen {
            self.command(ui.ctx(), command);
        }
    }

    fn label(&self, command: Command, label: &'static str) -> String {
        let what = match command {
            Command::Undo => self.editing.undo_label(),
            Command::Redo => self.editing.redo_label(),
            _ => None,
        };
        what.map_or_else(|| label.to_owned(), |what| format!("{label}: {what}"))
    }

    fn status(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            if let Some(done) = self.building {
                ui.add(egui::ProgressBar::new(done as f32).desired_width(140.0).text("building"));
            }
            if let Some(done) = self.progress {
                ui.add(egui::ProgressBar::new(done as f32).desired_width(140.0).text("preview"));
            }
            if (self.building.is_some() || self.progress.is_some()) && ui.small_button("stop").clicked() {
                self.runner.stop();
            }
            let n = self.faults.len();
            if n > 0 {
                let words =
                    self.faults.iter().map(|fault| fault.message.as_str()).collect::<Vec<_>>().join("\n");
                let text = if n == 1 { "1 problem".to_owned() } else { format!("{n} problems") };
                ui.colored_label(crate::theme::FAULT, text).on_hover_text(words);
            }
            let mut gone = false;
            if let Some(note) = self.notes.last() {
                let colour = if note.bad { crate::theme::FAULT } else { ui.visuals().text_color() };
                ui.colored_label(colour, &note.text);
                gone = ui.small_button("×").clicked();
            }
            if gone {
                self.notes.pop();
            }
        });
    }

    fn views(&mut self, ui: &mut egui::Ui) {
        let drawable = self.drawable();
        ui.horizontal(|ui| {
            if drawable.is_none() {
                self.tool = Tool::Look;
                return;
            }
            for (tool, label) in
                [(Tool::Look, "look"), (Tool::Draw, "draw"), (Tool::Point, "point"), (Tool::Erase, "erase")]
            {
                ui.selectable_value(&mut self.tool, tool, label);
            }
            ui.label("height of what is drawn");
            ui.add(egui::DragValue::new(&mut self.height));
        });
        let width = ui.available_width() / self.panes.len().max(1) as f32;
        let height = ui.available_height();
        let mut asked = Vec::new();
        ui.horizontal_top(|ui| {
            for index in 0..self.panes.len() {
                let value_type = self.panes[index].output.clone().and_then(|output| self.type_of(&output));
                let lines = self.lines_for(index, drawable.as_ref());
                let size = egui::vec2(width - 6.0, height);
                let (tool, registry) = (self.tool, self.registry.clone());
                let pane = &mut self.panes[index];
                ui.allocate_ui_with_layout(size, egui::Layout::top_down(egui::Align::Min), |ui| {
                    ui.set_min_size(size);
                    let answers = pane.ui(ui, &registry, value_type, tool, &lines);
                    asked.extend(answers.into_iter().map(|asked| (index, asked)));
                });
            }
        });
        for (index, asked) in asked {
            self.asked_of_pane(index, asked, drawable.as_ref());
        }
    }

    fn graph(&mut self, ui: &mut egui::Ui) {
        self.redraw();
        let document = self.editing.document().clone();
        let gestures = self.canvas.show(ui, &self.drawn, &self.wires, &document.layout.frames);
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
        self.recovery_ui(ctx);
        self.closing_ui(ctx);
        self.frame_title_ui(ctx);
        self.variations_ui(ctx);
        if let Some(page) = &self.help
            && !page.show(ctx)
        {
            self.help = None;
        }
        self.dialog_answers(ctx);
    }

    /// After a frame: what changed is kept, and computed.
    fn catch_up(&mut self, ctx: &egui::Context) {
        self.follow_selection();
        let document = self.editing.document().clone();
        if self.kept != self.editing.state() {
            self.kept = self.editing.state();
            if let Some(journal) = &self.journal {
                match self.editing.is_dirty() {
                    true => journal.keep(self.file.as_ref().map(OpenFile::path), document.clone()),
                    false => journal.forget(),
                }
            }
        }
        let wishes = self.wishes(&document);
        let same = self.asked.as_ref().is_some_and(|(before, asked, context)| {
            let alike =
                Arc::ptr_eq(before, &document) || !Delta::between(before, &document).changes_results();
            alike && *asked == wishes && *context == self.context
        });
        if !same {
            self.asked = Some((document.clone(), wishes.clone(), self.context));
            self.progress = Some(0.0);
            self.runner.show(Scene { document, folder: self.folder(), context: self.context }, wishes);
        }
        let name =
            self.file.as_ref().map_or_else(|| "new graph".into(), |file| file.path().display().to_string());
        let mark = if self.editing.is_dirty() { "*" } else { "" };
        ctx.send_viewport_cmd(egui::ViewportCommand::Title(format!("{mark}{name} — Orograph")));
        if self.quit {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }

    fn folder(&self) -> PathBuf {
        self.interfaces.folder().to_owned()
    }

    /// Panes that are not pinned show what the last selected node gives.
    fn follow_selection(&mut self) {
        let Some(name) = self.canvas.selection.last().cloned() else { return };
        let output = self.output_to_show(&name);
        for pane in self.panes.iter_mut().filter(|pane| pane.pinned.is_none()) {
            if pane.output != output {
                pane.output.clone_from(&output);
                pane.clear();
            }
        }
    }

    /// What to look at of a node: its first output, or of one that gives nothing, what it is given.
    fn output_to_show(&mut self, name: &str) -> Option<Link> {
        let document = self.editing.document().clone();
        let node = document.nodes.get(name)?;
        let interface = self.interfaces.of(name, node, &document);
        match interface.outputs.first() {
            Some(output) => Some(Link::new(name, &output.name)),
            None => node.inputs.values().flatten().next().filter(|link| link.node != GRAPH).cloned(),
        }
    }

    fn type_of(&mut self, output: &Link) -> Option<ValueType> {
        let document = self.editing.document().clone();
        let node = document.nodes.get(&output.node)?;
        self.interfaces.of(&output.node, node, &document).output(&output.port)?.value_type
    }

    /// What the panes want, then the grid of variations, then a picture for every node.
    fn wishes(&mut self, document: &Document) -> Vec<Wish> {
        let mut wishes = Vec::new();
        for index in 0..self.panes.len() {
            let value_type = self.panes[index].output.clone().and_then(|output| self.type_of(&output));
            wishes.extend(self.panes[index].wish(&self.registry, value_type));
        }
        wishes.extend(self.variations.iter().flat_map(variations::Variations::wishes));
        if self.thumbnails {
            for (name, node) in &document.nodes {
                let interface = self.interfaces.of(name, node, document);
                let Some(output) = interface.outputs.first() else { continue };
                let Some(value_type) = output.value_type else { continue };
                let look = orograph_edit::looks::of(&self.registry, value_type)
                    .first()
                    .map(|spec| spec.id.to_string());
                if look.is_some() || value_type == ValueType::Texture {
                    let output = Link::new(name, &output.name);
                    wishes.push(Wish {
                        name: nodes::picture_name(name),
                        output,
                        look,
                        overrides: Vec::new(),
                    });
                }
            }
        }
        wishes
    }

    fn tell(&mut self, text: impl Into<String>) {
        self.notes.push(Note { text: text.into(), bad: false });
    }

    fn complain(&mut self, text: impl Into<String>) {
        self.notes.push(Note { text: text.into(), bad: true });
    }

    /// Opens a graph file in place of what is open.
    pub fn open(&mut self, path: &Path) {
        match OpenFile::open(path) {
            Ok((file, document)) => {
                if document.has_inner_comments() {
                    self.complain("Comments inside the graph are lost when it is saved from here");
                }
                self.replace(Some(file), document);
            }
            Err(errors) => self.complain(errors.to_string()),
        }
    }

    fn replace(&mut self, file: Option<OpenFile>, document: Document) {
        let folder =
            file.as_ref().and_then(|file| file.path().parent()).map(Path::to_owned).unwrap_or_default();
        self.interfaces = Interfaces::new(self.registry.clone(), folder);
        self.editing = Editing::new(document);
        self.file = file;
        self.kept = self.editing.state();
        self.drawn_state = u64::MAX;
        self.canvas = Canvas::default();
        self.canvas.fit();
        self.inspector = Inspector::default();
        self.badges.clear();
        self.pictures.clear();
        self.asked = None;
        self.variations = None;
        for pane in &mut self.panes {
            (pane.pinned, pane.output) = (None, None);
            pane.clear();
        }
        // Something to look at: what the graph writes, or its last node.
        let document = self.editing.document().clone();
        let last = document.outputs.values().next().map(|link| link.node.clone()).or_else(|| {
            let is_input = |name: &str| {
                document
                    .nodes
                    .values()
                    .any(|node| node.inputs.values().flatten().any(|link| link.node == name))
            };
            document.nodes.keys().rev().find(|name| !is_input(name)).cloned()
        });
        self.canvas.select(last);
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
                self.complain(format!("{refused}: {}", refused.help));
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

    fn on_exit(&mut self) {
        self.runner.stop();
        if let Some(journal) = &self.journal {
            // What is unsaved at this point was given up, or stays to be recovered.
            let _ = journal.flush();
        }
    }
}
