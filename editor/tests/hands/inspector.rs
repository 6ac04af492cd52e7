//! The inspector: settings, names, words and files, through the accessibility tree.

use std::fs;

use crate::common::{
    Editor, Place, drag,
    hand::{button, choosing, click_with, double_click, rect, rest, until, write},
    open, press, select, settle,
};
use eframe::egui::{Key, Modifiers, PointerButton, accesskit::Role, pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use orograph_editor::Question;
use orograph_engine::document::{Link, Literal};

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn param(editor: &Editor, node: &str, param: &str) -> Option<Literal> {
    editor.state().app().document().nodes[node].params.get(param).cloned()
}

/// A graph of one node, selected.
fn alone(node: &str) -> (Place, Editor) {
    let place = Place::new();
    let text = format!("(format: 1, nodes: {{\"it\": {node}}}, layout: (nodes: {{\"it\": (0, 0)}}))");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    select(&mut editor, "it");
    (place, editor)
}

#[test]
fn a_value_typed_beyond_the_slider_is_taken_and_beyond_the_hard_range_refused_with_the_reason() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    write(&mut editor, Role::SpinButton, "octaves", "14");
    assert_eq!(param(&editor, "hills", "octaves"), Some(Literal::Integer(14)), "sliders only suggest");
    let before = editor.state().app().document().clone();
    write(&mut editor, Role::SpinButton, "gain", "7");
    assert_eq!(*editor.state().app().document(), before, "the document is as it was");
    let why: Vec<String> = editor
        .query_all_by_label_contains("gain")
        .filter_map(|node| node.value().or(node.accesskit_node().label()))
        .collect();
    assert!(why.iter().any(|text| text.contains('7') && text.contains('1')), "the range is told: {why:?}");
    write(&mut editor, Role::SpinButton, "gain", "0.25");
    assert_eq!(param(&editor, "hills", "gain"), Some(Literal::Number(0.25)));
    assert_eq!(editor.query_all_by_label_contains("is outside").count(), 0, "what was refused is forgotten");
    // Typing is one step, however many letters it has.
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "hills", "gain"), None);
}

#[test]
fn a_slider_is_dragged_as_one_step() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    let slider = rect(&editor, Role::Slider, "amplitude");
    drag(
        &mut editor,
        slider.left_center() + (slider.size() * 0.3).x * eframe::egui::Vec2::X,
        slider.center(),
    );
    assert!(param(&editor, "hills", "amplitude").is_some());
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "hills", "amplitude"), None);
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn a_choice_is_chosen_and_a_box_is_ticked() {
    let (_place, mut editor) = alone(r#"(node: "feature.from_curves", version: 1)"#);
    editor.get_by_role_and_label(Role::ComboBox, "kind").click();
    editor.run_steps(3);
    button(&mut editor, "valley");
    assert_eq!(param(&editor, "it", "kind"), Some(Literal::Text("valley".into())));
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "it", "kind"), None);
}

#[test]
fn a_die_rolls_another_seed_each_time_and_each_is_one_step() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    button(&mut editor, "roll seed");
    let first = param(&editor, "hills", "seed").unwrap();
    button(&mut editor, "roll seed");
    let second = param(&editor, "hills", "seed").unwrap();
    assert_ne!(first, second);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "hills", "seed"), Some(first));
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "hills", "seed"), None);
}

#[test]
fn points_of_a_curve_are_added_dragged_and_taken_away() {
    let (_place, mut editor) = alone(r#"(node: "adjust.curve", version: 1)"#);
    let points = |editor: &Editor| match param(editor, "it", "curve") {
        Some(Literal::List(points)) => points.len(),
        None => 0,
        other => panic!("a curve is a list of points, not {other:?}"),
    };
    let at = |editor: &Editor, x: f32, y: f32| {
        let rect = by_label(editor, "curve").shrink(5.0);
        pos2(rect.left() + x * rect.width(), rect.bottom() - y * rect.height())
    };
    let pos = at(&editor, 0.5, 0.8);
    double_click(&mut editor, pos);
    assert_eq!(points(&editor), 5, "{:?}", param(&editor, "it", "curve"));
    let before = editor.state().app().document().clone();
    let (from, to) = (at(&editor, 0.5, 0.8), at(&editor, 0.6, 0.3));
    drag(&mut editor, from, to);
    assert_eq!(points(&editor), 5);
    assert_ne!(*editor.state().app().document(), before);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before, "a drag is one step");
    let pos = at(&editor, 0.5, 0.8);
    click_with(&mut editor, PointerButton::Secondary, NONE, pos);
    assert_eq!(points(&editor), 4);
    button(&mut editor, "reset curve");
    assert_eq!(points(&editor), 0);
}

