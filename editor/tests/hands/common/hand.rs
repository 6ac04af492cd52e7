//! What a hand does beyond a click and a drag: menus, keys held down, words typed, boxes drawn.
#![allow(clippy::unwrap_used, dead_code)]

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2, accesskit::Role, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use orograph_editor::{Dialogs, Question};

use super::{Editor, press, settle};

/// Ctrl as a keyboard sends it.
pub(crate) const HELD_CTRL: Modifiers = Modifiers { ctrl: true, command: true, ..Modifiers::NONE };

/// Chooses an entry of a menu by the pointer. What stands after the name, such as what would be undone, may differ.
pub(crate) fn menu(editor: &mut Editor, menu: &str, entry: &str) {
    choose(editor, menu, entry);
    settle(editor);
}

/// Chooses an entry of a menu; what it does comes with the next frames.
pub(crate) fn choose(editor: &mut Editor, menu: &str, entry: &str) {
    editor.get_by_role_and_label(Role::Button, menu).click();
    editor.run_steps(3);
    let entries: Vec<_> = editor.query_all_by_role(Role::Button).filter(|node| names(node, entry)).collect();
    assert_eq!(entries.len(), 1, "the menu {menu} has {entry} once");
    assert!(!entries[0].accesskit_node().is_disabled(), "{entry} can be chosen");
    entries[0].click();
}

fn names<'t>(node: &impl NodeT<'t>, entry: &str) -> bool {
    let label = node.accesskit_node().label().unwrap_or_default();
    label.strip_prefix(entry).is_some_and(|rest| rest.is_empty() || rest.starts_with([':', ' ']))
}

/// Clicks a button that there is once.
pub(crate) fn button(editor: &mut Editor, label: &str) {
    editor.get_by_role_and_label(Role::Button, label).click();
    settle(editor);
}

/// Writes into a field, over what stands there, and ends with Enter.
pub(crate) fn write(editor: &mut Editor, role: Role, label: &str, text: &str) {
    editor.get_by_role_and_label(role, label).click();
    editor.run_steps(3);
    editor.key_press_modifiers(HELD_CTRL, Key::A);
    editor.run_steps(2);
    editor.event(Event::Text(text.into()));
    editor.run_steps(2);
    press(editor, Modifiers::NONE, Key::Enter);
}

/// Presses, moves and lets go with a button and keys held.
pub(crate) fn drag_with(editor: &mut Editor, button: PointerButton, held: Modifiers, way: &[Pos2]) {
    let (from, to) = (way[0], way[way.len() - 1]);
    let pressed = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: held };
    editor.event(Event::ModifiersChanged(held));
    editor.hover_at(from);
    editor.run_steps(2);
    editor.event(pressed(from, true));
    editor.run_steps(2);
    for pair in way.windows(2) {
        for share in 1..=6u8 {
            editor.hover_at(pair[0].lerp(pair[1], f32::from(share) / 6.0));
            editor.run_steps(1);
        }
    }
    editor.run_steps(1);
    editor.event(pressed(to, false));
    editor.run_steps(1);
    editor.event(Event::ModifiersChanged(Modifiers::NONE));
    settle(editor);
}

/// Draws a box over empty space.
pub(crate) fn boxed(editor: &mut Editor, held: Modifiers, from: Pos2, to: Pos2) {
    drag_with(editor, PointerButton::Primary, held, &[from, to]);
}

/// Clicks with a button and keys held.
pub(crate) fn click_with(editor: &mut Editor, button: PointerButton, held: Modifiers, pos: Pos2) {
    let pressed = |pressed| Event::PointerButton { pos, button, pressed, modifiers: held };
    editor.event(Event::ModifiersChanged(held));
    editor.hover_at(pos);
    editor.run_steps(2);
    editor.event(pressed(true));
    editor.run_steps(1);
    editor.event(pressed(false));
    editor.run_steps(1);
    editor.event(Event::ModifiersChanged(Modifiers::NONE));
    settle(editor);
}

/// Clicks twice, fast.
pub(crate) fn double_click(editor: &mut Editor, pos: Pos2) {
    editor.hover_at(pos);
    editor.run_steps(2);
    for _ in 0..2 {
        // Within one frame: a frame of the harness is longer than a double click may last.
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        let click = [true, false].map(|pressed| Event::PointerButton { pos, button, pressed, modifiers });
        editor.input_mut().events.extend(click);
        editor.run_steps(1);
    }
    settle(editor);
}

/// Holds the pointer still until what is told of a place is told.
pub(crate) fn rest(editor: &mut Editor, pos: Pos2) {
    editor.hover_at(pos);
    editor.run_steps(40);
}

/// Where a widget outside of the canvas stands.
pub(crate) fn rect(editor: &Editor, role: Role, label: &str) -> Rect {
    editor.get_by_role_and_label(role, label).rect()
}

/// A place of the graph in the window.
pub(crate) fn in_window(editor: &Editor, x: f32, y: f32) -> Pos2 {
    editor.state().app().to_window() * pos2(x, y)
}

/// The title of a node wherever it stands, also one that the document gives no place.
pub(crate) fn beside_port(editor: &Editor, port: &str, offset: Vec2) -> Pos2 {
    let rect = editor.get_by_role_and_label(Role::Button, port).rect();
    editor.state().app().to_window() * (rect.center() + offset)
}

/// A place of the picture that a pane shows, as shares from its top left; the picture is square.
pub(crate) fn in_picture(editor: &Editor, pane: &str, x: f32, y: f32) -> Pos2 {
    let rect = rect(editor, Role::Image, &format!("picture {pane}"));
    let side = rect.width().min(rect.height());
    Rect::from_center_size(rect.center(), Vec2::splat(side)).min + vec2(x, y) * side
}

/// Dialogs that always choose one file, and what they were asked.
pub(crate) fn choosing(path: &Path) -> (Dialogs, Arc<Mutex<Vec<Question>>>) {
    let asked = Arc::new(Mutex::new(Vec::new()));
    let (path, questions): (PathBuf, _) = (path.to_owned(), asked.clone());
    let dialogs: Dialogs = Arc::new(move |question, _| {
        questions.lock().unwrap().push(question);
        Ok(Some(path.clone()))
    });
    (dialogs, asked)
}

/// Frames until the answer of a dialog, which comes from another thread, has had its effect.
pub(crate) fn until(editor: &mut Editor, what: &str, done: impl Fn(&Editor) -> bool) {
    let begun = std::time::Instant::now();
    while !done(editor) {
        assert!(begun.elapsed() < std::time::Duration::from_secs(60), "waited in vain: {what}");
        editor.run_steps(1);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    settle(editor);
}
