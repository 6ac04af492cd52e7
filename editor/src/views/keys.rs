//! Keys of a view that has the keyboard: arrows, plus and minus.

use eframe::egui::{self, EventFilter, Key, Vec2, vec2};

/// What the keys of a view say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Held {
    /// Steps to the right and down.
    pub(super) arrows: Vec2,
    /// Steps nearer.
    pub(super) nearer: f32,
}

/// Gives the keyboard to a view that is clicked, and says what its keys ask for.
pub(super) fn held(ui: &egui::Ui, response: &egui::Response) -> Held {
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    if !response.has_focus() {
        return Held::default();
    }
    // Arrows are the view's own; they do not walk to the next widget.
    let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    ui.input(|input| {
        let pressed = |key: Key| input.num_presses(key) as f32;
        Held {
            arrows: vec2(
                pressed(Key::ArrowRight) - pressed(Key::ArrowLeft),
                pressed(Key::ArrowDown) - pressed(Key::ArrowUp),
            ),
            nearer: pressed(Key::Plus) + pressed(Key::Equals) - pressed(Key::Minus),
        }
    })
}
