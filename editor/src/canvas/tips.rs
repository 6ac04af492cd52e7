//! What a port is, told when the pointer rests on it.

use eframe::egui;

use super::PortView;

/// Tells of a port. The widget library lets a node's frame take the pointer from the ports on its edge, so the rest of
/// the pointer is looked at here.
pub(super) fn port(socket: &egui::Response, port: &PortView) {
    let ctx = &socket.ctx;
    if !socket.contains_pointer() {
        return;
    }
    let delay = ctx.global_style().interaction.tooltip_delay;
    let (still, busy) =
        ctx.input(|input| (input.pointer.time_since_last_movement(), input.pointer.any_down()));
    if busy {
        return;
    }
    if still < delay {
        ctx.request_repaint_after(std::time::Duration::from_secs_f32(delay - still));
        return;
    }
    let tip = egui::Tooltip::always_open(
        ctx.clone(),
        socket.layer_id,
        socket.id.with("tip"),
        egui::PopupAnchor::Pointer,
    );
    tip.gap(12.0).show(|ui| {
        ui.strong(&port.name);
        ui.label(port.value_type.map_or_else(|| "of unknown type".to_owned(), |kind| kind.to_string()));
        ui.label(&port.doc);
    });
}
