//! What a user does, through the accessibility tree and the pointer: no pixels are needed.

use crate::common::{Place, at, copied, drag, event, open, press, select, settle, title, wire};
use eframe::egui::{Event, Key, Modifiers, accesskit::Role, vec2};
use egui_kittest::kittest::Queryable;
use orograph_core::Value;
use orograph_engine::{
    Document,
    document::{Link, Literal},
};

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn links(document: &Document, node: &str, port: &str) -> Vec<String> {
    let links = document.nodes[node].inputs.get(port).into_iter().flatten();
    links.map(ToString::to_string).collect()
}

#[test]
fn an_opened_graph_shows_its_ports_by_name_and_what_it_gives() {
    let place = Place::new();
    let mut editor = open(place.start());
    for port in ["output hills.terrain", "input soft.terrain", "input picture.texture"] {
        assert!(editor.query_by_role_and_label(Role::Button, port).is_some(), "{port}");
    }
    select(&mut editor, "soft");
    match editor.state().app().shown() {
        // At the preview's resolution, whatever the graph says.
        Some(Value::Heightfield(terrain)) => assert_eq!((terrain.rows(), terrain.cols()), (512, 512)),
        other => panic!("the pane shows {other:?}"),
    }
    assert!(editor.query_by_label("picture view").is_some());
}

#[test]
fn a_drag_from_port_to_port_lays_a_wire_and_undo_takes_it_away() {
    let place = Place::new();
    let mut editor = open(place.start());
    wire(&mut editor, "hills.terrain", "shade.terrain");
    assert_eq!(links(editor.state().app().document(), "shade", "terrain"), ["hills.terrain"]);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(links(editor.state().app().document(), "shade", "terrain"), ["soft.terrain"]);
    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::Z);
    assert_eq!(links(editor.state().app().document(), "shade", "terrain"), ["hills.terrain"]);
}

#[test]
fn a_refused_wire_says_why_and_offers_what_converts() {
    let place = Place::new();
    let mut editor = open(place.start());
    wire(&mut editor, "high.mask", "shade.terrain");
    let why = "`high.mask` gives a Mask, `shade.terrain` takes a Heightfield";
    assert!(editor.query_by_label_contains(why).is_some());
    editor.get_by_role_and_label(Role::Button, "Insert mask.to_height").click();
    settle(&mut editor);
    let document = editor.state().app().document().clone();
    assert_eq!(links(&document, "shade", "terrain"), ["to_height.terrain"]);
    assert_eq!(links(&document, "to_height", "mask"), ["high.mask"]);
    press(&mut editor, CTRL, Key::Z);
    assert!(!editor.state().app().document().nodes.contains_key("to_height"), "it was one step");
}

#[test]
fn tab_searches_letters_filter_and_enter_adds() {
    let place = Place::new();
    let mut editor = open(place.start());
    press(&mut editor, NONE, Key::Tab);
    editor.get_by_label("search nodes").type_text("median");
    editor.run_steps(3);
    press(&mut editor, NONE, Key::Enter);
    assert_eq!(editor.state().app().selection(), ["median"]);
    assert!(editor.query_by_role_and_label(Role::Button, "input median.terrain").is_some());
}

#[test]
fn a_wire_dropped_on_nothing_offers_what_takes_it_and_joins_it() {
    let place = Place::new();
    let mut editor = open(place.start());
    let from = at(&editor, "output soft.terrain") + vec2(3.0, 0.0);
    drag(&mut editor, from, from + vec2(30.0, 180.0));
    assert!(editor.query_by_label("takes a Heightfield").is_some());
    assert!(editor.query_by_role_and_label(Role::Button, "look.plot").is_none(), "it takes a table");
    editor.get_by_label("search nodes").type_text("slope");
    editor.run_steps(3);
    press(&mut editor, NONE, Key::Enter);
    let app = editor.state().app();
    let name = app.selection().pop().unwrap();
    assert_eq!(links(app.document(), &name, "terrain"), ["soft.terrain"]);
}

