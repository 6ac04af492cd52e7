//! Sketching in the picture: strokes, points and the eraser, in shares of the picture and in metres.

use std::fs;

use crate::common::{
    Editor, Place, click,
    hand::{button, click_with, drag_with, in_picture, write},
    open, press, select,
};
use eframe::egui::{Key, Modifiers, PointerButton, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_core::{ParamValue, Value};
use orograph_engine::compile::param_value;

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

/// A graph with a node to draw upon, selected.
fn drawn_upon(id: &str, coordinates: &str) -> (Place, Editor) {
    let place = Place::new();
    let text = format!(
        r#"(format: 1, nodes: {{
            "hills": (node: "generate.fbm", version: 1, params: (cells: 64, width: 8000, height: 8000)),
            "sketch": (node: "{id}", version: 1, params: (coordinates: {coordinates}), inputs: {{"like": "hills.terrain"}}),
        }}, layout: (nodes: {{"hills": (0, 0), "sketch": (300, 0)}}))"#
    );
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    select(&mut editor, "sketch");
    (place, editor)
}

fn lines(editor: &Editor) -> Vec<Vec<[f64; 3]>> {
    let node = &editor.state().app().document().nodes["sketch"];
    let orograph_engine::document::Body::Type { id, .. } = &node.body else { panic!("a type") };
    let registry = orograph_session::built_in().unwrap();
    let spec = registry.get(id).unwrap().spec().clone();
    let spec = spec.params.iter().find(|param| param.name == "lines").unwrap();
    match node.params.get("lines").map(|literal| param_value(literal, spec).unwrap()) {
        Some(ParamValue::Lines(lines)) => lines,
        None => Vec::new(),
        other => panic!("lines, not {other:?}"),
    }
}

fn stroke(editor: &mut Editor, way: &[(f32, f32)]) {
    let way: Vec<_> = way.iter().map(|(x, y)| in_picture(editor, "view", *x, *y)).collect();
    drag_with(editor, PointerButton::Primary, NONE, &way);
}

fn near(a: f64, b: f64, off: f64) -> bool {
    (a - b).abs() <= off
}

/// Draws a corner, sets a point, erases the corner; then undoes all of it.
fn sketch(editor: &mut Editor, off: f64, place: impl Fn(f64, f64) -> (f64, f64)) {
    let start = editor.state().app().document().clone();
    button(editor, "draw");
    write(editor, Role::SpinButton, "height of what is drawn", "250");
    stroke(editor, &[(0.2, 0.2), (0.7, 0.2), (0.7, 0.6)]);
    let drawn = lines(editor);
    assert_eq!(drawn.len(), 1);
    let (first, last) = (drawn[0][0], drawn[0][drawn[0].len() - 1]);
    let (from, to) = (place(0.2, 0.2), place(0.7, 0.6));
    // A drag begins once the pointer has left the place where it was pressed.
    assert!(near(first[0], from.0, 3.0 * off) && near(first[1], from.1, off), "{first:?} for {from:?}");
    assert!(near(last[0], to.0, off) && near(last[1], to.1, off), "{last:?} for {to:?}");
    let corner = place(0.7, 0.2);
    assert!(
        drawn[0].iter().any(|point| near(point[0], corner.0, off) && near(point[1], corner.1, off)),
        "the corner stays: {drawn:?}"
    );
    assert!(drawn[0].len() < 8, "a straight line needs no points between: {drawn:?}");
    assert!(drawn[0].iter().all(|point| point[2] == 250.0), "the height that was set");

    button(editor, "point");
    let pos = in_picture(editor, "view", 0.4, 0.8);
    click(editor, pos);
    let with_point = lines(editor);
    assert_eq!(with_point.len(), 2);
    let at = place(0.4, 0.8);
    assert_eq!(with_point[1].len(), 1);
    assert!(near(with_point[1][0][0], at.0, off) && near(with_point[1][0][1], at.1, off));

    button(editor, "erase");
    stroke(editor, &[(0.5, 0.1), (0.5, 0.3)]);
    assert_eq!(lines(editor), with_point[1..], "the stroke that was crossed is gone, the point stays");
    press(editor, CTRL, Key::Z);
    assert_eq!(lines(editor), with_point);
    press(editor, CTRL, Key::Z);
    assert_eq!(lines(editor), drawn);
    press(editor, CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), start, "each of the three was one step");
}

