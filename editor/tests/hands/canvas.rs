//! Gestures on the canvas: what a hand does to nodes, wires and frames, and what the document then holds.

use std::fs;

use crate::common::{
    Editor, Place, at, click, copied, drag,
    hand::{
        HELD_CTRL, boxed, button, choose, choosing, click_with, double_click, in_window, menu, rect, until,
        write,
    },
    open, press, read, select, settle, title,
};
use eframe::egui::{
    Event, Key, Modifiers, PointerButton, ViewportCommand, ViewportId, accesskit::Role, vec2,
};
use egui_kittest::kittest::Queryable;
use orograph_editor::Question;
use orograph_engine::Document;

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn links(editor: &Editor, node: &str, port: &str) -> Vec<String> {
    let document = editor.state().app().document();
    let links = document.nodes[node].inputs.get(port).into_iter().flatten();
    links.map(ToString::to_string).collect()
}

fn place_of(editor: &Editor, node: &str) -> (f64, f64) {
    editor.state().app().document().layout.nodes[node]
}

fn sorted(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names
}

#[test]
fn a_right_click_on_nothing_searches_and_the_node_stands_there() {
    let place = Place::new();
    let mut editor = open(place.start());
    let pos = in_window(&editor, 600.0, 300.0);
    click_with(&mut editor, PointerButton::Secondary, NONE, pos);
    editor.get_by_label("search nodes").type_text("median");
    editor.run_steps(3);
    press(&mut editor, NONE, Key::Enter);
    let name = editor.state().app().selection().pop().unwrap();
    let (x, y) = place_of(&editor, &name);
    assert!((x - 600.0).abs() < 2.0 && (y - 300.0).abs() < 2.0, "{x} {y}");
}