fn text(editor: &Editor, param: &str) -> Option<String> {
    match self::param(editor, "it", param) {
        Some(Literal::Text(text)) => Some(text),
        None => None,
        other => panic!("`{param}` is text, not {other:?}"),
    }
}

#[test]
fn a_colour_is_typed_or_chosen_and_what_is_none_is_refused_with_the_reason() {
    let (_place, mut editor) = alone(r#"(node: "look.mask_overlay", version: 1)"#);
    write(&mut editor, Role::TextInput, "colour", "#102030");
    assert_eq!(text(&editor, "colour").unwrap(), "#102030");
    let before = editor.state().app().document().clone();
    write(&mut editor, Role::TextInput, "colour", "reddish");
    assert_eq!(*editor.state().app().document(), before);
    assert!(editor.query_all_by_label_contains("`reddish` is no colour").count() > 0, "the reason is told");
    // The field opens; a press in it chooses a colour, and that is one step.
    editor.get_by_role_and_label(Role::ColorWell, "choose colour").click();
    settle(&mut editor);
    let field = rect(&editor, Role::ColorWell, "choose colour");
    let pos = field.left_bottom() + eframe::egui::vec2(60.0, 90.0);
    drag(&mut editor, pos, pos + eframe::egui::vec2(30.0, 10.0));
    let chosen = text(&editor, "colour").unwrap();
    assert_ne!(chosen, "#102030");
    press(&mut editor, NONE, Key::Escape);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(text(&editor, "colour").unwrap(), "#102030", "one step");
}

#[test]
fn stops_of_a_gradient_are_made_added_dragged_coloured_and_taken_away() {
    let (_place, mut editor) = alone(r#"(node: "look.colour_relief", version: 1)"#);
    assert_eq!(text(&editor, "colours"), None);
    button(&mut editor, "make colours");
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 1 #ffffff");
    let at = |editor: &Editor, share: f32| {
        let rect = by_label(editor, "colours");
        pos2(rect.left() + 8.0 + share * (rect.width() - 16.0), rect.center().y)
    };
    let pos = at(&editor, 0.5);
    double_click(&mut editor, pos);
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 0.5 #808080, 1 #ffffff");
    let (from, to) = (at(&editor, 0.5), at(&editor, 0.25));
    drag(&mut editor, from, to);
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 0.25 #808080, 1 #ffffff");
    write(&mut editor, Role::TextInput, "colour of the stop of colours", "#c83c28");
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 0.25 #c83c28, 1 #ffffff");
    // Dragged beside a stop, nothing moves.
    let (from, to) = (at(&editor, 0.6), at(&editor, 0.9));
    drag(&mut editor, from, to);
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 0.25 #c83c28, 1 #ffffff");
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(
        text(&editor, "colours").unwrap(),
        "0 #000000, 0.25 #808080, 1 #ffffff",
        "a colour is one step"
    );
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(text(&editor, "colours").unwrap(), "0 #000000, 0.5 #808080, 1 #ffffff", "a drag is one step");
    let pos = at(&editor, 0.0);
    click_with(&mut editor, PointerButton::Secondary, NONE, pos);
    assert_eq!(text(&editor, "colours").unwrap(), "0.5 #808080, 1 #ffffff");
    button(&mut editor, "reset colours");
    assert_eq!(text(&editor, "colours"), None);
}

/// The largest of the widgets of that name: the label before it bears it as well.
fn by_label(editor: &Editor, label: &str) -> eframe::egui::Rect {
    let rects = editor.query_all_by_label(label).map(|node| node.rect());
    rects.max_by(|a, b| a.area().total_cmp(&b.area())).unwrap()
}

#[test]
fn a_file_to_read_is_chosen_in_a_dialog_and_named_relative_to_the_graph() {
    let place = Place::new();
    let text = r#"(format: 1, nodes: {"it": (node: "io.read_terrain", version: 1)}, layout: (nodes: {"it": (0, 0)}))"#;
    let registry = orograph_session::built_in().unwrap();
    let reader = registry
        .iter()
        .map(|node_type| node_type.spec().clone())
        .find(|spec| spec.params.iter().any(|param| param.kind == orograph_core::ParamKind::InputPath))
        .unwrap();
    let file = reader.params.iter().find(|param| param.kind == orograph_core::ParamKind::InputPath).unwrap();
    let text = text
        .replace("io.read_terrain", &reader.id)
        .replace("version: 1", &format!("version: {}", reader.version));
    fs::write(&place.graph, text).unwrap();
    fs::create_dir(place.folder.path().join("data")).unwrap();
    let chosen = place.folder.path().join("data/dem.tif");
    fs::write(&chosen, b"no picture").unwrap();
    let mut start = place.start();
    let (dialogs, asked) = choosing(&chosen);
    start.dialogs = dialogs;
    let mut editor = open(start);
    select(&mut editor, "it");
    let name = file.name.replace('_', " ");
    button(&mut editor, &format!("choose a file for {name}"));
    until(&mut editor, "the file", |editor| param(editor, "it", &file.name).is_some());
    assert_eq!(param(&editor, "it", &file.name), Some(Literal::Text("data/dem.tif".into())));
    assert_eq!(*asked.lock().unwrap(), [Question::Input]);
    write(&mut editor, Role::TextInput, &name, "other.tif");
    assert_eq!(param(&editor, "it", &file.name), Some(Literal::Text("other.tif".into())));
    press(&mut editor, CTRL, Key::Z);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(param(&editor, "it", &file.name), None);
}

#[test]
fn a_file_to_write_is_asked_for_as_one_to_write() {
    let place = Place::new();
    let mut start = place.start();
    let (dialogs, asked) = choosing(&place.out().join("relief.png"));
    start.dialogs = dialogs;
    let mut editor = open(start);
    select(&mut editor, "picture");
    button(&mut editor, "choose a file for file");
    until(&mut editor, "the file", |editor| {
        param(editor, "picture", "file") != Some(Literal::Text("shade.png".into()))
    });
    assert_eq!(*asked.lock().unwrap(), [Question::Output]);
    assert_eq!(
        param(&editor, "picture", "file"),
        Some(Literal::Text("relief.png".into())),
        "as builds name it: relative to the folder that they write into"
    );
}

#[test]
fn a_node_has_a_help_page_and_its_settings_have_tooltips() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    let registry = orograph_session::built_in().unwrap();
    let spec = registry.get("generate.fbm").unwrap().spec().clone();
    let gain = spec.params.iter().find(|param| param.name == "gain").unwrap();
    assert!(editor.query_by_label(&gain.doc).is_none());
    let pos = editor.get_by_role_and_label(Role::Label, "gain").rect().center();
    rest(&mut editor, pos);
    assert!(editor.query_by_label(&gain.doc).is_some(), "what the setting is");
    assert!(editor.query_by_label_contains("from 0 to").is_some(), "and its range");
    button(&mut editor, "help on this node");
    assert!(editor.query_by_role_and_label(Role::Button, "Close window").is_some());
    assert!(editor.query_all_by_label_contains(&spec.doc).count() > 0, "all that the node does");
    for param in &spec.params {
        assert!(editor.query_all_by_label_contains(&param.doc).count() > 0, "{}", param.name);
    }
    for port in spec.inputs.iter().chain(&spec.outputs) {
        assert!(editor.query_all_by_label_contains(&port.doc).count() > 0, "{}", port.name);
    }
    editor.get_by_role_and_label(Role::Button, "Close window").click();
    settle(&mut editor);
    assert!(editor.query_by_role_and_label(Role::Button, "Close window").is_none());
}

#[test]
fn ports_and_nodes_tell_what_they_are_when_the_pointer_rests_on_them() {
    let place = Place::new();
    let mut editor = open(place.start());
    let pos = crate::common::at(&editor, "input soft.terrain") - eframe::egui::vec2(3.0, 0.0);
    rest(&mut editor, pos);
    assert!(editor.query_by_label("Heightfield").is_some());
    let pos = crate::common::title(&editor, "high");
    rest(&mut editor, pos);
    let registry = orograph_session::built_in().unwrap();
    let summary = registry.get("mask.from_height").unwrap().spec().summary();
    assert!(editor.query_by_label(&summary).is_some());
}

#[test]
fn a_setting_is_reset_exposed_and_hidden_by_its_menu() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    let choose = |editor: &mut Editor, entry: &str| {
        let pos = editor.get_by_role_and_label(Role::Label, "cells").rect().center();
        click_with(editor, PointerButton::Secondary, NONE, pos);
        button(editor, entry);
    };
    choose(&mut editor, "Expose as a parameter of the graph");
    let exposed = &editor.state().app().document().expose;
    assert_eq!(exposed["cells"].param, Link::new("hills", "cells"));
    choose(&mut editor, "Do not expose");
    assert!(editor.state().app().document().expose.is_empty());
    choose(&mut editor, "Reset to default");
    assert_eq!(param(&editor, "hills", "cells"), None);
    for _ in 0..3 {
        press(&mut editor, CTRL, Key::Z);
    }
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn a_node_is_renamed_and_a_name_that_is_taken_or_none_is_refused_in_words() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    write(&mut editor, Role::TextInput, "name of the node", "smooth");
    let app = editor.state().app();
    assert_eq!(app.document().nodes["shade"].inputs["terrain"], [Link::new("smooth", "terrain")]);
    assert_eq!(app.selection(), ["smooth"]);
    write(&mut editor, Role::TextInput, "name of the node", "hills");
    assert!(editor.query_by_label_contains("there is a node `hills` already").is_some());
    write(&mut editor, Role::TextInput, "name of the node", "no name");
    assert!(editor.query_by_label_contains("`no name` is no name").is_some());
    press(&mut editor, CTRL, Key::Z);
    assert!(editor.state().app().document().nodes.contains_key("soft"));
}

