//! Paths typed in the window, on a system that has no dialogs.

use std::{fs, sync::Arc};

use crate::common::{
    Editor, Place,
    hand::{button, write},
    open, press,
};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_editor::{NoDialogs, Start};

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;

fn without_dialogs(place: &Place) -> Editor {
    open(Start { dialogs: Arc::new(|_, _| Err(NoDialogs)), ..place.start() })
}

/// Enters a command and waits for the question, which comes from another thread.
fn ask(editor: &mut Editor, held: Modifiers, key: Key, question: &str) {
    press(editor, held, key);
    crate::common::until_shown(editor, question);
    editor.run_steps(3);
}

#[test]
fn a_graph_is_saved_and_opened_by_typing_where() {
    let place = Place::new();
    let mut editor = without_dialogs(&place);
    let other = place.folder.path().join("other");
    ask(&mut editor, CTRL | Modifiers::SHIFT, Key::S, "Save it as");
    write(
        &mut editor,
        Role::TextInput,
        "path",
        &place.folder.path().join("none/x.ron").display().to_string(),
    );
    assert!(editor.query_by_label("There is no such folder").is_some(), "it stays and says why");
    write(&mut editor, Role::TextInput, "path", &other.display().to_string());
    crate::common::until(&mut editor, |app| !app.told().is_empty());
    let saved = other.with_extension("ron");
    assert!(fs::read_to_string(&saved).unwrap().contains("filter.gaussian_blur"));

    let third = place.folder.path().join("third.ron");
    fs::write(&third, "(format: 1, nodes: {\"alone\": (node: \"generate.fbm\", version: 1)})").unwrap();
    ask(&mut editor, CTRL, Key::O, "Which graph?");
    press(&mut editor, NONE, Key::Escape);
    assert!(editor.query_by_label("Which graph?").is_none(), "Escape asks no more");
    ask(&mut editor, CTRL, Key::O, "Which graph?");
    write(&mut editor, Role::TextInput, "path", &third.display().to_string());
    crate::common::until(&mut editor, |app| app.document().nodes.contains_key("alone"));
}

#[test]
fn what_would_be_replaced_is_told() {
    let place = Place::new();
    let mut editor = without_dialogs(&place);
    ask(&mut editor, CTRL | Modifiers::SHIFT, Key::S, "Save it as");
    let bare = place.graph.with_extension("");
    write_only(&mut editor, &bare.display().to_string());
    assert!(
        editor.query_by_role_and_label(Role::Button, "Replace").is_some(),
        "with its extension it is there"
    );
    button(&mut editor, "Cancel");
    assert!(editor.query_by_label("Save it as").is_none());
}

/// Writes over the path and does not press Enter.
fn write_only(editor: &mut Editor, text: &str) {
    editor.get_by_role_and_label(Role::TextInput, "path").click();
    editor.run_steps(3);
    editor.key_press_modifiers(crate::common::hand::HELD_CTRL, Key::A);
    editor.run_steps(2);
    editor.event(eframe::egui::Event::Text(text.into()));
    editor.run_steps(3);
}