#[test]
fn escape_and_a_click_elsewhere_close_the_search_and_nothing_is_added() {
    let place = Place::new();
    let mut editor = open(place.start());
    let before = editor.state().app().document().clone();
    press(&mut editor, NONE, Key::Tab);
    press(&mut editor, NONE, Key::Escape);
    assert!(editor.query_by_label("search nodes").is_none());
    press(&mut editor, NONE, Key::Tab);
    let pos = in_window(&editor, 0.0, 350.0);
    click(&mut editor, pos);
    assert!(editor.query_by_label("search nodes").is_none());
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn a_box_selects_what_it_touches_and_with_ctrl_adds_to_it() {
    let place = Place::new();
    let mut editor = open(place.start());
    let (from, to) = (in_window(&editor, -40.0, -10.0), in_window(&editor, 320.0, 30.0));
    boxed(&mut editor, NONE, from, to);
    assert_eq!(sorted(editor.state().app().selection()), ["hills", "soft"]);
    let (from, to) = (in_window(&editor, 540.0, -10.0), in_window(&editor, 600.0, 30.0));
    boxed(&mut editor, HELD_CTRL, from, to);
    assert_eq!(sorted(editor.state().app().selection()), ["hills", "shade", "soft"]);
    let pos = title(&editor, "high");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    assert_eq!(editor.state().app().selection().len(), 4);
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    assert_eq!(sorted(editor.state().app().selection()), ["hills", "shade", "soft"]);
    let nothing = in_window(&editor, 0.0, 350.0);
    click(&mut editor, nothing);
    assert!(editor.state().app().selection().is_empty());
}

#[test]
fn several_nodes_move_together_as_one_step() {
    let place = Place::new();
    let mut editor = open(place.start());
    let before = editor.state().app().document().clone();
    press(&mut editor, CTRL, Key::A);
    let from = title(&editor, "soft");
    let scale = editor.state().app().to_window().scaling;
    drag(&mut editor, from, from + vec2(30.0, 50.0) * scale);
    for name in before.nodes.keys() {
        let ((x0, y0), (x1, y1)) = (before.layout.nodes[name], place_of(&editor, name));
        assert!((x1 - x0 - 30.0).abs() < 8.0 && (y1 - y0 - 50.0).abs() < 8.0, "{name}: {x1} {y1}");
    }
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn a_frame_is_titled_renamed_dragged_with_its_nodes_and_removed() {
    let place = Place::new();
    let mut editor = open(place.start());
    let before = editor.state().app().document().clone();
    select(&mut editor, "high");
    press(&mut editor, NONE, Key::F);
    write(&mut editor, Role::TextInput, "title of the frame", "Masks");
    let frames = &editor.state().app().document().layout.frames;
    assert_eq!(frames.iter().map(|frame| frame.title.as_str()).collect::<Vec<_>>(), ["Masks"]);
    let (x, y, width, height) = frames[0].rect;
    assert!(x < 280.0 && y < 260.0 && x + width > 470.0 && y + height > 370.0, "it holds the node");

    let bar = at(&editor, "frame Masks");
    let scale = editor.state().app().to_window().scaling;
    drag(&mut editor, bar, bar + vec2(40.0, 30.0) * scale);
    let (x1, y1) = place_of(&editor, "high");
    assert!((x1 - 320.0).abs() < 8.0 && (y1 - 290.0).abs() < 8.0, "the node went along: {x1} {y1}");
    assert_eq!(place_of(&editor, "soft"), (280.0, 0.0), "what stands outside stays");
    let moved = editor.state().app().document().layout.frames[0].rect;
    assert!((moved.0 - x - 40.0).abs() < 8.0 && (moved.1 - y - 30.0).abs() < 8.0, "{moved:?}");
    assert_eq!(editor.state().app().selection(), ["high"], "to move a frame selects nothing else");
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(place_of(&editor, "high"), (280.0, 260.0));

    let bar = at(&editor, "frame Masks");
    double_click(&mut editor, bar);
    write(&mut editor, Role::TextInput, "title of the frame", "Where it is high");
    assert!(editor.query_by_role_and_label(Role::Button, "frame Where it is high").is_some());
    let bar = at(&editor, "frame Where it is high");
    double_click(&mut editor, bar);
    button(&mut editor, "Remove frame");
    assert!(editor.state().app().document().layout.frames.is_empty());
    while editor.state().app().is_dirty() {
        press(&mut editor, CTRL, Key::Z);
    }
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn nodes_are_aligned_by_their_left_and_top_edges() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    let pos = title(&editor, "shade");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    press(&mut editor, NONE, Key::L);
    assert_eq!((place_of(&editor, "soft").0, place_of(&editor, "shade").0), (280.0, 280.0));
    press(&mut editor, CTRL, Key::Z);
    select(&mut editor, "high");
    let pos = title(&editor, "shade");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    press(&mut editor, NONE, Key::T);
    assert_eq!((place_of(&editor, "high").1, place_of(&editor, "shade").1), (0.0, 0.0));
}

#[test]
fn arranging_lets_wires_run_to_the_right_and_nodes_stand_apart() {
    let place = Place::new();
    let text = crate::common::CHAIN.replace("(280, 0)", "(900, 40)").replace("(560, 0)", "(20, 30)");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    let before = editor.state().app().document().clone();
    menu(&mut editor, "Node", "Arrange all");
    let document = editor.state().app().document().clone();
    for (name, node) in &document.nodes {
        for link in node.inputs.values().flatten() {
            assert!(place_of(&editor, &link.node).0 + 190.0 <= place_of(&editor, name).0, "{link} to {name}");
        }
    }
    let ((_, y0), (_, y1)) = (place_of(&editor, "soft"), place_of(&editor, "high"));
    assert!((y1 - y0).abs() > 100.0, "they stand above each other: {y0} {y1}");
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
}

#[test]
fn nodes_that_nobody_placed_stand_apart_with_their_pictures() {
    let place = Place::new();
    let (start, end) =
        (crate::common::CHAIN.find("    layout").unwrap(), crate::common::CHAIN.rfind(')').unwrap());
    fs::write(&place.graph, format!("{}{}", &crate::common::CHAIN[..start], &crate::common::CHAIN[end..]))
        .unwrap();
    let mut editor = open(place.start());
    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::A);
    // A frame holds the nodes as they are drawn; one around each tells where it stands.
    let mut frames = Vec::new();
    for port in ["hills.terrain", "soft.terrain", "high.mask", "shade.picture"] {
        let pos = at(&editor, &format!("output {port}"))
            - vec2(60.0, 0.0) * editor.state().app().to_window().scaling;
        click(&mut editor, pos);
        assert_eq!(editor.state().app().selection(), [port.split('.').next().unwrap()]);
        press(&mut editor, NONE, Key::F);
        press(&mut editor, NONE, Key::Enter);
        frames.push(editor.state().app().document().layout.frames.last().unwrap().rect);
    }
    // Frames have margins of 24, and a title of 28 above them.
    let inner = frames.iter().map(|(x, y, width, height)| (x + 24.0, y + 52.0, width - 48.0, height - 76.0));
    let inner: Vec<_> = inner.collect();
    for (index, a) in inner.iter().enumerate() {
        for b in &inner[index + 1..] {
            let apart = a.0 + a.2 <= b.0 || b.0 + b.2 <= a.0 || a.1 + a.3 <= b.1 || b.1 + b.3 <= a.1;
            assert!(apart, "{a:?} and {b:?}");
        }
    }
}

#[test]
fn a_node_is_dissolved_and_its_wires_are_joined() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, CTRL, Key::Delete);
    assert!(!editor.state().app().document().nodes.contains_key("soft"));
    assert_eq!(links(&editor, "shade", "terrain"), ["hills.terrain"]);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(links(&editor, "shade", "terrain"), ["soft.terrain"]);
}

