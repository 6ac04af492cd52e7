//! Wires: drawn, laid, bent and taken away.

use eframe::egui::{self, Pos2, Rect, Vec2, pos2};
use egui_graph::{
    SocketKind,
    edge::{Edge, EdgeShape},
};
use indexmap::IndexMap;
use orograph_engine::document::{Bend, Link};

use super::{Canvas, Gesture, NodeView, SOCKET, Wire, afar::FAR, background::Held, id, node_id};
use crate::theme;

impl Canvas {
    pub(super) fn ended(
        &mut self,
        node: &NodeView,
        kind: SocketKind,
        index: usize,
        nodes: &[NodeView],
        gestures: &mut Vec<Gesture>,
    ) {
        let Some((from, _, start)) = self.from.take() else { return };
        let Some(from) = nodes.iter().find(|other| other.name == from) else { return };
        let (source, output, target, input) = match kind {
            SocketKind::Input => (from, start, node, index),
            SocketKind::Output => (node, index, from, start),
        };
        if let (Some(output), Some(input)) = (source.outputs.get(output), target.inputs.get(input)) {
            let wire = (Link::new(&source.name, &output.name), Link::new(&target.name, &input.name));
            gestures.push(Gesture::Connect(wire));
        }
    }

    /// A wire that was let go over empty space asks what to put there.
    pub(super) fn dropped(&mut self, ui: &egui::Ui, nodes: &[NodeView], gestures: &mut Vec<Gesture>) {
        let Some((name, kind, index)) = self.from.take() else { return };
        let Some(node) = nodes.iter().find(|node| node.name == name) else { return };
        let is_output = matches!(kind, SocketKind::Output);
        let ports = if is_output { &node.outputs } else { &node.inputs };
        let (Some(port), Some(pos)) = (ports.get(index), ui.input(|input| input.pointer.latest_pos())) else {
            return;
        };
        gestures.push(Gesture::DropWire(Link::new(name, &port.name), is_output, self.place_at(pos)));
    }

    pub(super) fn edges(
        &mut self,
        edges_ctx: &mut egui_graph::EdgesCtx,
        ui: &mut egui::Ui,
        nodes: &[NodeView],
        wires: &[Wire],
        bends: &[Bend],
        gestures: &mut Vec<Gesture>,
    ) {
        let by_name: IndexMap<&str, &NodeView> =
            nodes.iter().map(|node| (node.name.as_str(), node)).collect();
        let bent: IndexMap<(&Link, &Link), &[(f64, f64)]> =
            bends.iter().map(|bend| ((&bend.from, &bend.to), bend.through.as_slice())).collect();
        let scale = self.to_window.scaling;
        let far = scale < FAR;
        // As fine as it shows.
        let fineness = Edge::DEFAULT_DISTANCE_PER_POINT / scale.clamp(0.1, 1.0);
        // Never thinner than a pixel, though everything else is smaller from afar.
        let stroke = |width: f32, colour| egui::Stroke::new(width * (0.5 / scale).max(1.0), colour);
        let mut gone = Vec::new();
        for wire @ (from, to) in wires {
            let (Some(source), Some(target)) =
                (by_name.get(from.node.as_str()), by_name.get(to.node.as_str()))
            else {
                continue;
            };
            let output = source.outputs.iter().position(|port| port.name == from.port);
            let input = target.inputs.iter().position(|port| port.name == to.port);
            let (Some(output), Some(input)) = (output, input) else { continue };
            let colour = theme::wire(source.outputs[output].value_type);
            let mut selected = self.wires.contains(wire);
            let (start, end) = ((node_id(&from.node), output), (node_id(&to.node), input));
            let through = bent.get(&(from, to)).copied().unwrap_or_default();
            let places: Vec<Pos2> = (0..through.len()).map(|n| self.bend_at(wire, through, n)).collect();
            if far && !selected {
                let ends = edges_ctx.output(ui, start.0, output).zip(edges_ctx.input(ui, end.0, input));
                let Some((first, last)) = ends else { continue };
                let points: Vec<Pos2> =
                    EdgeShape::DEFAULT.path(first, &places, last).flatten(fineness).collect();
                if self.afar.is_paint_wire(&points) {
                    ui.painter().line(points, stroke(2.0, colour));
                    continue;
                }
            }
            let response = Edge::new(start, end, &mut selected)
                .waypoints(&places)
                .shape(EdgeShape::DEFAULT)
                .distance_per_point(fineness)
                .stroke(stroke(2.0, colour))
                .hovered_stroke(stroke(3.0, colour))
                .selected_stroke(stroke(4.0, colour))
                .show(edges_ctx, ui);
            if response.double_clicked() {
                let ends = (edges_ctx.output(ui, start.0, output), edges_ctx.input(ui, end.0, input));
                let pointer = ui.input(|input| input.pointer.interact_pos());
                if let (Some((first, _)), Some((last, _)), Some(pointer)) = (ends.0, ends.1, pointer) {
                    let mut through = through.to_vec();
                    let (x, y) = self.place_at(pointer);
                    let index = detour(first, &places, last, pos2(x as f32, y as f32));
                    through.insert(index, (x.round(), y.round()));
                    gestures.push(Gesture::Bend(wire.clone(), through));
                }
            }
            if response.deleted() {
                gone.push(wire.clone());
            } else if response.changed() {
                match selected {
                    true => self.wires.insert(wire.clone()),
                    false => self.wires.shift_remove(wire),
                };
            }
            if !far {
                self.handles(ui, wire, through, colour, gestures);
            }
        }
        if !gone.is_empty() {
            gestures.push(Gesture::Disconnect(gone));
        }
        if let Some(edge) = edges_ctx.in_progress(ui) {
            edge.show(ui, EdgeShape::DEFAULT);
        }
        if !far {
            sockets(edges_ctx, ui, nodes);
        }
    }

