//! The canvas: nodes and wires drawn, gestures told. It keeps no model; what a gesture means is decided elsewhere.
//!
//! The one place that knows the widget library for graphs. It is given what to draw in every frame and answers with
//! [`Gesture`]s in the document's words, so another library would change this folder alone.

mod afar;
mod arrange;
mod background;
mod body;
mod fit;
mod overview;
mod tips;
mod wheel;
mod wires;

use std::collections::{HashMap, HashSet};

use eframe::egui::{self, Pos2, Rect, Vec2, emath::TSTransform, pos2, vec2};
use egui_graph::{
    NodeId, SocketKind,
    node::{EdgeEvent, Node as Widget, NodeResponse},
};
use indexmap::{IndexMap, IndexSet};
use orograph_core::ValueType;
use orograph_edit::Badge;
use orograph_engine::document::{Layout, Link};

use crate::theme;
use afar::{Afar, Block, FAR};
use arrange::arrangement;
use background::Held;
use body::Body;

/// A port as it is drawn.
#[derive(Clone, Debug)]
pub struct PortView {
    /// Its name.
    pub name: String,
    /// The type of its wires.
    pub value_type: Option<ValueType>,
    /// What it carries.
    pub doc: String,
}

/// A node as it is drawn.
#[derive(Clone, Debug)]
pub struct NodeView {
    /// Its name.
    pub name: String,
    /// What it is: a type's id or a graph's file.
    pub kind: String,
    /// The part of the id that its colour goes by.
    pub family: String,
    /// What it does, in a sentence.
    pub summary: String,
    /// Its inputs.
    pub inputs: Vec<PortView>,
    /// Its outputs.
    pub outputs: Vec<PortView>,
    /// Where it stands, when the document says so.
    pub position: Option<(f64, f64)>,
    /// It hands its inputs on.
    pub bypass: bool,
    /// It is a placeholder.
    pub unknown: bool,
    /// Why it is there.
    pub comment: String,
    /// How it stands.
    pub badge: Option<Badge>,
    /// What is wrong with it.
    pub fault: Option<String>,
    /// A small picture of what it gives.
    pub thumbnail: Option<egui::TextureId>,
}

/// A wire from an output to an input.
pub type Wire = (Link, Link);

/// What the user did.
#[derive(Clone, Debug, PartialEq)]
pub enum Gesture {
    /// Nodes were moved to these places.
    Move(Vec<(String, (f64, f64))>),
    /// A wire was drawn from an output to an input.
    Connect(Wire),
    /// A wire was drawn into empty space: from this port, an output when the flag says so.
    DropWire(Link, bool, (f64, f64)),
    /// Wires are to go.
    Disconnect(Vec<Wire>),
    /// Nodes are to go.
    Remove(Vec<String>),
    /// A node is to be added at this place.
    Search((f64, f64)),
    /// The selection is another one.
    Selected,
    /// A frame was moved, with the nodes in it.
    MoveFrame(usize, (f64, f64)),
    /// A frame's title was clicked twice.
    RenameFrame(usize),
    /// A comment was moved.
    MoveComment(usize, (f64, f64)),
    /// A comment was clicked twice.
    EditComment(usize),
    /// A wire is led through these places.
    Bend(Wire, Vec<(f64, f64)>),
}

/// The state of the view: where one looks, and what is selected.
#[derive(Default)]
pub struct Canvas {
    view: egui_graph::View,
    /// Selected nodes.
    pub selection: IndexSet<String>,
    /// Selected wires.
    pub wires: IndexSet<Wire>,
    /// Where nodes stand that the document gives no place.
    automatic: IndexMap<String, (f64, f64)>,
    from: Option<(String, SocketKind, usize)>,
    select: Option<HashSet<NodeId>>,
    held: Option<(Held, Vec2)>,
    /// Heights of what nodes hold, as drawn from near, and whether a picture was among it.
    heights: HashMap<String, (f32, bool)>,
    /// From places in the graph to places in the window, of the last frame.
    to_window: TSTransform,
    rect: Option<Rect>,
    wheel: wheel::Wheel,
    fit: fit::Fit,
    afar: Afar,
}

fn id() -> egui::Id {
    egui_graph::id("graph")
}

fn node_id(name: &str) -> NodeId {
    NodeId::new(name)
}

impl Canvas {
    /// Shows all of the graph in the next frame.
    pub fn fit(&mut self) {
        self.fit.ask();
    }