#[test]
fn a_wire_is_clicked_and_deleted_and_shift_boxes_select_wires() {
    let place = Place::new();
    let mut editor = open(place.start());
    let middle =
        |editor: &Editor| at(editor, "output soft.terrain").lerp(at(editor, "input shade.terrain"), 0.5);
    let pos = middle(&editor);
    click(&mut editor, pos);
    press(&mut editor, NONE, Key::Delete);
    assert!(links(&editor, "shade", "terrain").is_empty());
    assert_eq!(editor.state().app().document().nodes.len(), 5, "the wire alone");
    press(&mut editor, CTRL, Key::Z);
    let pos = middle(&editor);
    boxed(&mut editor, Modifiers::SHIFT, pos + vec2(-8.0, -30.0), pos + vec2(8.0, 30.0));
    press(&mut editor, NONE, Key::Delete);
    assert!(links(&editor, "shade", "terrain").is_empty());
    assert_eq!(editor.state().app().document().nodes.len(), 5);
}

#[test]
fn nodes_whose_graph_file_cannot_be_written_stay_as_they_are() {
    let place = Place::new();
    let inner = place.folder.path().join("relief.ron");
    fs::create_dir(&inner).unwrap();
    let mut start = place.start();
    start.dialogs = choosing(&inner).0;
    let mut editor = open(start);
    let before = editor.state().app().document().clone();
    select(&mut editor, "soft");
    menu(&mut editor, "Node", "Collapse into subgraph…");
    until(&mut editor, "the error", |editor| {
        editor.state().app().told().iter().any(|told| told.contains("relief.ron"))
    });
    assert_eq!(*editor.state().app().document(), before);
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn nodes_are_collapsed_into_a_graph_file_and_expanded_again() {
    let place = Place::new();
    let inner = place.folder.path().join("relief.ron");
    let mut start = place.start();
    let (dialogs, asked) = choosing(&inner);
    start.dialogs = dialogs;
    let mut editor = open(start);
    select(&mut editor, "soft");
    let pos = title(&editor, "shade");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    let pos = editor.state().app().selection();
    assert_eq!(pos.len(), 2);
    menu(&mut editor, "Node", "Collapse into subgraph…");
    until(&mut editor, "collapse", |editor| editor.state().app().document().nodes.contains_key("relief"));
    assert_eq!(*asked.lock().unwrap(), [Question::Save]);
    assert_eq!(editor.state().app().document().nodes.len(), 4);
    assert_eq!(links(&editor, "picture", "texture"), ["relief.picture"]);
    let saved = Document::load(&inner).unwrap();
    assert_eq!(saved.nodes.len(), 2);
    assert!(
        editor.query_by_role_and_label(Role::Button, "output relief.picture").is_some(),
        "the node shows the ports of its graph"
    );
    // The picture still comes.
    select(&mut editor, "relief");
    assert!(matches!(editor.state().app().shown(), Some(orograph_core::Value::Texture(_))));

    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::G);
    assert_eq!(sorted(editor.state().app().selection()), ["relief_shade", "relief_soft"]);
    assert_eq!(links(&editor, "relief_soft", "terrain"), ["hills.terrain"]);
    assert_eq!(links(&editor, "picture", "texture"), ["relief_shade.picture"]);
    press(&mut editor, CTRL, Key::Z);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(**editor.state().app().document(), Document::parse(crate::common::CHAIN, "chain").unwrap());
}