    /// The places that a wire is led through: dragged to lead it elsewhere, clicked twice to be taken away.
    fn handles(
        &mut self,
        ui: &mut egui::Ui,
        wire: &Wire,
        through: &[(f64, f64)],
        colour: egui::Color32,
        gestures: &mut Vec<Gesture>,
    ) {
        const RADIUS: f32 = 5.0;
        for index in 0..through.len() {
            let place = self.bend_at(wire, through, index);
            let rect = Rect::from_center_size(place, Vec2::splat(3.0 * RADIUS));
            let response = ui.interact(rect, id().with(("bend", wire, index)), egui::Sense::click_and_drag());
            response.widget_info(|| {
                let label = format!("bend {} of {} to {}", index + 1, wire.0, wire.1);
                egui::WidgetInfo::labeled(egui::WidgetType::Button, true, label)
            });
            ui.painter().circle_filled(place, if response.hovered() { RADIUS + 2.0 } else { RADIUS }, colour);
            let mut through = through.to_vec();
            if response.double_clicked() {
                through.remove(index);
                gestures.push(Gesture::Bend(wire.clone(), through));
            } else if let Some((dx, dy)) = self.held(&response, Held::Bend(wire.clone(), index)) {
                let (x, y) = &mut through[index];
                (*x, *y) = (*x + dx, *y + dy);
                gestures.push(Gesture::Bend(wire.clone(), through));
            }
        }
    }

    /// Where a wire is led through, with what is being dragged.
    fn bend_at(&self, wire: &Wire, through: &[(f64, f64)], index: usize) -> Pos2 {
        let (x, y) = through[index];
        let place = pos2(x as f32, y as f32);
        match &self.held {
            Some((Held::Bend(held, at), offset)) if held == wire && *at == index => place + *offset,
            _ => place,
        }
    }
}

/// Over the widget's own sockets, which have one colour for a whole node.
fn sockets(edges_ctx: &egui_graph::EdgesCtx, ui: &egui::Ui, nodes: &[NodeView]) {
    let seen = ui.clip_rect().expand(8.0);
    for node in nodes {
        let id = node_id(&node.name);
        let inputs = node.inputs.iter().enumerate();
        let inputs = inputs.filter_map(|(index, port)| Some((edges_ctx.input(ui, id, index)?.0, port)));
        let outputs = node.outputs.iter().enumerate();
        let outputs = outputs.filter_map(|(index, port)| Some((edges_ctx.output(ui, id, index)?.0, port)));
        for (pos, port) in inputs.chain(outputs).filter(|(pos, _)| seen.contains(*pos)) {
            ui.painter().circle_filled(pos, SOCKET, theme::wire(port.value_type));
        }
    }
}

/// Where among `places` a new one makes the way from `first` to `last` least longer.
fn detour(first: Pos2, places: &[Pos2], last: Pos2, new: Pos2) -> usize {
    let way: Vec<Pos2> = std::iter::once(first).chain(places.iter().copied()).chain([last]).collect();
    let longer = |n: &usize| {
        let (a, b) = (way[*n], way[*n + 1]);
        a.distance(new) + new.distance(b) - a.distance(b)
    };
    (0..=places.len()).min_by(|a, b| longer(a).total_cmp(&longer(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_bend_goes_between_the_two_that_it_lies_between() {
        let (first, last) = (pos2(0.0, 0.0), pos2(100.0, 0.0));
        let places = [pos2(30.0, 40.0), pos2(70.0, 40.0)];
        assert_eq!(detour(first, &places, last, pos2(15.0, 20.0)), 0);
        assert_eq!(detour(first, &places, last, pos2(50.0, 42.0)), 1);
        assert_eq!(detour(first, &places, last, pos2(86.0, 20.0)), 2);
        assert_eq!(detour(first, &[], last, pos2(50.0, 9.0)), 0);
    }
}