    /// Selects these nodes.
    pub fn select(&mut self, names: impl IntoIterator<Item = String>) {
        self.selection = names.into_iter().collect();
        self.wires.clear();
        self.select = Some(self.selection.iter().map(|name| node_id(name)).collect());
    }

    /// A place in the graph under a place in the window.
    #[must_use]
    pub fn place_at(&self, pos: Pos2) -> (f64, f64) {
        let pos = self.to_window.inverse() * pos;
        (f64::from(pos.x), f64::from(pos.y))
    }

    /// From places in the graph to places in the window.
    #[must_use]
    pub fn to_window(&self) -> TSTransform {
        self.to_window
    }

    /// The middle of what is seen.
    #[must_use]
    pub fn middle(&self) -> (f64, f64) {
        self.place_at(self.rect().center())
    }

    /// The part of the window that the canvas takes.
    #[must_use]
    pub fn rect(&self) -> Rect {
        self.rect.unwrap_or(Rect::ZERO)
    }

    /// Where the canvas puts nodes that the document gives no place.
    #[must_use]
    pub fn automatic(&self) -> &IndexMap<String, (f64, f64)> {
        &self.automatic
    }

    /// Lays out all nodes anew, those with a place as well.
    pub fn lay_out(
        &mut self,
        ctx: &egui::Context,
        nodes: &[NodeView],
        wires: &[Wire],
    ) -> Vec<(String, (f64, f64))> {
        arrangement(ctx, nodes, wires)
    }

    /// Where a node stands.
    #[must_use]
    pub fn place_of(&self, name: &str) -> Option<(f64, f64)> {
        let place = self.view.layout.get(&node_id(name))?;
        Some((f64::from(place.x), f64::from(place.y)))
    }

    /// A place halfway along a wire that runs straight.
    #[must_use]
    pub fn halfway(&self, (from, to): &Wire) -> Option<(f64, f64)> {
        let start = *self.view.layout.get(&node_id(&from.node))? + vec2(body::WIDTH, 60.0);
        let end = *self.view.layout.get(&node_id(&to.node))? + vec2(0.0, 60.0);
        let half = start.lerp(end, 0.5);
        Some((f64::from(half.x.round()), f64::from(half.y.round())))
    }

    /// The least rectangle around nodes, by their drawn sizes.
    #[must_use]
    pub fn bounds(&self, ctx: &egui::Context, names: &[&str]) -> Option<((f64, f64), (f64, f64))> {
        let sizes = sizes(ctx);
        let rects = names.iter().filter_map(|name| {
            let id = node_id(name);
            let size = sizes.get(&id).copied().unwrap_or(DEFAULT_SIZE);
            Some(Rect::from_min_size(*self.view.layout.get(&id)?, size))
        });
        let all = rects.reduce(Rect::union)?;
        let corner = |pos: Pos2| (f64::from(pos.x), f64::from(pos.y));
        Some((corner(all.min), corner(all.max)))
    }

