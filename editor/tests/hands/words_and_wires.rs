//! Comments on the canvas and wires that are led around, through the accessibility tree and the pointer.

use crate::common::{Editor, Place, at, click, drag, open_at, press, read, settle};
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, accesskit::Role, vec2};
use egui_kittest::kittest::Queryable;
use orograph_engine::Document;

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn double_click(editor: &mut Editor, pos: Pos2) {
    editor.hover_at(pos);
    // Longer than clicks before could be counted with these.
    editor.run_steps(60);
    for pressed in [true, false, true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        editor.event(Event::PointerButton { pos, button, pressed, modifiers });
        editor.run_steps(2);
    }
    settle(editor);
}

/// Halfway along the wire from `hills` to `high`, which runs from the upper left to the lower right.
fn halfway(editor: &Editor) -> Pos2 {
    at(editor, "output hills.terrain").lerp(at(editor, "input high.terrain"), 0.5)
}

fn through(editor: &Editor) -> Vec<(f64, f64)> {
    let layout = &editor.state().app().document().layout;
    layout.bends.iter().flat_map(|bend| bend.through.clone()).collect()
}

#[test]
fn a_wire_is_bent_by_two_clicks_dragged_and_straight_again() {
    let place = Place::new();
    let mut editor = open_at(place.start(), 60.0);
    let half = halfway(&editor);
    double_click(&mut editor, half);
    let bent = through(&editor);
    assert_eq!(bent.len(), 1);
    let label = "bend 1 of hills.terrain to high.terrain";
    let handle = at(&editor, label);
    assert!(handle.distance(half) < 8.0, "where it was clicked: {handle} and {half}");
    drag(&mut editor, handle, handle + vec2(60.0, -20.0));
    let scale = f64::from(editor.state().app().to_window().scaling);
    let moved = through(&editor);
    assert!((moved[0].0 - bent[0].0 - 60.0 / scale).abs() < 3.0, "{moved:?}");
    assert!((moved[0].1 - bent[0].1 + 20.0 / scale).abs() < 3.0, "{moved:?}");
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(through(&editor), bent);
    let handle = at(&editor, label);
    double_click(&mut editor, handle);
    assert!(through(&editor).is_empty());
}

#[test]
fn a_selected_wire_is_bent_by_a_key_and_the_bend_is_saved_and_goes_with_its_wire() {
    let place = Place::new();
    let mut editor = open_at(place.start(), 60.0);
    let half = halfway(&editor);
    click(&mut editor, half);
    press(&mut editor, NONE, Key::W);
    assert_eq!(through(&editor).len(), 1);
    press(&mut editor, CTRL, Key::S);
    let saved = Document::parse(&String::from_utf8(read(&place.graph)).unwrap(), "saved").unwrap();
    assert_eq!(saved.layout.bends, editor.state().app().document().layout.bends);
    // The wire is still selected.
    press(&mut editor, NONE, Key::Delete);
    assert!(editor.state().app().document().nodes["high"].inputs.is_empty());
    assert!(through(&editor).is_empty());
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(through(&editor).len(), 1, "the wire comes back as it was");
}

#[test]
fn a_comment_is_written_moved_written_anew_and_removed() {
    let place = Place::new();
    let mut editor = open_at(place.start(), 60.0);
    press(&mut editor, NONE, Key::C);
    editor.get_by_label("words of the comment").type_text("Why it is so soft");
    editor.run_steps(2);
    editor.get_by_role_and_label(Role::Button, "Done").click();
    settle(&mut editor);
    let comments = |editor: &Editor| editor.state().app().document().layout.comments.clone();
    assert_eq!(comments(&editor)[0].text, "Why it is so soft");
    // At its left edge: a node stands over its right half.
    let grip = |editor: &Editor| {
        let rect = editor.get_by_role_and_label(Role::Button, "comment Why it is so soft").rect();
        editor.state().app().to_window() * (rect.left_center() + vec2(3.0, 0.0))
    };
    let before = comments(&editor)[0].at;
    let pos = grip(&editor);
    drag(&mut editor, pos, pos + vec2(40.0, 180.0));
    let after = comments(&editor)[0].at;
    assert!(after.0 > before.0 + 30.0 && after.1 > before.1 + 150.0, "{before:?} to {after:?}");
    let pos = grip(&editor);
    double_click(&mut editor, pos);
    editor.get_by_role_and_label(Role::Button, "Remove comment").click();
    settle(&mut editor);
    assert!(comments(&editor).is_empty());
    for _ in 0..3 {
        press(&mut editor, CTRL, Key::Z);
    }
    assert!(comments(&editor).is_empty() && !editor.state().app().is_dirty());
}
