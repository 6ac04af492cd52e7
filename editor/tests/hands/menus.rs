//! Everything that can be done has a menu entry, is told on the keys page, and every widget has a name.

use crate::common::{
    Editor, Place,
    hand::{button, menu},
    open, press, select,
};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::{NodeT, Queryable};

const NONE: Modifiers = Modifiers::NONE;
const MENUS: [&str; 6] = ["File", "Edit", "Node", "View", "Run", "Help"];

fn buttons(editor: &Editor) -> Vec<String> {
    let buttons = editor.query_all_by_role(Role::Button);
    buttons.filter_map(|node| node.accesskit_node().label()).collect()
}

#[test]
fn every_line_of_the_keys_page_is_an_entry_of_a_menu_and_the_other_way_round() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    let beside = buttons(&editor);
    let mut entries = Vec::new();
    for title in MENUS {
        editor.get_by_role_and_label(Role::Button, title).click();
        editor.run_steps(3);
        entries.extend(buttons(&editor).into_iter().filter(|label| !beside.contains(label)));
        press(&mut editor, NONE, Key::Escape);
    }
    // The menu of recent graphs is no command.
    entries.retain(|entry| !entry.starts_with("Recent"));
    // Build is a button beside the menus as well.
    entries.push("Build".into());
    assert!(entries.len() > 30, "{entries:?}");
    press(&mut editor, NONE, Key::F1);
    for entry in &entries {
        let told = |line: String| {
            entry.strip_prefix(&line).is_some_and(|key| key.is_empty() || key.starts_with(' '))
        };
        let mut lines = editor.query_all_by_role(Role::Label).filter_map(|node| node.value());
        assert!(lines.any(told), "the keys page tells of {entry}");
    }
    for key in ["Ctrl+Z", "Tab", "Ctrl+X", "Ctrl+C", "Ctrl+V"] {
        assert!(editor.query_by_label(key).is_some(), "{key}");
    }
}

#[test]
fn menus_do_what_they_say() {
    let place = Place::new();
    let mut editor = open(place.start());
    menu(&mut editor, "Edit", "Select all");
    assert_eq!(editor.state().app().selection().len(), 5);
    menu(&mut editor, "Edit", "Select none");
    assert!(editor.state().app().selection().is_empty());
    select(&mut editor, "soft");
    menu(&mut editor, "Node", "Bypass");
    assert!(editor.state().app().document().nodes["soft"].bypass);
    menu(&mut editor, "View", "Next node");
    assert_eq!(editor.state().app().selection(), ["shade"]);
    menu(&mut editor, "View", "Previous node");
    assert_eq!(editor.state().app().selection(), ["soft"]);
    menu(&mut editor, "Edit", "Delete and join wires");
    menu(&mut editor, "Edit", "Undo");
    menu(&mut editor, "Edit", "Undo");
    assert!(!editor.state().app().is_dirty());
    menu(&mut editor, "File", "Settings…");
    assert!(editor.query_by_label("Colours").is_some());
    menu(&mut editor, "Node", "Add node…");
    assert!(editor.query_by_label("search nodes").is_some());
}

#[test]
fn while_a_question_is_open_keys_do_nothing_behind_it() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, NONE, Key::B);
    press(&mut editor, Modifiers::COMMAND, Key::N);
    let before = editor.state().app().document().clone();
    press(&mut editor, NONE, Key::B);
    press(&mut editor, NONE, Key::Delete);
    press(&mut editor, NONE, Key::Tab);
    assert!(editor.query_by_label("search nodes").is_none());
    assert_eq!(*editor.state().app().document(), before);
    button(&mut editor, "Keep editing");
    press(&mut editor, Modifiers::COMMAND, Key::Z);
    assert!(!editor.state().app().is_dirty());
}

#[test]
fn entries_with_nothing_to_do_are_grey() {
    let place = Place::new();
    let mut editor = open(place.start());
    press(&mut editor, Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::A);
    editor.get_by_role_and_label(Role::Button, "Node").click();
    editor.run_steps(3);
    for entry in ["Bypass", "Frame", "Align left edges"] {
        let node = editor
            .query_all_by_role(Role::Button)
            .find(|node| node.accesskit_node().label().is_some_and(|label| label.starts_with(entry)))
            .unwrap();
        assert!(node.accesskit_node().is_disabled(), "{entry}");
    }
}

#[test]
fn every_widget_that_can_be_used_has_a_name() {
    let place = Place::new();
    let mut editor = open(place.start());
    let used = [
        Role::Button,
        Role::CheckBox,
        Role::ComboBox,
        Role::Slider,
        Role::SpinButton,
        Role::TextInput,
        Role::MultilineTextInput,
        Role::Image,
    ];
    let check = |editor: &Editor, when: &str| {
        for role in used {
            for node in editor.query_all_by_role(role) {
                let label = node.accesskit_node().label().unwrap_or_default();
                assert!(!label.trim().is_empty(), "{when}: a {role:?} without a name, {:?}", node.value());
            }
        }
    };
    select(&mut editor, "hills");
    check(&editor, "a node");
    button(&mut editor, "3D");
    check(&editor, "ground");
    button(&mut editor, "2D");
    select(&mut editor, "shade");
    check(&editor, "a look");
    press(&mut editor, NONE, Key::V);
    check(&editor, "two panes");
    press(&mut editor, Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::A);
    check(&editor, "the graph");
    press(&mut editor, NONE, Key::Tab);
    check(&editor, "the search");
    press(&mut editor, NONE, Key::Escape);
    press(&mut editor, NONE, Key::F1);
    check(&editor, "the keys");
    press(&mut editor, Modifiers::COMMAND, Key::Comma);
    check(&editor, "the settings");
}
