//! The guide "First terrain in ten minutes" (`docs/guide/first-terrain.md`), step by step as it says.

use crate::common::{
    Editor, Place, at, drag,
    hand::{button, drag_with, in_picture, write},
    open, press, settle,
};
use eframe::egui::{Key, Modifiers, PointerButton, accesskit::Role, pos2, vec2};
use egui_kittest::kittest::Queryable;
use orograph_core::Value;

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn found(editor: &mut Editor, words: &str) -> String {
    editor.get_by_label("search nodes").type_text(words);
    editor.run_steps(3);
    press(editor, NONE, Key::Enter);
    editor.state().app().selection().pop().unwrap()
}

fn dropped(editor: &mut Editor, output: &str, offset: (f32, f32), words: &str) -> String {
    let from = at(editor, &format!("output {output}")) + vec2(3.0, 0.0);
    drag(editor, from, from + vec2(offset.0, offset.1));
    found(editor, words)
}

fn stroke(editor: &mut Editor, way: &[(f32, f32)]) {
    let way: Vec<_> = way.iter().map(|(x, y)| in_picture(editor, "view", *x, *y)).collect();
    drag_with(editor, PointerButton::Primary, NONE, &way);
}

#[test]
fn the_first_terrain_grows_as_the_guide_says() {
    let place = Place::new();
    let mut start = place.start();
    start.file = None;
    let mut editor = open(start);
    // 1. Something to draw on.
    editor.hover_at(pos2(120.0, 600.0));
    editor.run_steps(2);
    press(&mut editor, NONE, Key::Tab);
    assert_eq!(found(&mut editor, "mcmd sketch"), "sketch");
    // 2. A ridge, and a shore around it.
    button(&mut editor, "draw");
    write(&mut editor, Role::SpinButton, "height of what is drawn", "900");
    stroke(&mut editor, &[(0.2, 0.2), (0.5, 0.5), (0.8, 0.7)]);
    stroke(&mut editor, &[(0.5, 0.5), (0.3, 0.8)]);
    write(&mut editor, Role::SpinButton, "height of what is drawn", "0");
    stroke(&mut editor, &[(0.05, 0.05), (0.05, 0.95), (0.95, 0.95), (0.95, 0.05), (0.06, 0.05)]);
    assert!(editor.query_by_label_contains("3 lines").is_some());
    // 3. Terrain through it.
    assert_eq!(dropped(&mut editor, "sketch.constraints", (110.0, 0.0), "mcmd"), "mcmd");
    editor.get_by_role_and_label(Role::ComboBox, "preset").click();
    editor.run_steps(3);
    button(&mut editor, "mountains");
    let Some(Value::Heightfield(terrain)) = editor.state().app().shown().cloned() else { panic!("terrain") };
    let void = (0..terrain.rows()).any(|row| terrain.row(row).iter().any(|height| height.is_nan()));
    assert!(!void, "everything between is invented");
    let (low, high) = terrain.range().unwrap();
    assert!((850.0..2000.0).contains(&high) && low < 100.0, "{low} {high}");
    // 4. In three dimensions, with colours.
    button(&mut editor, "3D");
    editor.get_by_role_and_label(Role::ComboBox, "look of view").click();
    editor.run_steps(3);
    button(&mut editor, "colour relief");
    assert!(editor.query_by_role_and_label(Role::Image, "ground view").is_some());
    // 6. Colour it and write it.
    assert_eq!(dropped(&mut editor, "mcmd.terrain", (110.0, 0.0), "colour relief"), "colour_relief");
    assert_eq!(dropped(&mut editor, "colour_relief.picture", (110.0, 0.0), "write texture"), "write_texture");
    press(&mut editor, CTRL, Key::B);
    settle(&mut editor);
    let told = editor.state().app().told();
    assert!(told.iter().any(|text| text.contains("texture.png")), "{told:?}");
    assert!(place.out().join("texture.png").exists());
}
