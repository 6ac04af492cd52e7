//! Panes: what they show, how, and of what; variations; what is computed and what is not.

use std::fs;

use crate::common::{
    Editor, Place,
    hand::{button, click_with, menu, rect},
    open, press, select, settle,
};
use eframe::egui::{Key, Modifiers, PointerButton, accesskit::Role, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use orograph_core::Value;
use orograph_engine::document::Literal;

const NONE: Modifiers = Modifiers::NONE;

fn image(editor: &Editor, label: &str) -> bool {
    editor.query_by_role_and_label(Role::Image, label).is_some()
}

#[test]
fn the_preview_follows_the_selection_and_a_pin_holds_it() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    assert!(matches!(editor.state().app().shown(), Some(Value::Heightfield(_))));
    select(&mut editor, "high");
    assert!(matches!(editor.state().app().shown(), Some(Value::Mask(_))));
    press(&mut editor, NONE, Key::P);
    select(&mut editor, "soft");
    assert!(matches!(editor.state().app().shown(), Some(Value::Mask(_))), "the pane stays");
    press(&mut editor, NONE, Key::P);
    assert!(matches!(editor.state().app().shown(), Some(Value::Heightfield(_))), "and follows again");
    // A node that gives nothing shows what it is given.
    select(&mut editor, "picture");
    assert!(matches!(editor.state().app().shown(), Some(Value::Texture(_))));
}

#[test]
fn a_second_pane_keeps_what_was_seen_to_compare_with() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, NONE, Key::V);
    select(&mut editor, "high");
    assert!(image(&editor, "picture view") && image(&editor, "picture second view"));
    assert!(matches!(editor.state().app().shown(), Some(Value::Mask(_))));
    let named = |title: &str| {
        let titles = editor.query_all_by_label(title);
        titles.filter(|node| node.accesskit_node().role() == Role::Label).count()
    };
    assert_eq!((named("high.mask"), named("soft.terrain")), (1, 1));
    // The second is let go and follows, too.
    let pins: Vec<_> = editor.query_all_by_role_and_label(Role::CheckBox, "pin").collect();
    assert_eq!(pins.len(), 2);
    pins[1].click();
    drop(pins);
    settle(&mut editor);
    let titles = editor.query_all_by_label("high.mask");
    assert_eq!(titles.filter(|node| node.accesskit_node().role() == Role::Label).count(), 2);
    press(&mut editor, NONE, Key::V);
    assert!(!image(&editor, "picture second view"));
}

#[test]
fn ground_is_walked_around_and_left_again() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    let before = editor.state().app().document().clone();
    button(&mut editor, "3D");
    assert!(image(&editor, "ground view") && !image(&editor, "picture view"));
    let middle = rect(&editor, Role::Image, "ground view").center();
    crate::common::drag(&mut editor, middle, middle + vec2(80.0, 20.0));
    for slider in ["height", "sun from", "sun height"] {
        assert!(editor.query_all_by_role_and_label(Role::Slider, slider).count() > 0, "{slider}");
    }
    button(&mut editor, "2D");
    assert!(image(&editor, "picture view"));
    assert_eq!(*editor.state().app().document(), before, "looking is no edit");
}

#[test]
fn another_look_is_chosen_from_those_that_fit() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    editor.get_by_role_and_label(Role::ComboBox, "look of view").click();
    editor.run_steps(3);
    assert!(editor.query_by_role_and_label(Role::Button, "mask overlay").is_none(), "that is for masks");
    button(&mut editor, "colour relief");
    let shown = editor.get_by_role_and_label(Role::ComboBox, "look of view").value();
    assert_eq!(shown.as_deref(), Some("colour relief"));
    assert!(image(&editor, "picture view"));
}

#[test]
fn metrics_are_a_table_of_words_and_numbers() {
    let place = Place::new();
    let text = crate::common::CHAIN.replace(
        "    },\n    layout",
        "        \"numbers\": (node: \"measure.statistics\", version: 1, inputs: {\"terrain\": \"hills.terrain\"}),\n    },\n    layout",
    );
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    menu(&mut editor, "Node", "Arrange all");
    select(&mut editor, "numbers");
    assert!(matches!(editor.state().app().shown(), Some(Value::Table(_))));
    assert!(editor.query_by_label("mean").is_some() || editor.query_by_label_contains("mean").is_some());
}

#[test]
fn variations_are_a_grid_of_pictures_and_a_click_takes_one() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "hills");
    let pos = editor.get_by_role_and_label(Role::Label, "octaves").rect().center();
    click_with(&mut editor, PointerButton::Secondary, NONE, pos);
    button(&mut editor, "Show variations");
    settle(&mut editor);
    let pictures: Vec<String> = editor
        .query_all_by_role(Role::Button)
        .filter_map(|node| node.accesskit_node().label())
        .filter(|label| label.starts_with("take "))
        .collect();
    assert!(pictures.len() > 3, "{pictures:?}");
    let mut apart = pictures.clone();
    apart.dedup();
    assert_eq!(apart, pictures, "each value once");
    button(&mut editor, &pictures[2]);
    let taken = pictures[2].trim_start_matches("take ").parse().unwrap();
    assert_eq!(editor.state().app().document().nodes["hills"].params["octaves"], Literal::Integer(taken));
    assert!(editor.query_by_role_and_label(Role::Button, &pictures[3]).is_none(), "the grid is closed");
    press(&mut editor, Modifiers::COMMAND, Key::Z);
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn pictures_on_nodes_are_shown_and_put_away() {
    let place = Place::new();
    let mut editor = open(place.start());
    for node in ["hills", "soft", "high", "shade"] {
        assert!(image(&editor, &format!("picture of {node}")), "{node}");
    }
    menu(&mut editor, "View", "Pictures on nodes");
    assert!(!image(&editor, "picture of hills"));
    menu(&mut editor, "View", "Pictures on nodes");
    assert!(image(&editor, "picture of hills"));
}

#[test]
fn what_is_under_way_is_stopped_and_the_next_edit_goes_on() {
    let place = Place::new();
    let text = crate::common::CHAIN.replace("params: (cells: 48)", "params: (cells: 48, octaves: 12)");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    editor.get_by_role_and_label(Role::Button, "Build").click();
    editor.run_steps(1);
    editor.key_press(Key::Escape);
    settle(&mut editor);
    assert!(editor.state().app().is_idle());
    select(&mut editor, "hills");
    button(&mut editor, "roll seed");
    select(&mut editor, "soft");
    assert!(matches!(editor.state().app().shown(), Some(Value::Heightfield(_))));
}

#[test]
fn the_preview_is_as_fine_as_is_asked_for() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    editor.get_by_role_and_label(Role::ComboBox, "resolution of the preview").click();
    editor.run_steps(3);
    button(&mut editor, "128 cells");
    match editor.state().app().shown() {
        Some(Value::Heightfield(terrain)) => assert_eq!((terrain.rows(), terrain.cols()), (128, 128)),
        other => panic!("the pane shows {other:?}"),
    }
    assert!(!editor.state().app().is_dirty());
}
