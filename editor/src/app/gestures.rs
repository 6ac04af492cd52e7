//! Gestures on the canvas made edits.

use eframe::egui;
use orograph_edit::operations;
use orograph_engine::document::Link;

use super::{
    App,
    search::{Loose, Search, port_for},
    words::Whose,
};
use crate::canvas::Gesture;

impl App {
    /// Does what a gesture on the canvas says.
    pub(super) fn gesture(&mut self, ctx: &egui::Context, gesture: Gesture) {
        if self.opening.is_some() {
            // What it would change is about to go.
            return;
        }
        match gesture {
            Gesture::Selected => self.editing.end_gesture(),
            Gesture::Move(places) => {
                let automatic = self.canvas.automatic().clone();
                self.edit("move", |document, _| {
                    Self::settle(document, &automatic);
                    document.layout.nodes.extend(places);
                    Ok(())
                });
            }
            Gesture::Connect(wire) => self.connect(wire),
            Gesture::DropWire(port, is_output, place) => {
                let value_type = self.port_type(&port, is_output);
                let at = ctx.input(|input| input.pointer.latest_pos()).unwrap_or(self.canvas.rect().center());
                self.search = Some(Search::new(place, at, Some(Loose { port, is_output, value_type })));
            }
            Gesture::Disconnect(wires) => {
                self.edit("disconnect", |document, _| {
                    wires.iter().for_each(|(from, to)| operations::disconnect(document, from, to));
                    Ok(())
                });
            }
            Gesture::Remove(names) => {
                self.edit("delete", |document, _| {
                    operations::remove(document, &names.iter().map(String::as_str).collect::<Vec<_>>());
                    Ok(())
                });
            }
            Gesture::Search(place) => {
                let at = ctx.input(|input| input.pointer.latest_pos()).unwrap_or(self.canvas.rect().center());
                self.search = Some(Search::new(place, at, None));
            }
            Gesture::MoveFrame(index, offset) => self.move_frame(index, offset),
            Gesture::RenameFrame(index) => self.write(Whose::Frame(index)),
            Gesture::MoveComment(index, (dx, dy)) => {
                self.edit("move comment", |document, _| {
                    if let Some(comment) = document.layout.comments.get_mut(index) {
                        comment.at = (comment.at.0 + dx, comment.at.1 + dy);
                    }
                    Ok(())
                });
            }
            Gesture::EditComment(index) => self.write(Whose::Comment(index)),
            Gesture::Bend((from, to), through) => {
                self.edit("bend wire", |document, _| {
                    operations::bend(document, &from, &to, through);
                    Ok(())
                });
            }
        }
    }

    /// Leads the selected wires through a place halfway more, to be dragged from there.
    pub(super) fn bend_chosen(&mut self) {
        let wires: Vec<_> = self.canvas.wires.iter().cloned().collect();
        let halves: Vec<_> = wires.iter().map(|wire| self.canvas.halfway(wire)).collect();
        self.edit("bend wire", |document, _| {
            for ((from, to), half) in wires.iter().zip(halves) {
                let known = document.layout.bends.iter().find(|bend| bend.from == *from && bend.to == *to);
                let mut through = known.map(|bend| bend.through.clone()).unwrap_or_default();
                through.extend(half);
                operations::bend(document, from, to, through);
            }
            Ok(())
        });
    }

    pub(super) fn connect(&mut self, (from, to): (Link, Link)) {
        let interfaces = &mut self.interfaces;
        let done =
            self.editing.edit("connect", |document| operations::connect(document, interfaces, &from, &to));
        if let Err(refused) = done {
            self.refused = Some((refused, (from, to)));
        }
    }

    /// A frame takes along what stands in it.
    fn move_frame(&mut self, index: usize, (dx, dy): (f64, f64)) {
        let automatic = self.canvas.automatic().clone();
        self.edit("move frame", |document, _| {
            Self::settle(document, &automatic);
            let Some(frame) = document.layout.frames.get_mut(index) else { return Ok(()) };
            let (x, y, width, height) = frame.rect;
            frame.rect = (x + dx, y + dy, width, height);
            let layout = &mut document.layout;
            let bends = layout.bends.iter_mut().flat_map(|bend| &mut bend.through);
            let comments = layout.comments.iter_mut().map(|comment| &mut comment.at);
            for (px, py) in layout.nodes.values_mut().chain(bends).chain(comments) {
                if (x..=x + width).contains(px) && (y..=y + height).contains(py) {
                    (*px, *py) = (*px + dx, *py + dy);
                }
            }
            Ok(())
        });
    }

    /// Adds the node that was searched for, and joins the loose wire to it.
    pub(super) fn add_found(&mut self, id: &str, search: &Search) {
        let Some(node_type) = self.registry.get(id).cloned() else { return };
        let automatic = self.canvas.automatic().clone();
        let (place, loose) = (search.place, search.loose.clone());
        let supplier = self.preferences.supplier(id);
        let added = self.edit("add", |document, interfaces| {
            Self::settle(document, &automatic);
            let name = operations::add(document, &node_type, place);
            if let Some(node) = document.nodes.get_mut(&name) {
                node.plugin = supplier;
            }
            if let Some(loose) = &loose
                && let Some(port) = port_for(node_type.spec(), loose)
            {
                let port = Link::new(&name, port);
                let (from, to) = if loose.is_output { (&loose.port, &port) } else { (&port, &loose.port) };
                operations::connect(document, interfaces, from, to)?;
            }
            Ok(name)
        });
        if let Some(name) = added {
            self.canvas.select([name]);
        }
    }
}