    /// Draws the graph and tells what the user did.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        nodes: &[NodeView],
        wires: &[Wire],
        layout: &Layout,
    ) -> Vec<Gesture> {
        self.rect = Some(ui.available_rect_before_wrap());
        let ctx = ui.ctx().clone();
        self.place(&ctx, nodes, wires);
        let mut gestures = Vec::new();
        let rects = self.rects(&ctx, nodes);
        self.look_at_all(&ctx, &rects, layout);
        self.afar.look(&ctx, self.to_window, &rects);
        let index: IndexMap<NodeId, usize> =
            nodes.iter().enumerate().map(|(index, node)| (node_id(&node.name), index)).collect();
        let mut graph =
            egui_graph::Graph::from_id(id()).zoom_range(wheel::SCALES).snap(Some(egui_graph::Snap::Round));
        // From afar its dots would be many, and less than a pixel.
        graph = graph.dot_grid(self.to_window.scaling >= FAR);
        if let Some(selection) = self.select.take() {
            graph = graph.selected_nodes(selection);
        }
        let mut view = std::mem::take(&mut self.view);
        let turned = self.wheel.take(ui, self.rect());
        let response = graph.show(&mut view, ui, |ui, show| {
            self.to_window = ui.ctx().layer_transform_to_global(ui.layer_id()).unwrap_or_default();
            self.frames(ui, &layout.frames, &mut gestures);
            self.comments(ui, &layout.comments, &mut gestures);
            let mut removed = Vec::new();
            let mut painted = Vec::new();
            let show = show.nodes(ui, |nodes_ctx, ui| {
                let seen = ui.clip_rect();
                for (node, (rect, _)) in nodes.iter().zip(&rects) {
                    let is_paint =
                        self.height(node).is_some() && self.afar.is_paint(node_id(&node.name), *rect);
                    if is_paint {
                        // Out of view, the widget library keeps a node and spares its widgets: so it does here.
                        ui.set_clip_rect(Rect::NOTHING);
                    }
                    let response = self.node(nodes_ctx, ui, node, nodes, &mut gestures, &mut removed);
                    ui.set_clip_rect(seen);
                    if !seen.intersects(response.rect) {
                        continue;
                    }
                    response.widget_info(|| {
                        let label = format!("node {}", node.name);
                        egui::WidgetInfo::labeled(egui::WidgetType::Other, true, label)
                    });
                    if is_paint {
                        painted.push((node, Block { rect: response.rect, selected: response.selected() }));
                    }
                }
            });
            if self.from.is_some() || self.held.is_some() {
                self.afar.no_box();
            }
            if !removed.is_empty() {
                gestures.push(Gesture::Remove(removed));
            }
            show.edges(ui, |edges_ctx, ui| {
                self.edges(edges_ctx, ui, nodes, wires, &layout.bends, &mut gestures);
            });
            for (node, block) in &painted {
                self.afar.paint(ui, node, block);
            }
        });
        self.view = view;
        self.turn(&ctx, turned);
        if let Some(selected) = response.selection_changed {
            let names = nodes.iter().map(|node| &node.name);
            self.selection = names.filter(|name| selected.contains(&node_id(name))).cloned().collect();
            gestures.push(Gesture::Selected);
        }
        if response.nodes_moved {
            let moved = self.selection.iter().filter_map(|name| {
                let pos = self.view.layout.get(&node_id(name))?;
                index.get(&node_id(name)).map(|_| (name.clone(), (f64::from(pos.x), f64::from(pos.y))))
            });
            gestures.push(Gesture::Move(moved.collect()));
        }
        self.background(ui, &response.response, &mut gestures);
        if let Some(rect) = overview::show(ui, self.rect(), &rects, self.view.scene_rect) {
            self.view.scene_rect = rect;
        }
        gestures
    }

    /// Enlarges by the wheel.
    fn turn(&mut self, ctx: &egui::Context, turned: f32) {
        if turned != 0.0
            && let Some(pos) = ctx.input(|input| input.pointer.latest_pos())
        {
            let at = self.to_window.inverse() * pos;
            self.view.scene_rect = wheel::enlarged(self.view.scene_rect, at, self.to_window.scaling, turned);
            ctx.request_repaint();
        }
    }

    /// Clicks beside the nodes.
    fn background(&mut self, ui: &egui::Ui, response: &egui::Response, gestures: &mut Vec<Gesture>) {
        let pointer = ui.input(|input| input.pointer.latest_pos());
        let asked = response.secondary_clicked() || response.double_clicked();
        if asked && let Some(pos) = pointer {
            gestures.push(Gesture::Search(self.place_at(pos)));
        }
        if response.clicked() && !self.wires.is_empty() {
            self.wires.clear();
        }
    }

    /// Brings the widget's layout in line with the document, but for what is being dragged.
    fn place(&mut self, ctx: &egui::Context, nodes: &[NodeView], wires: &[Wire]) {
        let homeless =
            nodes.iter().any(|node| node.position.is_none() && !self.automatic.contains_key(&node.name));
        if homeless {
            let all = arrangement(ctx, nodes, wires);
            self.automatic = all.into_iter().collect();
        }
        let dragging = ctx.input(|input| input.pointer.primary_down());
        let mut layout = egui_graph::Layout::default();
        for node in nodes {
            let id = node_id(&node.name);
            let place = node.position.or_else(|| self.automatic.get(&node.name).copied()).unwrap_or_default();
            let place = pos2(place.0 as f32, place.1 as f32);
            let held = self.view.layout.get(&id).filter(|_| dragging && self.selection.contains(&node.name));
            layout.insert(id, held.copied().unwrap_or(place));
        }
        self.view.layout = layout;
        let there: HashSet<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
        self.selection.retain(|name| there.contains(name.as_str()));
        self.wires.retain(|wire| wires.contains(wire));
    }

    /// Where every node stands and its colour.
    fn rects(&self, ctx: &egui::Context, nodes: &[NodeView]) -> Vec<(Rect, egui::Color32)> {
        let dark = ctx.global_style().visuals.dark_mode;
        egui_graph::with_graph_memory(ctx, id(), |memory| {
            let rect = |node: &NodeView| {
                let id = node_id(&node.name);
                let size = memory.node_sizes().get(&id).copied().unwrap_or(DEFAULT_SIZE);
                let place = self.view.layout.get(&id).copied().unwrap_or_default();
                let rect = Rect::from_min_size(place, size);
                (rect, theme::family(&node.family, dark))
            };
            nodes.iter().map(rect).collect()
        })
    }

    fn look_at_all(&mut self, ctx: &egui::Context, rects: &[(Rect, egui::Color32)], layout: &Layout) {
        let frames = layout.frames.iter().map(|frame| {
            let (x, y, width, height) = frame.rect;
            Rect::from_min_size(pos2(x as f32, y as f32), vec2(width as f32, height as f32))
        });
        let all = rects.iter().map(|(rect, _)| *rect).chain(frames).reduce(Rect::union);
        // Of an empty graph the place where its first nodes will stand.
        let all = all.unwrap_or(Rect::from_center_size(Pos2::ZERO, Vec2::ZERO));
        if !self.fit.is_due(ctx, all) {
            return;
        }
        // As large as drawn where that fits, else smaller.
        let all = all.expand(40.0);
        let size = all.size().max(self.rect().size());
        self.view.scene_rect = Rect::from_center_size(all.center(), size);
    }

    /// How high a node's inside is. A picture that came meanwhile makes it higher, so that it has to be drawn from near.
    fn height(&self, node: &NodeView) -> Option<f32> {
        let (height, pictured) = self.heights.get(&node.name)?;
        (*pictured == node.thumbnail.is_some()).then_some(*height)
    }

    fn node(
        &mut self,
        nodes_ctx: &mut egui_graph::NodesCtx<'_>,
        ui: &mut egui::Ui,
        node: &NodeView,
        nodes: &[NodeView],
        gestures: &mut Vec<Gesture>,
        removed: &mut Vec<String>,
    ) -> NodeResponse<Option<Body>> {
        let known = self.height(node);
        let response = Widget::from_id(node_id(&node.name))
            .inputs(node.inputs.len())
            .outputs(node.outputs.len())
            .flow(egui::Direction::LeftToRight)
            .max_width(body::WIDTH)
            .socket_color(egui::Color32::TRANSPARENT)
            .socket_radius(SOCKET)
            .animation_time(0.0)
            .show_or_cull(nodes_ctx, ui, |ctx| match (self.to_window.scaling < FAR, known) {
                (true, Some(height)) => body::from_afar(ctx, node, height),
                _ => body::show(ctx, node),
            });
        if let Some(Body::Near(height)) = response.inner() {
            self.heights.insert(node.name.clone(), (*height, node.thumbnail.is_some()));
        }
        let ports = [("input", &node.inputs), ("output", &node.outputs)];
        let sockets = response.sockets();
        let responses = sockets
            .inputs()
            .map(|(index, response)| (0, index, response))
            .chain(sockets.outputs().map(|(index, response)| (1, index, response)));
        for (side, index, socket) in responses {
            let (kind, ports) = ports[side];
            let Some(port) = ports.get(index) else { continue };
            socket.widget_info(|| {
                let label = format!("{kind} {}.{}", node.name, port.name);
                egui::WidgetInfo::labeled(egui::WidgetType::Button, true, label)
            });
            tips::port(socket, port);
        }
        if let Some(event) = response.edge_event() {
            match event {
                EdgeEvent::Started { kind, index } => self.from = Some((node.name.clone(), kind, index)),
                EdgeEvent::Ended { kind, index } => self.ended(node, kind, index, nodes, gestures),
                EdgeEvent::Cancelled => self.dropped(ui, nodes, gestures),
            }
        }
        if response.removed() {
            removed.push(node.name.clone());
        }
        response
    }
}

/// How far ports reach out of their node, which is how much of them can be caught.
const SOCKET: f32 = 6.5;

/// The size of a node that was not drawn yet.
const DEFAULT_SIZE: Vec2 = Vec2::new(body::WIDTH, 110.0);

fn sizes(ctx: &egui::Context) -> std::collections::HashMap<NodeId, Vec2> {
    egui_graph::with_graph_memory(ctx, id(), |memory| memory.node_sizes().clone())
}
