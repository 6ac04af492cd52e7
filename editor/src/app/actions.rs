//! Commands and gestures made edits.

use eframe::egui::{self, Event};
use orograph_edit::{clipboard, operations, subgraph};
use orograph_engine::Document;

use super::{App, Command, Question, dialogs::Then, help::Page, search::Search, words::Whose};
use crate::{
    app::command::asked_first,
    views::{self, Mode, Pane},
};

/// How far a second copy stands from the first.
const BESIDE: f64 = 36.0;

impl App {
    /// Keys and events of the clipboard, unless a field of text has the keyboard.
    pub(super) fn keys(&mut self, ctx: &egui::Context) {
        if self.opening.is_some() {
            // What they would change is about to go.
            return;
        }
        // A question stands before everything else.
        if ctx.memory(|memory| memory.top_modal_layer().is_some()) {
            if !ctx.egui_wants_keyboard_input() {
                // The widget library for graphs would remove what is selected.
                ctx.input_mut(|input| {
                    for key in [egui::Key::Delete, egui::Key::Backspace] {
                        input.consume_key(egui::Modifiers::NONE, key);
                    }
                });
            }
            return;
        }
        let view = views::has_keyboard(ctx);
        let typing = (ctx.egui_wants_keyboard_input() && !view) || self.search.is_some();
        let mut chosen = Vec::new();
        ctx.input_mut(|input| {
            for entry in asked_first() {
                let Some(key) = entry.shortcut() else { continue };
                // While text is typed, plain keys are letters, and undo is the field's own.
                let text = typing && (!key.modifiers.command || entry.menu == super::command::Menu::Edit);
                let own = view && views::takes(&key);
                if !text && !own && input.consume_shortcut(&key) {
                    chosen.push(entry.command);
                }
            }
        });
        if !typing {
            let events = ctx.input(|input| input.events.clone());
            for event in events {
                match event {
                    Event::Copy => self.copy(ctx),
                    Event::Cut => {
                        self.copy(ctx);
                        self.remove_chosen();
                    }
                    Event::Paste(text) => self.paste(&text),
                    _ => {}
                }
            }
        }
        for command in chosen {
            if self.can(command) {
                self.command(ctx, command);
            }
        }
    }

    /// Whether a command has something to do.
    pub(super) fn can(&self, command: Command) -> bool {
        let selected = self.canvas.selection.len();
        match command {
            Command::Undo => self.editing.undo_label().is_some(),
            Command::Redo => self.editing.redo_label().is_some(),
            Command::Cut
            | Command::Copy
            | Command::Duplicate
            | Command::Dissolve
            | Command::Bypass
            | Command::Frame
            | Command::Collapse
            | Command::Expand => selected > 0,
            Command::Delete => selected > 0 || !self.canvas.wires.is_empty(),
            Command::AlignLeft | Command::AlignTop => selected > 1,
            Command::Bend => !self.canvas.wires.is_empty(),
            _ => true,
        }
    }

    /// Does what a command says.
    pub fn command(&mut self, ctx: &egui::Context, command: Command) {
        let names = self.chosen();
        let refs: Vec<&str> = names.iter().map(String::as_str).collect();
        match command {
            Command::New => self.leave(Then::New),
            Command::Open => self.leave(Then::Open),
            Command::Save => self.save(None),
            Command::SaveAs => self.ask_file(Question::Save, super::dialogs::For::SaveAs(None)),
            Command::Quit => self.leave(Then::Quit),
            Command::Undo => {
                self.editing.undo();
            }
            Command::Redo => {
                self.editing.redo();
            }
            Command::Cut => {
                self.copy(ctx);
                self.remove_chosen();
            }
            Command::Copy => self.copy(ctx),
            Command::Paste => ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            Command::Duplicate => self.duplicate(&refs),
            Command::Delete => self.remove_chosen(),
            Command::Dissolve => {
                self.edit("delete and join", |document, interfaces| {
                    refs.iter().for_each(|name| operations::dissolve(document, interfaces, name));
                    Ok(())
                });
            }
            Command::SelectAll => self.canvas.select(self.editing.document().nodes.keys().cloned()),
            Command::SelectNone => self.canvas.select([]),
            Command::Add => {
                // Where the pointer is, when that is over the graph.
                let pointer = ctx.input(|input| input.pointer.latest_pos());
                let canvas = self.canvas.rect();
                let at = pointer.filter(|pos| canvas.contains(*pos)).unwrap_or(canvas.center());
                self.search = Some(Search::new(self.canvas.place_at(at), at, None));
            }
            Command::AddGraph => self.ask_file(Question::Graph, super::dialogs::For::Subgraph),
            Command::Bypass => {
                self.edit("bypass", |document, _| {
                    operations::toggle_bypass(document, &refs);
                    Ok(())
                });
            }
            Command::Frame => self.frame(ctx, &refs),
            Command::Comment => self.write(Whose::NewComment),
            Command::Bend => self.bend_chosen(),
            Command::Collapse => self.ask_file(Question::Save, super::dialogs::For::Collapse(names.clone())),
            Command::Expand => self.expand(&names),
            Command::AlignLeft | Command::AlignTop => self.align(ctx, &refs, command == Command::AlignLeft),
            Command::Arrange => self.arrange(ctx),
            Command::Fit => self.canvas.fit(),
            Command::Pin => {
                let pin = self.panes.first().is_some_and(|pane| pane.pinned.is_none());
                self.asked_of_pane(0, crate::views::Asked::Pin(pin), None);
            }
            Command::Split => match self.panes.len() {
                1 => {
                    let mut second = Pane::new("second view");
                    // What was seen so far stays there to compare with.
                    second.output.clone_from(&self.panes[0].output);
                    second.pinned.clone_from(&second.output);
                    second.mode = self.panes[0].mode.clone();
                    self.panes.push(second);
                }
                _ => self.panes.truncate(1),
            },
            Command::Thumbnails => {
                self.thumbnails = !self.thumbnails;
                self.stale = true;
            }
            Command::Next => self.walk(true),
            Command::Previous => self.walk(false),
            Command::Build => self.build(),
            // What lies in front goes first.
            Command::Stop if self.help.is_some() => self.help = None,
            Command::Stop => self.runner.stop(),
            Command::Keys => self.help = if self.help.is_some() { None } else { Some(Page::keys()) },
            Command::Settings => self.open_settings(),
        }
    }

