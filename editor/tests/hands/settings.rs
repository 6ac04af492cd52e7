//! Settings are changed in their window, hold at once or from the next start on, and are kept in one file.

use std::{
    fs,
    path::PathBuf,
    sync::{Arc, Mutex},
};

use crate::common::{Editor, Place, open, press, read, settle, until};
use eframe::egui::{Key, Modifiers, ThemePreference, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_editor::Start;
use orograph_engine::{Cache, DiskTier, Evaluator};
use orograph_session::{Settings, settings::Theme};

const CTRL: Modifiers = Modifiers::COMMAND;

fn file(place: &Place) -> PathBuf {
    place.folder.path().join("user/settings.ron")
}

fn start(place: &Place) -> Start {
    Start { settings_file: Some(file(place)), ..place.start() }
}

fn kept(place: &Place) -> Settings {
    Settings::load_from(&file(place)).unwrap()
}

fn click(editor: &mut Editor, role: Role, label: &str) {
    editor.get_by_role_and_label(role, label).click();
    settle(editor);
}

/// Writes into a field and leaves it.
fn write(editor: &mut Editor, field: &str, text: &str) {
    editor.get_by_label(field).focus();
    editor.run_steps(2);
    editor.key_press_modifiers(CTRL, Key::A);
    editor.run_steps(1);
    editor.key_press_modifiers(Modifiers::NONE, Key::Delete);
    editor.get_by_label(field).type_text(text);
    editor.run_steps(2);
    press(editor, Modifiers::NONE, Key::Enter);
}

#[test]
fn colours_change_at_once_and_are_kept() {
    let place = Place::new();
    let mut editor = open(start(&place));
    press(&mut editor, CTRL, Key::Comma);
    for (label, theme, shown) in [
        ("dark", Theme::Dark, ThemePreference::Dark),
        ("light", Theme::Light, ThemePreference::Light),
        ("as the system", Theme::System, ThemePreference::System),
    ] {
        click(&mut editor, Role::RadioButton, label);
        assert_eq!(editor.ctx.options(|options| options.theme_preference), shown);
        assert_eq!(kept(&place).theme, theme);
    }
}

#[test]
fn colours_that_were_kept_are_there_at_the_start() {
    let place = Place::new();
    let settings = Settings { theme: Theme::Dark, ..Settings::default() };
    settings.save_to(&file(&place)).unwrap();
    let editor = open(Start { settings, ..start(&place) });
    assert_eq!(editor.ctx.options(|options| options.theme_preference), ThemePreference::Dark);
}

#[test]
fn memory_and_cache_are_kept_for_the_next_start_and_what_is_no_size_is_refused() {
    let place = Place::new();
    let folder = place.folder.path().join("results");
    let mut start = start(&place);
    let answer = folder.clone();
    start.dialogs = Arc::new(move |_, _| Ok(Some(answer.clone())));
    let mut editor = open(start);
    press(&mut editor, CTRL, Key::Comma);
    assert!(editor.query_by_label_contains("In use now: memory alone").is_some());
    assert!(editor.query_by_label_contains("In use now: 256.0 MiB").is_some());
    write(&mut editor, "memory budget", "much");
    assert!(editor.query_by_label_contains("`much` is no size; write 2GiB").is_some());
    assert_eq!(kept(&place).memory, None);
    write(&mut editor, "memory budget", "3 GiB");
    assert_eq!(kept(&place).memory, Some(3 << 30));
    assert_eq!(editor.get_by_label("memory budget").value().as_deref(), Some("3GiB"));
    click(&mut editor, Role::Button, "choose the cache folder");
    until(&mut editor, |app| app.settings().cache.is_some());
    assert_eq!(kept(&place).cache, Some(folder));
    click(&mut editor, Role::Button, "no cache folder");
    assert_eq!(kept(&place).cache_folder(None), None);
    click(&mut editor, Role::Button, "usual cache folder");
    assert_eq!(kept(&place).cache, None);
    write(&mut editor, "cache folder", "/elsewhere/results");
    assert_eq!(kept(&place).cache, Some("/elsewhere/results".into()));
    write(&mut editor, "memory budget", "");
    assert_eq!(kept(&place).memory, None);
}

#[test]
fn the_cache_on_disk_is_counted_and_cleared() {
    let place = Place::new();
    let disk = DiskTier::open(&place.folder.path().join("cache")).unwrap();
    let evaluator = Arc::new(Evaluator::new(Cache::new(1 << 28, Some(disk)), 2).unwrap());
    let mut editor = open(Start { evaluator: evaluator.clone(), ..start(&place) });
    evaluator.flush();
    let full = evaluator.cache().disk().unwrap().stat().unwrap();
    assert!(full.values > 0);
    press(&mut editor, CTRL, Key::Comma);
    let takes = format!("It takes {} on the disk.", orograph_session::memory::text(full.bytes()));
    assert!(editor.query_by_label(&takes).is_some());
    click(&mut editor, Role::Button, "Clear the cache");
    assert_eq!(evaluator.cache().disk().unwrap().stat().unwrap().values, 0);
    assert!(editor.query_by_label("It takes 0 B on the disk.").is_some());
    assert!(editor.state().app().told().last().unwrap().starts_with("The cache is empty"));
}

#[test]
fn what_another_program_wrote_is_shown_and_stays() {
    let place = Place::new();
    let mut editor = open(start(&place));
    fs::create_dir_all(file(&place).parent().unwrap()).unwrap();
    fs::write(file(&place), "(memory: \"5GiB\", isolate: [\"Coast\"])").unwrap();
    press(&mut editor, CTRL, Key::Comma);
    assert_eq!(editor.get_by_label("memory budget").value().as_deref(), Some("5GiB"));
    click(&mut editor, Role::RadioButton, "dark");
    assert_eq!((kept(&place).isolate, kept(&place).theme), (vec!["Coast".to_owned()], Theme::Dark));
}

#[test]
fn a_settings_file_that_cannot_be_read_is_left_alone_and_told_with_the_mend() {
    let place = Place::new();
    fs::create_dir_all(file(&place).parent().unwrap()).unwrap();
    fs::write(file(&place), "(theme: Blue)").unwrap();
    let mut editor = open(start(&place));
    press(&mut editor, CTRL, Key::Comma);
    click(&mut editor, Role::RadioButton, "dark");
    assert_eq!(read(&file(&place)), b"(theme: Blue)");
    assert_eq!(
        editor.ctx.options(|options| options.theme_preference),
        ThemePreference::Dark,
        "it holds here"
    );
    let told = editor.state().app().told();
    assert!(
        told.last().unwrap().contains("Blue") && told.last().unwrap().contains("write settings"),
        "{told:?}"
    );
}

#[test]
fn graphs_that_were_open_are_opened_again_and_one_that_is_gone_is_told() {
    let place = Place::new();
    let other = place.folder.path().join("other.ron");
    fs::write(&other, "(format: 1, doc: \"the other\", nodes: {})").unwrap();
    let chosen = Arc::new(Mutex::new(other.clone()));
    let mut start = start(&place);
    let answer = chosen.clone();
    start.dialogs = Arc::new(move |_, _| Ok(Some(answer.lock().unwrap().clone())));
    let mut editor = open(start);
    assert_eq!(kept(&place).recent, std::slice::from_ref(&place.graph));
    press(&mut editor, CTRL, Key::O);
    until(&mut editor, |app| app.document().doc == "the other");
    assert_eq!(kept(&place).recent, [other.clone(), place.graph.clone()]);

    let reopen = |editor: &mut Editor, graph: &PathBuf| {
        click(editor, Role::Button, "File");
        editor.get_by_label_contains("Recent").click();
        editor.run_steps(5);
        click(editor, Role::Button, &format!("open {}", graph.display()));
    };
    reopen(&mut editor, &place.graph);
    assert_eq!(editor.state().app().document().nodes.len(), 5);
    assert_eq!(kept(&place).recent, [place.graph.clone(), other.clone()], "each stands once");

    let third = place.folder.path().join("third.ron");
    chosen.lock().unwrap().clone_from(&third);
    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::S);
    until(&mut editor, |app| app.settings().recent.len() == 3);
    assert_eq!(kept(&place).recent, [third, place.graph.clone(), other.clone()]);

    fs::remove_file(&other).unwrap();
    reopen(&mut editor, &other);
    assert!(editor.state().app().told().last().unwrap().contains("other.ron is no longer there"));
    assert_eq!(editor.state().app().document().nodes.len(), 5, "what is open stays");
    assert!(!kept(&place).recent.contains(&other));
}