#[test]
fn curves_are_drawn_as_shares_of_the_picture() {
    let (_place, mut editor) = drawn_upon("feature.from_curves", "extent");
    assert!(
        editor.query_by_role_and_label(Role::Image, "picture view").is_some(),
        "there is something to draw on"
    );
    sketch(&mut editor, 0.02, |x, y| (x, y));
}

#[test]
fn curves_are_drawn_in_metres() {
    let (_place, mut editor) = drawn_upon("feature.from_curves", "world");
    let Some(Value::Features(features)) = editor.state().app().shown().cloned() else { panic!("features") };
    let grid = features.grid.clone();
    let (first, last) = (grid.position(0, 0), grid.position(grid.rows - 1, grid.cols - 1));
    sketch(&mut editor, 160.0, |x, y| (first.x + x * (last.x - first.x), first.y + y * (last.y - first.y)));
}

#[test]
fn constraints_with_heights_are_drawn_as_shares_and_in_metres() {
    for coordinates in ["extent", "world"] {
        let (_place, mut editor) = drawn_upon("mcmd.sketch", coordinates);
        let Some(Value::Heightfield(field)) = editor.state().app().shown().cloned() else {
            panic!("a field")
        };
        let grid = field.grid().clone();
        let (first, last) = (grid.position(0, 0), grid.position(grid.rows - 1, grid.cols - 1));
        match coordinates {
            "extent" => sketch(&mut editor, 0.02, |x, y| (x, y)),
            _ => sketch(&mut editor, 160.0, |x, y| {
                (first.x + x * (last.x - first.x), first.y + y * (last.y - first.y))
            }),
        }
    }
}

#[test]
fn what_is_drawn_is_what_the_node_gives() {
    let (_place, mut editor) = drawn_upon("mcmd.sketch", "extent");
    button(&mut editor, "draw");
    write(&mut editor, Role::SpinButton, "height of what is drawn", "300");
    stroke(&mut editor, &[(0.1, 0.5), (0.9, 0.5)]);
    let Some(Value::Heightfield(field)) = editor.state().app().shown() else { panic!("a field") };
    let row = field.rows() / 2;
    let known = (row - 3..row + 4).any(|row| field.at(row, field.cols() / 2) == 300.0);
    assert!(known, "the height stands where the line was drawn");
    assert!(field.at(5, 5).is_nan());
}

#[test]
fn all_lines_are_cleared_in_the_inspector_and_come_back() {
    let (_place, mut editor) = drawn_upon("feature.from_curves", "extent");
    button(&mut editor, "draw");
    stroke(&mut editor, &[(0.2, 0.2), (0.7, 0.2)]);
    stroke(&mut editor, &[(0.2, 0.7), (0.7, 0.7)]);
    assert!(editor.query_by_label_contains("2 lines").is_some());
    button(&mut editor, "clear lines");
    assert!(lines(&editor).is_empty());
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(lines(&editor).len(), 2);
}

#[test]
fn a_node_without_lines_has_no_brushes() {
    let (_place, mut editor) = drawn_upon("feature.from_curves", "extent");
    button(&mut editor, "draw");
    select(&mut editor, "hills");
    assert!(editor.query_by_role_and_label(Role::Button, "draw").is_none());
    let before = editor.state().app().document().clone();
    stroke(&mut editor, &[(0.2, 0.2), (0.7, 0.2)]);
    assert_eq!(*editor.state().app().document(), before, "the pointer moves the picture again");
}

#[test]
fn a_sketch_is_drawn_upon_although_the_view_shows_ground() {
    let (_place, mut editor) = drawn_upon("mcmd.sketch", "extent");
    button(&mut editor, "draw");
    stroke(&mut editor, &[(0.2, 0.3), (0.8, 0.6)]);
    button(&mut editor, "3D");
    let words = "Heights are known in single places or along lines alone: look at them in 2D";
    assert!(editor.query_by_label(words).is_some(), "lines are no ground");
    button(&mut editor, "point");
    assert!(editor.query_by_label(words).is_none(), "a tool shows what it draws upon");
    let place = in_picture(&editor, "view", 0.5, 0.8);
    click_with(&mut editor, PointerButton::Primary, NONE, place);
    assert_eq!(lines(&editor).len(), 2);
}