#[test]
fn nodes_are_moved_removed_and_brought_back() {
    let place = Place::new();
    let mut editor = open(place.start());
    let before = editor.state().app().document().clone();
    let from = title(&editor, "high");
    let scale = editor.state().app().to_window().scaling;
    drag(&mut editor, from, from + vec2(0.0, 60.0) * scale);
    let (x, y) = editor.state().app().document().layout.nodes["high"];
    assert!((x - 280.0).abs() < 12.0 && (y - 320.0).abs() < 12.0, "{x} {y}");
    press(&mut editor, NONE, Key::Delete);
    assert!(!editor.state().app().document().nodes.contains_key("high"));
    press(&mut editor, CTRL, Key::Z);
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(*editor.state().app().document(), before);
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn nodes_are_copied_as_text_and_pasted_from_text() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    event(&mut editor, Event::Copy);
    let text = copied(&editor).unwrap();
    assert!(Document::parse(&text, "copied").unwrap().nodes.contains_key("soft"));
    event(&mut editor, Event::Paste(text));
    settle(&mut editor);
    assert_eq!(links(editor.state().app().document(), "soft_2", "terrain"), ["hills.terrain"]);
    assert_eq!(editor.state().app().selection(), ["soft_2"]);
    event(&mut editor, Event::Paste("good morning".into()));
    assert!(editor.state().app().told().last().unwrap().contains("no nodes"));
    select(&mut editor, "soft");
    event(&mut editor, Event::Cut);
    settle(&mut editor);
    assert!(!editor.state().app().document().nodes.contains_key("soft"));
}

#[test]
fn keys_bypass_duplicate_select_and_walk() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, NONE, Key::B);
    assert!(editor.state().app().document().nodes["soft"].bypass);
    press(&mut editor, NONE, Key::ArrowLeft);
    assert_eq!(editor.state().app().selection(), ["hills"]);
    press(&mut editor, NONE, Key::ArrowRight);
    assert_eq!(editor.state().app().selection().len(), 1);
    press(&mut editor, CTRL, Key::A);
    assert_eq!(editor.state().app().selection().len(), 5);
    press(&mut editor, CTRL, Key::D);
    assert_eq!(editor.state().app().document().nodes.len(), 10);
    press(&mut editor, NONE, Key::F);
    assert_eq!(editor.state().app().document().layout.frames.len(), 1);
}

#[test]
fn the_inspector_sets_resets_exposes_and_refuses_with_the_reason() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    editor.get_by_role_and_label(Role::Button, "expose octaves").click();
    settle(&mut editor);
    let exposed = editor.state().app().document().expose["octaves"].param.clone();
    assert_eq!(exposed, Link::new("hills", "octaves"));
    editor.get_by_role_and_label(Role::Button, "reset cells").click();
    settle(&mut editor);
    assert!(!editor.state().app().document().nodes["hills"].params.contains_key("cells"));
    press(&mut editor, CTRL, Key::Z);
    assert_eq!(editor.state().app().document().nodes["hills"].params["cells"], Literal::Integer(48));
    editor.get_by_role_and_label(Role::Button, "roll seed").click();
    settle(&mut editor);
    assert!(editor.state().app().document().nodes["hills"].params.contains_key("seed"));
}

#[test]
fn a_fault_stands_at_its_node_and_the_rest_still_shows() {
    let place = Place::new();
    let mut editor = open(place.start());
    press(&mut editor, NONE, Key::Tab);
    editor.get_by_label("search nodes").type_text("combine arithmetic");
    editor.run_steps(3);
    press(&mut editor, NONE, Key::Enter);
    settle(&mut editor);
    assert!(
        editor.query_by_label_contains("1 problem").is_some()
            || editor.query_by_label_contains("problems").is_some()
    );
    select(&mut editor, "soft");
    assert!(matches!(editor.state().app().shown(), Some(Value::Heightfield(_))));
}
