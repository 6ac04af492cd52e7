//! A graph from a newer program is opened as far as it can be, and nothing in it is lost.

use std::fs;

use crate::common::{Editor, Place, open, press, read, select, settle};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_core::Value;
use orograph_engine::Document;

const CTRL: Modifiers = Modifiers::COMMAND;

/// What only a newer program knows, in words that no program here would choose.
const NEWER: [&str; 3] = [
    r#""later": (node: "filter.gaussian_blur", version: 9, strength: Auto, // of version 9
            params: (reach: Around(metres: 3)), inputs: {"terrain": "hills.terrain"})"#,
    r#""clouds": (node: "sky.clouds", version: 2, plugin: "Sky", params: {"cover of all": 0.5}, inputs: {"ground": "later.terrain", "light": ["later.shade", "hills.terrain"]})"#,
    r#""odd": (node: "mask.from_height", version: 1, blend: Screen, inputs: {"terrain": "hills.terrain"})"#,
];

fn newer() -> String {
    format!(
        "(format: 1, nodes: {{\"hills\": (node: \"generate.fbm\", version: 1, params: (cells: 48)),
        \"shade\": (node: \"look.hillshade\", version: 1, inputs: {{\"terrain\": \"hills.terrain\"}}), {}}},
        layout: (nodes: {{\"hills\": (0, 0), \"shade\": (300, 0), \"later\": (300, 250), \"clouds\": (600, 250), \"odd\": (0, 300)}}))",
        NEWER.join(",\n        ")
    )
}

fn opened(text: &str) -> (Place, Editor) {
    let place = Place::new();
    fs::write(&place.graph, text).unwrap();
    let editor = open(place.start());
    (place, editor)
}

fn says(editor: &Editor, words: &str) -> bool {
    editor.query_all_by_label_contains(words).count() > 0
}

#[test]
fn what_cannot_be_opened_is_told_with_the_mend_and_left_alone() {
    for (text, why, mend) in [
        ("(format: 2, graph: [])", "graph format 2 is unknown", "a newer one may read this file"),
        (
            "(format: 1, nodes: 3, materials: {})",
            "there is no field `materials` here",
            "its fields: `format`",
        ),
        (
            "(format: 1, nodes: {}, inputs: {\"a\": (type: Voxels)})",
            "there is no type `Voxels`",
            "Heightfield",
        ),
    ] {
        let (place, mut editor) = opened(text);
        let told = editor.state().app().told();
        let words = told.last().unwrap();
        assert!(words.contains("chain.ron:1:") && words.contains(why) && words.contains(mend), "{told:?}");
        press(&mut editor, CTRL, Key::S);
        assert_eq!(read(&place.graph), text.as_bytes());
        assert!(editor.state().app().settings().recent.is_empty(), "it was not opened");
    }
}

#[test]
fn what_is_not_known_stands_as_placeholders_and_the_rest_runs() {
    let (_place, mut editor) = opened(&newer());
    let told = editor.state().app().told();
    let words = told.iter().find(|words| words.starts_with("2 nodes are placeholders")).unwrap();
    assert!(words.contains("`later`: `filter.gaussian_blur` is known up to version 1 here"), "{words}");
    assert!(words.contains("`clouds`: the plugin `Sky` is not here"), "{words}");
    for port in ["output later.terrain", "output later.shade", "input clouds.ground", "input clouds.light"] {
        assert!(editor.query_by_role_and_label(Role::Button, port).is_some(), "{port}");
    }
    assert!(says(&editor, "1 problem"), "a field that a known node has not");
    select(&mut editor, "shade");
    assert!(matches!(editor.state().app().shown(), Some(Value::Texture(_))));
    select(&mut editor, "later");
    assert!(says(&editor, "saved back unchanged"));
    assert!(says(&editor, "reach: Around(metres: 3)"));
}

#[test]
fn what_is_not_known_is_saved_back_unchanged() {
    let (place, mut editor) = opened(&newer());
    select(&mut editor, "shade");
    press(&mut editor, Modifiers::NONE, Key::B);
    press(&mut editor, CTRL, Key::S);
    assert!(!editor.state().app().is_dirty());
    let saved = String::from_utf8(read(&place.graph)).unwrap();
    for node in &NEWER[..2] {
        assert!(saved.contains(node), "{node}\nis not in\n{saved}");
    }
    let mut expected = Document::parse(&newer(), "newer").unwrap();
    expected.nodes["shade"].bypass = true;
    assert_eq!(Document::parse(&saved, "saved").unwrap(), expected, "fields of nodes that are known as well");
}

/// The chain with fields of a newer format wherever a format could get some.
fn with_fields() -> String {
    crate::common::CHAIN
        .replace("    nodes: {\n", "    expose: {\"size\": (param: \"hills.cells\", group: Ground(1))},\n    nodes: {\n")
        .replace(
            "layout: (nodes:",
            "materials: {\"rock\": (rough: 0.5)},\n    layout: (zoom: 2.5, \
             frames: [(title: \"a\", rect: (-40, -40, 200, 300), colour: Red)], \
             comments: [(text: \"b\", at: (0, 500), to: \"all\")], \
             bends: [(from: \"hills.terrain\", to: \"soft.terrain\", through: [(240, 60)], style: Step)], nodes:",
        )
}

#[test]
fn fields_of_a_newer_format_are_told_kept_and_hinder_nothing_but_the_build() {
    let (place, mut editor) = opened(&with_fields());
    assert!(says(&editor, "6 problems"));
    select(&mut editor, "shade");
    assert!(matches!(editor.state().app().shown(), Some(Value::Texture(_))), "the rest runs");
    press(&mut editor, Modifiers::NONE, Key::B);
    press(&mut editor, CTRL, Key::S);
    let mut expected = Document::parse(&with_fields(), "newer").unwrap();
    expected.nodes["shade"].bypass = true;
    assert_eq!(Document::load(&place.graph).unwrap(), expected);
}

#[test]
fn a_placeholder_that_is_edited_keeps_all_that_is_not_known_of_it() {
    let (place, mut editor) = opened(&newer());
    select(&mut editor, "hills");
    editor.get_by_label("name of the node").focus();
    editor.run_steps(2);
    editor.get_by_label("name of the node").type_text("2");
    press(&mut editor, Modifiers::NONE, Key::Enter);
    press(&mut editor, CTRL, Key::S);
    let saved = Document::load(&place.graph).unwrap();
    let before = Document::parse(&newer(), "newer").unwrap();
    assert!(saved.nodes.contains_key("hills2"));
    for name in ["later", "clouds", "odd"] {
        let (saved, before) = (&saved.nodes[name], &before.nodes[name]);
        assert_eq!((&saved.body, &saved.params, &saved.extra), (&before.body, &before.params, &before.extra));
        assert_eq!(saved.plugin, before.plugin);
        assert!(saved.inputs.values().flatten().all(|link| link.node != "hills"), "wires follow");
    }
    press(&mut editor, CTRL, Key::Z);
    press(&mut editor, CTRL, Key::S);
    settle(&mut editor);
    assert_eq!(Document::load(&place.graph).unwrap(), before);
}