#[test]
fn collapsing_by_its_key_a_set_that_a_wire_leaves_and_enters_again_is_refused_in_words() {
    let place = Place::new();
    let mut start = place.start();
    start.dialogs = choosing(&place.folder.path().join("inner.ron")).0;
    let mut editor = open(start);
    select(&mut editor, "hills");
    let pos = title(&editor, "shade");
    click_with(&mut editor, PointerButton::Primary, HELD_CTRL, pos);
    press(&mut editor, CTRL, Key::G);
    until(&mut editor, "the refusal", |editor| !editor.state().app().told().is_empty());
    let told = editor.state().app().told();
    assert!(told.last().unwrap().contains("choose `soft`, too"), "{told:?}");
    assert!(!place.folder.path().join("inner.ron").exists());
}

#[test]
fn a_graph_file_is_added_as_a_node() {
    let place = Place::new();
    let inner = place.folder.path().join("ground.ron");
    let text = r#"(format: 1, doc: "Smooth ground.", outputs: {"terrain": "hills.terrain"},
        nodes: {"hills": (node: "generate.fbm", version: 1)})"#;
    fs::write(&inner, text).unwrap();
    let mut start = place.start();
    start.dialogs = choosing(&inner).0;
    let mut editor = open(start);
    menu(&mut editor, "Node", "Add graph as node…");
    until(&mut editor, "the node", |editor| editor.state().app().document().nodes.contains_key("ground"));
    assert!(editor.query_by_role_and_label(Role::Button, "output ground.terrain").is_some());
    assert!(editor.query_by_label("Smooth ground.").is_some(), "the inspector tells what it is");
}

#[test]
fn show_all_brings_every_node_into_view_and_a_click_in_the_overview_looks_there() {
    let place = Place::new();
    let text = crate::common::CHAIN.replace("\"picture\": (840, 0)", "\"picture\": (4000, 1500)");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    let seen = |editor: &Editor, name: &str| editor.query_by_label(&format!("node {name}")).is_some();
    assert!(seen(&editor, "hills") && seen(&editor, "picture"), "all is in view at the start");
    // The wheel enlarges, so that not all is seen.
    let pos = title(&editor, "hills");
    editor.hover_at(pos);
    editor.run_steps(2);
    let wheel = Event::MouseWheel {
        unit: eframe::egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 12.0),
        phase: eframe::egui::TouchPhase::Move,
        modifiers: NONE,
    };
    editor.event(wheel);
    editor.run_steps(30);
    settle(&mut editor);
    assert!(seen(&editor, "hills") && !seen(&editor, "picture"));
    let overview = rect(&editor, Role::Image, "overview of the graph");
    click(&mut editor, overview.right_bottom() - vec2(9.0, 9.0));
    assert!(!seen(&editor, "hills"), "the click looks at the other end");
    press(&mut editor, NONE, Key::Home);
    assert!(seen(&editor, "hills") && seen(&editor, "picture"));
    assert!(!editor.state().app().is_dirty(), "looking changes nothing");
}