    fn copy(&mut self, ctx: &egui::Context) {
        let names = self.chosen();
        if names.is_empty() {
            return;
        }
        let document = self.placed();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        ctx.copy_text(clipboard::copy(&document, &names, &self.registry));
    }

    /// The document with the places of all nodes, those that the canvas found as well.
    fn placed(&self) -> Document {
        let mut document = (**self.editing.document()).clone();
        Self::settle(&mut document, self.canvas.automatic());
        document
    }

    fn paste(&mut self, text: &str) {
        let at = self.canvas.middle();
        let pasted = self.editing.edit("paste", |document| clipboard::paste(document, text, at));
        match pasted {
            Ok(names) => self.canvas.select(names),
            Err(errors) => {
                let first = errors.errors().first().map(ToString::to_string).unwrap_or_default();
                self.complain(format!("The clipboard holds no nodes: {first}"));
            }
        }
    }

    fn duplicate(&mut self, names: &[&str]) {
        let document = self.placed();
        let text = clipboard::copy(&document, names, &self.registry);
        let places = names.iter().filter_map(|name| document.layout.nodes.get(*name).copied());
        let corner = places.reduce(|a, b| (a.0.min(b.0), a.1.min(b.1))).unwrap_or_default();
        let at = (corner.0 + BESIDE, corner.1 + BESIDE);
        let automatic = self.canvas.automatic().clone();
        let added = self.editing.edit("duplicate", |document| {
            Self::settle(document, &automatic);
            clipboard::paste(document, &text, at)
        });
        match added {
            Ok(names) => self.canvas.select(names),
            Err(errors) => self.complain(errors.to_string()),
        }
    }

    fn frame(&mut self, ctx: &egui::Context, names: &[&str]) {
        let Some((min, max)) = self.canvas.bounds(ctx, names) else { return };
        let automatic = self.canvas.automatic().clone();
        self.edit("frame", |document, _| {
            Self::settle(document, &automatic);
            operations::frame(document, "Frame", min, max);
            Ok(())
        });
        let last = self.editing.document().layout.frames.len().saturating_sub(1);
        self.write(Whose::Frame(last));
    }

    fn expand(&mut self, names: &[String]) {
        let laid = self.edit("expand", |document, interfaces| {
            let mut laid = Vec::new();
            for name in names {
                laid.extend(subgraph::expand(document, interfaces, name)?);
            }
            Ok(laid)
        });
        if let Some(laid) = laid {
            self.canvas.select(laid);
        }
    }

    fn align(&mut self, ctx: &egui::Context, names: &[&str], left: bool) {
        let Some((min, _)) = self.canvas.bounds(ctx, names) else { return };
        let automatic = self.canvas.automatic().clone();
        self.edit("align", |document, _| {
            Self::settle(document, &automatic);
            for name in names {
                if let Some(place) = document.layout.nodes.get_mut(*name) {
                    *place = if left { (min.0, place.1) } else { (place.0, min.1) };
                }
            }
            Ok(())
        });
    }

    fn arrange(&mut self, ctx: &egui::Context) {
        let places = self.canvas.lay_out(ctx, &self.drawn, &self.wires);
        self.edit("arrange", |document, _| {
            document.layout.nodes.extend(places);
            Ok(())
        });
        self.canvas.fit();
    }

    /// Selects a neighbour along the wires, or of an unconnected node the one after it.
    fn walk(&mut self, ahead: bool) {
        let document = self.editing.document().clone();
        let now = self.canvas.selection.last().cloned();
        let next = now.and_then(|now| match ahead {
            true => self.wires.iter().find(|(from, _)| from.node == now).map(|(_, to)| to.node.clone()),
            false => self.wires.iter().find(|(_, to)| to.node == now).map(|(from, _)| from.node.clone()),
        });
        let next = next
            .or_else(|| self.canvas.selection.is_empty().then(|| document.nodes.keys().next().cloned())?);
        if let Some(next) = next {
            self.canvas.select([next]);
        }
    }

    pub(super) fn pane_mode(&mut self, index: usize, mode: Mode) {
        self.panes[index].mode = mode;
    }
}