#[test]
fn a_comment_is_written_shown_on_the_node_and_undone_in_one_step() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    editor.get_by_role_and_label(Role::MultilineTextInput, "comment").click();
    editor.run_steps(2);
    for letter in ["a", "b", "c"] {
        editor.get_by_role_and_label(Role::MultilineTextInput, "comment").type_text(letter);
        editor.run_steps(2);
    }
    assert_eq!(editor.state().app().document().nodes["soft"].comment, "abc");
    let pos = crate::common::title(&editor, "high");
    crate::common::click(&mut editor, pos);
    assert!(editor.query_by_role_and_label(Role::Label, "abc").is_some(), "it stands on the node");
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(editor.state().app().document().nodes["soft"].comment, "");
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn without_a_selection_the_graph_tells_of_itself_and_its_words_are_written() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    button(&mut editor, "expose sigma");
    button(&mut editor, "name output terrain");
    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::A);
    assert!(editor.query_by_label("sigma — soft.sigma").is_some());
    assert!(editor.query_by_label("terrain — soft.terrain").is_some());
    editor.get_by_role_and_label(Role::MultilineTextInput, "about the graph").click();
    editor.run_steps(2);
    editor.get_by_role_and_label(Role::MultilineTextInput, "about the graph").type_text("Hills.");
    settle(&mut editor);
    assert_eq!(editor.state().app().document().doc, "Hills.");
    button(&mut editor, "hide sigma");
    button(&mut editor, "remove output terrain");
    let document = editor.state().app().document();
    assert!(document.expose.is_empty() && document.outputs.is_empty());
    for _ in 0..5 {
        press(&mut editor, CTRL, Key::Z);
    }
    assert!(!editor.state().app().is_dirty(), "five steps");
}