#[test]
fn an_empty_window_shows_its_first_node_as_large_as_drawn() {
    let place = Place::new();
    let mut start = place.start();
    start.file = None;
    let mut editor = open(start);
    press(&mut editor, NONE, Key::Tab);
    editor.get_by_label("search nodes").type_text("fbm");
    editor.run_steps(3);
    press(&mut editor, NONE, Key::Enter);
    assert!(editor.query_by_role_and_label(Role::Button, "output fbm.terrain").is_some());
    assert!((editor.state().app().to_window().scaling - 1.0).abs() < 0.01);
}

#[test]
fn a_node_of_an_unknown_type_is_a_placeholder_in_words_and_saved_back_as_it_was() {
    let place = Place::new();
    let odd = r#""odd": (node: "acme.magic", version: 3, params: (power: 9), inputs: {"in": "hills.terrain"}, plugin: "Acme"),"#;
    let text = crate::common::CHAIN.replace("    nodes: {\n", &format!("    nodes: {{\n        {odd}\n"));
    fs::write(&place.graph, &text).unwrap();
    let mut editor = open(place.start());
    menu(&mut editor, "Node", "Arrange all");
    select(&mut editor, "odd");
    assert!(editor.query_by_label("It is kept as it is, and saved back unchanged.").is_some());
    assert!(editor.query_all_by_label_contains("acme.magic").next().is_some(), "it says what is missing");
    assert!(editor.query_by_label("power: 9").is_some());
    assert!(editor.query_by_role_and_label(Role::Button, "input odd.in").is_some(), "its wires are drawn");
    press(&mut editor, CTRL, Key::S);
    let saved = String::from_utf8(read(&place.graph)).unwrap();
    let (saved, first) =
        (Document::parse(&saved, "saved").unwrap(), Document::parse(&text, "first").unwrap());
    assert_eq!(saved.nodes["odd"], first.nodes["odd"]);
}

#[test]
fn the_edit_menu_copies_cuts_pastes_and_duplicates() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "high");
    choose(&mut editor, "Edit", "Copy");
    let mut text = None;
    for _ in 0..6 {
        editor.run_steps(1);
        text = text.or_else(|| copied(&editor));
    }
    let text = text.unwrap();
    assert!(Document::parse(&text, "copied").unwrap().nodes.contains_key("high"));
    menu(&mut editor, "Edit", "Cut");
    assert!(!editor.state().app().document().nodes.contains_key("high"));
    // The window asks the system for what the clipboard holds, and the system answers with an event.
    choose(&mut editor, "Edit", "Paste");
    let mut wanted = false;
    for _ in 0..6 {
        editor.run_steps(1);
        let commands = &editor.output().viewport_output[&ViewportId::ROOT].commands;
        wanted |= commands.contains(&ViewportCommand::RequestPaste);
    }
    assert!(wanted, "the system is asked for the clipboard");
    editor.event(Event::Paste(text));
    settle(&mut editor);
    assert_eq!(editor.state().app().selection(), ["high"]);
    menu(&mut editor, "Edit", "Duplicate");
    assert_eq!(editor.state().app().selection(), ["high_2"]);
    assert_eq!(links(&editor, "high_2", "terrain"), ["hills.terrain"]);
    menu(&mut editor, "Edit", "Undo");
    menu(&mut editor, "Edit", "Undo");
    menu(&mut editor, "Edit", "Undo");
    assert_eq!(**editor.state().app().document(), Document::parse(crate::common::CHAIN, "chain").unwrap());
    menu(&mut editor, "Edit", "Redo");
    assert!(!editor.state().app().document().nodes.contains_key("high"));
}
