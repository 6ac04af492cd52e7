//! Where nodes stand that nobody placed.

use eframe::egui;
use indexmap::IndexMap;

use super::{NodeView, Wire, body, node_id, sizes};

/// A layered layout, wires running to the right.
pub(super) fn arrangement(
    ctx: &egui::Context,
    nodes: &[NodeView],
    wires: &[Wire],
) -> Vec<(String, (f64, f64))> {
    let sizes = sizes(ctx);
    let by_name: IndexMap<&str, &NodeView> = nodes.iter().map(|node| (node.name.as_str(), node)).collect();
    let boxes = nodes.iter().map(|node| {
        // What was not drawn yet gets room for its picture: that comes later, and nodes stay where they are.
        let size = sizes.get(&node_id(&node.name)).copied().unwrap_or_else(|| body::most(node));
        let size = [size.x, size.y];
        let layout_node = egui_graph::LayoutNode::new(size)
            .inputs(node.inputs.len())
            .outputs(node.outputs.len())
            .flow(egui::Direction::LeftToRight);
        (node_id(&node.name), layout_node)
    });
    let ends = wires.iter().filter_map(|(from, to)| {
        let output =
            by_name.get(from.node.as_str())?.outputs.iter().position(|port| port.name == from.port)?;
        let input = by_name.get(to.node.as_str())?.inputs.iter().position(|port| port.name == to.port)?;
        Some(((node_id(&from.node), output), (node_id(&to.node), input)))
    });
    let params = egui_graph::LayoutParams::new(egui::Direction::LeftToRight).layer_gap(70.0).node_gap(28.0);
    let (layout, _) = egui_graph::layout_routed(boxes, ends, params);
    nodes
        .iter()
        .filter_map(|node| {
            let pos = layout.get(&node_id(&node.name))?;
            Some((node.name.clone(), (f64::from(pos.x.round()), f64::from(pos.y.round()))))
        })
        .collect()
}
