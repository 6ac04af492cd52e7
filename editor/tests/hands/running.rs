//! What the editor computes is what the command line computes, and what is not saved is not lost.

use std::{fs, sync::Arc};

use crate::common::{Place, open, press, read, select, settle};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_core::Context;
use orograph_engine::{
    Cache, CancelToken, CompileOptions, Document, Evaluator, compile, document::read_file, eval::Silent,
};
use orograph_session::Targets;

const CTRL: Modifiers = Modifiers::COMMAND;

#[test]
fn a_build_writes_the_very_bytes_of_a_run() {
    let place = Place::new();
    let mut editor = open(place.start());
    press(&mut editor, CTRL, Key::B);
    settle(&mut editor);
    let told = editor.state().app().told();
    assert!(told.iter().any(|text| text.contains("shade.png")), "{told:?}");

    let registry = orograph_session::built_in().unwrap();
    let document = Document::load(&place.graph).unwrap();
    let base_dir = place.folder.path().to_owned();
    let options = CompileOptions { base_dir, overrides: Vec::new(), loader: &|path| read_file(path) };
    let compiled = compile(&document, &registry, &options).unwrap();
    let apart = place.folder.path().join("apart");
    let request = Targets::choose(compiled, &[], &registry).unwrap().into_request(
        Context::default(),
        apart.clone(),
        None,
    );
    let evaluator = Evaluator::new(Cache::new(1 << 28, None), 1).unwrap();
    let report = evaluator.run(request, Arc::new(Silent), &CancelToken::new());
    assert_eq!(report.failures().count(), 0);
    assert_eq!(read(&place.out().join("shade.png")), read(&apart.join("shade.png")));
}

#[test]
fn a_build_that_fails_says_at_which_node_and_why() {
    let place = Place::new();
    let text = crate::common::CHAIN.replace("\"shade.png\"", "\"../shade.png\"");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open(place.start());
    press(&mut editor, CTRL, Key::B);
    let told = editor.state().app().told();
    assert!(told.iter().any(|text| text.contains("Not built") && text.contains("picture")), "{told:?}");
}

#[test]
fn saving_keeps_the_words_above_the_graph_and_asks_before_it_overwrites() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, Modifiers::NONE, Key::B);
    assert!(editor.state().app().is_dirty());
    press(&mut editor, CTRL, Key::S);
    assert!(!editor.state().app().is_dirty());
    let saved = String::from_utf8(read(&place.graph)).unwrap();
    assert!(saved.starts_with("// Kept when it is saved.\n"), "{saved}");
    assert!(Document::parse(&saved, "saved").unwrap().nodes["soft"].bypass);

    fs::write(&place.graph, crate::common::CHAIN).unwrap();
    press(&mut editor, Modifiers::NONE, Key::B);
    press(&mut editor, CTRL, Key::S);
    assert!(editor.query_by_label("Someone else changed the file").is_some());
    editor.get_by_role_and_label(Role::Button, "Take theirs").click();
    settle(&mut editor);
    assert_eq!(**editor.state().app().document(), Document::parse(crate::common::CHAIN, "chain").unwrap());
}

#[test]
fn what_someone_else_wrote_is_written_over_when_the_user_says_so() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, Modifiers::NONE, Key::B);
    fs::write(&place.graph, "(format: 1, nodes: {})").unwrap();
    press(&mut editor, CTRL, Key::S);
    assert_eq!(read(&place.graph), b"(format: 1, nodes: {})", "not before it is said");
    editor.get_by_role_and_label(Role::Button, "Overwrite with mine").click();
    settle(&mut editor);
    assert!(!editor.state().app().is_dirty());
    assert!(Document::load(&place.graph).unwrap().nodes["soft"].bypass);
}

#[test]
fn what_a_killed_editor_left_is_offered_and_recovered() {
    let place = Place::new();
    let folder = place.folder.path().join("unsaved");
    let registry = Arc::new(orograph_session::built_in().unwrap());
    {
        // What a killed program leaves: a journal that nobody holds.
        let journal = orograph_edit::Journal::begin(&folder, registry).unwrap();
        let mut document = Document::parse(crate::common::CHAIN, "chain").unwrap();
        document.doc = "unsaved".into();
        journal.keep(Some(&place.graph), Arc::new(document));
        journal.flush().unwrap();
    }
    let mut start = place.start();
    start.recoveries = Some(folder.clone());
    let mut editor = open(start);
    assert!(editor.query_by_label("Unsaved work was found").is_some());
    editor.get_by_role_and_label(Role::Button, "Recover").click();
    settle(&mut editor);
    assert_eq!(editor.state().app().document().doc, "unsaved");
    assert!(editor.state().app().is_dirty());
    press(&mut editor, CTRL, Key::S);
    assert_eq!(Document::load(&place.graph).unwrap().doc, "unsaved");
}

#[test]
fn closing_with_unsaved_work_asks_first() {
    let place = Place::new();
    let mut editor = open(place.start());
    select(&mut editor, "soft");
    press(&mut editor, Modifiers::NONE, Key::B);
    press(&mut editor, CTRL, Key::N);
    assert!(editor.query_by_label("There are unsaved changes").is_some());
    editor.get_by_role_and_label(Role::Button, "Keep editing").click();
    settle(&mut editor);
    assert_eq!(editor.state().app().document().nodes.len(), 5);
    press(&mut editor, CTRL, Key::N);
    editor.get_by_role_and_label(Role::Button, "Discard").click();
    settle(&mut editor);
    assert!(editor.state().app().document().nodes.is_empty());
}

