//! Gestures on the canvas made edits.

use eframe::egui;
use orograph_edit::operations;
use orograph_engine::document::Link;

use super::{
    App,
    search::{Loose, Search, port_for},
};
use crate::canvas::Gesture;

impl App {
    /// Does what a gesture on the canvas says.
    pub(super) fn gesture(&mut self, ctx: &egui::Context, gesture: Gesture) {
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
            Gesture::RenameFrame(index) => {
                let title = self.editing.document().layout.frames.get(index).map(|frame| frame.title.clone());
                self.title = title.map(|title| (index, title));
            }
        }
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
            for (px, py) in document.layout.nodes.values_mut() {
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
        let added = self.edit("add", |document, interfaces| {
            Self::settle(document, &automatic);
            let name = operations::add(document, &node_type, place);
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
