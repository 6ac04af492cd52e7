//! Keys of a view that has the keyboard: arrows, plus and minus. All others stay those of the window.

use eframe::egui::{self, EventFilter, Id, Key, KeyboardShortcut, Vec2, vec2};

/// Keys that a view takes for itself.
const OWN: [Key; 7] =
    [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown, Key::Plus, Key::Equals, Key::Minus];

/// Where it is kept which view had the keyboard last.
const HOLDER: &str = "view with the keyboard";

/// What the keys of a view say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Held {
    /// Steps to the right and down.
    pub(super) arrows: Vec2,
    /// Steps nearer.
    pub(super) nearer: f32,
}

/// Whether a view has the keyboard: then nobody types, and the keys that it takes are its own.
#[must_use]
pub fn has_keyboard(ctx: &egui::Context) -> bool {
    let holder = ctx.data(|data| data.get_temp::<Id>(Id::new(HOLDER)));
    holder.is_some() && ctx.memory(egui::Memory::focused) == holder
}

/// Whether a view that has the keyboard takes the keys for itself.
#[must_use]
pub fn takes(keys: &KeyboardShortcut) -> bool {
    keys.modifiers.is_none() && OWN.contains(&keys.logical_key)
}

/// Gives the keyboard to a view that is clicked, and says what its keys ask for.
pub(super) fn held(ui: &egui::Ui, response: &egui::Response) -> Held {
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    if !response.has_focus() {
        return Held::default();
    }
    ui.data_mut(|data| data.insert_temp(Id::new(HOLDER), response.id));
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
