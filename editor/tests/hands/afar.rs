//! A graph seen from so far that its nodes are blocks: the same gestures do the same things.

use std::fs;

use eframe::egui::{Key, Modifiers, PointerButton, vec2};
use orograph_engine::document::Link;

use crate::common::{
    CHAIN, Editor, Place, drag,
    hand::{HELD_CTRL, boxed, click_with, in_window},
    open, press, select, title,
};

const NONE: Modifiers = Modifiers::NONE;

/// The chain with its nodes ten times as far apart.
fn from_afar() -> (Place, Editor) {
    let place = Place::new();
    let text = CHAIN
        .replace("80, ", "800, ")
        .replace(", 260)", ", 2600)")
        .replace("(560, ", "(5600, ")
        .replace("(840, ", "(8400, ");
    fs::write(&place.graph, text).unwrap();
    let editor = open(place.start());
    assert!(editor.state().app().to_window().scaling < 0.35, "nobody could read it");
    (place, editor)
}

fn selected(editor: &Editor) -> Vec<String> {
    let mut names = editor.state().app().selection();
    names.sort_unstable();
    names
}

#[test]
fn nodes_are_selected_by_clicks_and_boxes_and_deleted() {
    let (_place, mut editor) = from_afar();
    let before = editor.state().app().document().clone();
    select(&mut editor, "soft");
    select(&mut editor, "picture");
    let pos = title(&editor, "hills");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    assert_eq!(selected(&editor), ["hills", "picture"]);
    let (from, to) = (in_window(&editor, 400.0, -30.0), in_window(&editor, 6000.0, 30.0));
    boxed(&mut editor, NONE, from, to);
    assert_eq!(selected(&editor), ["shade", "soft"]);
    press(&mut editor, NONE, Key::Delete);
    assert_eq!(
        editor.state().app().document().nodes.keys().collect::<Vec<_>>(),
        ["hills", "high", "picture"]
    );
    press(&mut editor, HELD_CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn a_node_is_dragged_along_with_all_that_are_selected() {
    let (_place, mut editor) = from_afar();
    let before = editor.state().app().document().clone();
    press(&mut editor, HELD_CTRL, Key::A);
    let from = title(&editor, "soft");
    let scale = editor.state().app().to_window().scaling;
    drag(&mut editor, from, from + vec2(500.0, 300.0) * scale);
    for (name, (x, y)) in &before.layout.nodes {
        let (x1, y1) = editor.state().app().document().layout.nodes[name];
        assert!((x1 - x - 500.0).abs() < 40.0 && (y1 - y - 300.0).abs() < 40.0, "{name}: {x1} {y1}");
    }
    press(&mut editor, HELD_CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn a_wire_is_drawn_from_port_to_port_and_taken_away() {
    let (_place, mut editor) = from_afar();
    let before = editor.state().app().document().clone();
    // The rows of ports stand below the title, the first at about this height.
    let port = |editor: &Editor, name: &str, right: bool| {
        let (x, y) = editor.state().app().document().layout.nodes[name];
        in_window(editor, x as f32 + if right { 193.0 } else { -3.0 }, y as f32 + 60.0)
    };
    let (from, to) = (port(&editor, "hills", true), port(&editor, "shade", false));
    drag(&mut editor, from, to);
    let wired = editor.state().app().document().clone();
    assert_eq!(wired.nodes["shade"].inputs["terrain"], [Link::new("hills", "terrain")]);
    // A click halfway along a wire that runs straight selects it.
    let (from, to) = (port(&editor, "hills", true), port(&editor, "soft", false));
    click_with(&mut editor, PointerButton::Primary, NONE, from.lerp(to, 0.5));
    press(&mut editor, NONE, Key::Delete);
    assert!(editor.state().app().document().nodes["soft"].inputs.is_empty());
    press(&mut editor, HELD_CTRL, Key::Z);
    press(&mut editor, HELD_CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
}