/// An editor whose time goes by so slowly that it never looks whether someone else changed the file: of two who read
/// what is filled in once, one would find nothing.
#[cfg(unix)]
fn open_unwatched(start: orograph_editor::Start) -> crate::common::Editor {
    crate::common::open_at(start, 10_000.0)
}

/// Puts something in place of a file that is read no sooner than someone fills it.
#[cfg(unix)]
fn make_slow(path: &std::path::Path) {
    fs::remove_file(path).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
#[cfg(unix)]
fn a_slow_disk_freezes_nothing_and_what_is_edited_meanwhile_is_not_taken_for_saved() {
    let place = Place::new();
    let mut editor = open_unwatched(place.start());
    select(&mut editor, "soft");
    press(&mut editor, Modifiers::NONE, Key::B);
    make_slow(&place.graph);
    editor.key_press_modifiers(CTRL, Key::S);
    editor.run_steps(3);
    assert!(editor.query_by_label("saving…").is_some());
    assert!(editor.state().app().is_dirty(), "nothing is saved before it is");
    editor.key_press_modifiers(Modifiers::NONE, Key::B);
    editor.run_steps(3);
    assert!(!editor.state().app().document().nodes["soft"].bypass, "the window goes on");
    editor.key_press_modifiers(CTRL, Key::N);
    editor.run_steps(3);
    assert_eq!(editor.state().app().document().nodes.len(), 5, "nothing goes before it is saved");
    fs::write(&place.graph, crate::common::CHAIN).unwrap();
    settle(&mut editor);
    assert!(Document::load(&place.graph).unwrap().nodes["soft"].bypass, "as it was when it was to be saved");
    assert!(editor.state().app().is_dirty());
    assert!(editor.query_by_label("There are unsaved changes").is_some());
    editor.get_by_role_and_label(Role::Button, "Save").click();
    settle(&mut editor);
    assert!(!Document::load(&place.graph).unwrap().nodes["soft"].bypass);
    assert!(editor.state().app().document().nodes.is_empty(), "then comes what was asked for");
}

#[test]
#[cfg(unix)]
fn the_window_closes_no_sooner_than_the_file_is_written() {
    use eframe::egui::{ViewportCommand, ViewportId};

    let place = Place::new();
    let mut editor = open_unwatched(place.start());
    let closes = |editor: &crate::common::Editor| {
        editor.output().viewport_output[&ViewportId::ROOT].commands.contains(&ViewportCommand::Close)
    };
    select(&mut editor, "soft");
    press(&mut editor, Modifiers::NONE, Key::B);
    make_slow(&place.graph);
    editor.key_press_modifiers(CTRL, Key::S);
    editor.key_press_modifiers(CTRL, Key::Q);
    for _ in 0..5 {
        editor.run_steps(1);
        assert!(!closes(&editor));
    }
    fs::write(&place.graph, crate::common::CHAIN).unwrap();
    settle(&mut editor);
    assert!(closes(&editor));
    assert!(Document::load(&place.graph).unwrap().nodes["soft"].bypass);
}

#[test]
#[cfg(unix)]
fn a_slow_disk_freezes_nothing_when_a_graph_is_opened_and_it_can_be_given_up() {
    let place = Place::new();
    let other = place.folder.path().join("other.ron");
    fs::write(&other, "").unwrap();
    make_slow(&other);
    let mut start = place.start();
    let answer = other.clone();
    start.dialogs = Arc::new(move |_, _| Ok(Some(answer.clone())));
    let mut editor = open(start);
    for is_given_up in [true, false] {
        editor.key_press_modifiers(CTRL, Key::O);
        crate::common::until_shown(&mut editor, "Reading ");
        editor.key_press_modifiers(CTRL, Key::A);
        editor.key_press_modifiers(Modifiers::NONE, Key::Delete);
        editor.run_steps(3);
        assert_eq!(editor.state().app().document().nodes.len(), 5, "no edit is lost to what comes");
        if is_given_up {
            editor.get_by_role_and_label(Role::Button, "Do not open it").click();
            settle(&mut editor);
            assert!(editor.query_by_label_contains("Reading ").is_none());
        }
        fs::write(&other, "(format: 1, doc: \"the other\", nodes: {})").unwrap();
    }
    crate::common::until(&mut editor, |app| app.document().doc == "the other");
}

#[test]
fn a_graph_without_a_name_asks_for_one_before_it_goes() {
    let place = Place::new();
    let named = place.folder.path().join("named");
    let mut start = place.start();
    let answer = named.clone();
    start.file = None;
    start.dialogs = Arc::new(move |_, _| Ok(Some(answer.clone())));
    let mut editor = open(start);
    crate::common::event(&mut editor, eframe::egui::Event::Paste(crate::common::CHAIN.into()));
    settle(&mut editor);
    press(&mut editor, CTRL, Key::N);
    editor.get_by_role_and_label(Role::Button, "Save").click();
    let file = named.with_extension("ron");
    crate::common::until(&mut editor, |app| app.document().nodes.is_empty());
    assert_eq!(Document::load(&file).unwrap().nodes.len(), 5);
}

#[test]
fn a_build_says_how_long_it_still_takes_and_can_be_stopped() {
    let place = Place::new();
    fs::write(&place.graph, crate::common::CHAIN.replace("cells: 48", "cells: 6000")).unwrap();
    let mut editor = open(place.start());
    editor.key_press_modifiers(CTRL, Key::B);
    crate::common::until_shown(&mut editor, " left");
    press(&mut editor, Modifiers::NONE, Key::Escape);
    assert!(editor.query_by_label_contains(" left").is_none(), "it is over");
    assert!(!place.out().join("shade.png").exists());
}
