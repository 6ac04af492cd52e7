//! Plugins are found again while the editor runs, and nothing of the document is lost over it.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
};

use crate::common::{Editor, Place, open, press, read, select, settle, until};
use eframe::egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::kittest::Queryable;
use orograph_core::{Digest, Value};
use orograph_editor::Start;
use orograph_engine::{
    Registry,
    plugin::{Found, Plugins, Program, Registered},
};
use orograph_session::Settings;

const CTRL: Modifiers = Modifiers::COMMAND;

fn click(editor: &mut Editor, role: Role, label: &str) {
    editor.get_by_role_and_label(role, label).click();
    settle(editor);
}

/// Whether the words stand somewhere; those about a node stand on it and in the inspector.
fn says(editor: &Editor, words: &str) -> bool {
    editor.query_all_by_label_contains(words).count() > 0
}

/// Every node type but one.
fn without(id: &str) -> Registry {
    Registry::new(orograph_nodes::all().into_iter().filter(|node_type| node_type.spec().id != id)).unwrap()
}

#[test]
fn placeholders_become_nodes_when_their_plugin_comes_and_nodes_placeholders_when_it_goes() {
    let place = Place::new();
    let is_there = Arc::new(AtomicBool::new(false));
    let look = is_there.clone();
    let registry = move || match look.load(Ordering::SeqCst) {
        true => without(""),
        false => without("filter.gaussian_blur"),
    };
    let mut editor = open(Start {
        registry: Arc::new(registry()),
        plugins: Arc::new(move |_| Ok((registry(), Vec::new()))),
        ..place.start()
    });
    select(&mut editor, "high");
    press(&mut editor, Modifiers::NONE, Key::B);
    let edited = editor.state().app().document().clone();
    select(&mut editor, "soft");
    assert!(says(&editor, "there is no node type `filter.gaussian_blur` here"));
    assert!(editor.state().app().shown().is_none());

    press(&mut editor, CTRL, Key::Comma);
    is_there.store(true, Ordering::SeqCst);
    click(&mut editor, Role::Button, "reload plugins");
    assert!(editor.state().app().told().last().unwrap().ends_with("one node type came"));
    assert!(!says(&editor, "there is no node type"));
    assert!(matches!(editor.state().app().shown(), Some(Value::Heightfield(_))), "it runs");
    assert_eq!(editor.state().app().selection(), ["soft"]);
    assert!(Arc::ptr_eq(editor.state().app().document(), &edited), "the document is the very same");

    is_there.store(false, Ordering::SeqCst);
    click(&mut editor, Role::Button, "reload plugins");
    assert!(editor.state().app().told().last().unwrap().ends_with("one node type went"));
    assert!(says(&editor, "there is no node type `filter.gaussian_blur` here"));
    assert!(editor.state().app().shown().is_none(), "nothing is shown of what it gave");
    press(&mut editor, CTRL, Key::Z);
    assert!(!editor.state().app().is_dirty(), "what was done before is still taken back");
    press(&mut editor, CTRL.plus(Modifiers::SHIFT), Key::Z);
    press(&mut editor, CTRL, Key::S);
    let saved = String::from_utf8(read(&place.graph)).unwrap();
    let line = crate::common::CHAIN.lines().find(|line| line.contains("\"soft\": (node")).unwrap();
    assert!(saved.contains(line.trim()), "a placeholder is saved back unchanged:\n{saved}");
}

#[test]
fn every_library_stands_in_the_list_with_its_switch_or_why_it_was_refused() {
    let place = Place::new();
    let file = place.folder.path().join("settings.ron");
    let folder = place.folder.path().join("libraries");
    let asked: Arc<Mutex<Vec<Settings>>> = Arc::default();
    let (asked_of, answer) = (asked.clone(), folder.clone());
    let find = |settings: &Settings| {
        let coast = Registered {
            name: "Coast".into(),
            version: "1.2".into(),
            digest: Digest::of(b"coast"),
            nodes: vec!["coast.cliffs".into(), "coast.dunes".into()],
            apart: settings.isolate.contains(&"Coast".to_owned()),
        };
        vec![
            Found { path: "/opt/libcoast.so".into(), outcome: Ok(coast) },
            Found { path: "/opt/libbroken.so".into(), outcome: Err("it has no nodes".into()) },
        ]
    };
    let mut editor = open(Start {
        found: find(&Settings::default()),
        plugins: Arc::new(move |settings| {
            asked_of.lock().unwrap().push(settings.clone());
            Ok((without(""), find(settings)))
        }),
        dialogs: Arc::new(move |_, _| Ok(Some(answer.clone()))),
        settings_file: Some(file.clone()),
        ..place.start()
    });
    press(&mut editor, CTRL, Key::Comma);
    for words in ["Coast 1.2", "/opt/libcoast.so", "coast.cliffs, coast.dunes", "/opt/libbroken.so"] {
        assert!(editor.query_by_label(words).is_some(), "{words}");
    }
    assert!(editor.query_by_label("Refused: it has no nodes").is_some());
    click(&mut editor, Role::CheckBox, "Coast in a process of its own");
    assert_eq!(Settings::load_from(&file).unwrap().isolate, ["Coast"]);
    assert_eq!(asked.lock().unwrap().last().unwrap().isolate, ["Coast"], "it is put to use at once");
    click(&mut editor, Role::CheckBox, "Coast in a process of its own");
    assert!(Settings::load_from(&file).unwrap().isolate.is_empty());
    click(&mut editor, Role::Button, "Add folder…");
    until(&mut editor, |app| !app.settings().plugins.is_empty());
    assert_eq!(Settings::load_from(&file).unwrap().plugins, std::slice::from_ref(&folder));
    assert_eq!(asked.lock().unwrap().last().unwrap().plugins, std::slice::from_ref(&folder));
    click(&mut editor, Role::Button, &format!("remove the folder {}", folder.display()));
    assert!(Settings::load_from(&file).unwrap().plugins.is_empty());
    assert!(asked.lock().unwrap().last().unwrap().plugins.is_empty());
}

/// Builds a plugin in C whose node gives a number.
#[cfg(unix)]
fn build(folder: &Path) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    fs::create_dir_all(folder).unwrap();
    let library = folder.join("sound").with_extension(std::env::consts::DLL_EXTENSION);
    let mut compiler = std::process::Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.args(["-std=gnu11", "-shared", "-fPIC", "-O1", "-pthread", "-DCASE=0", "-DANSWER=42", "-o"]);
    compiler.arg(&library).arg("-I").arg(root.join("plugins")).arg(root.join("tests/plugins/unsound.c"));
    let built = compiler.output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    library
}

#[test]
#[cfg(unix)]
fn a_library_that_is_built_while_the_editor_runs_is_run_after_a_reload() {
    let place = Place::new();
    fs::write(
        &place.graph,
        "(format: 1, nodes: {\"n\": (node: \"sound.node\", version: 1)}, layout: (nodes: {\"n\": (0, 0)}))",
    )
    .unwrap();
    let (libraries, cache) = (place.folder.path().join("libraries"), place.folder.path().join("cache"));
    fs::create_dir_all(&libraries).unwrap();
    let folder = libraries.clone();
    let mut editor = open(Start {
        plugins: Arc::new(move |settings: &Settings| {
            // The editor's own program is what looks at plugins and runs them apart.
            let executable = env!("CARGO_BIN_EXE_orograph-editor").into();
            let program = Program { executable, arguments: vec!["plugin-host".into()] };
            let plugins = Plugins::new(Some(&cache), program).unwrap();
            let mut registry = without("");
            let apart = |name: &str| settings.isolate.iter().any(|isolated| isolated == name);
            let found = plugins.register(&Plugins::in_folder(&folder).unwrap(), &mut registry, &apart);
            Ok((registry, found))
        }),
        ..place.start()
    });
    select(&mut editor, "n");
    assert!(editor.state().app().shown().is_none());
    press(&mut editor, CTRL, Key::Comma);
    assert!(editor.query_by_label("No plugins were found.").is_some());
    let library = build(&libraries);
    click(&mut editor, Role::Button, "reload plugins");
    assert!(editor.query_by_label("Sound 1.0").is_some());
    let answer = |editor: &Editor| match editor.state().app().shown() {
        Some(Value::Number(number)) => Some(*number),
        None => None,
        other => panic!("the pane shows {other:?}"),
    };
    assert_eq!(answer(&editor), Some(42.0));
    click(&mut editor, Role::CheckBox, "Sound in a process of its own");
    assert_eq!(answer(&editor), Some(42.0), "apart as well");
    // A node says by which plugin it came, for those who have it not.
    click(&mut editor, Role::Button, "Close window");
    press(&mut editor, Modifiers::NONE, Key::Tab);
    editor.get_by_label("search nodes").type_text("sound");
    editor.run_steps(3);
    press(&mut editor, Modifiers::NONE, Key::Enter);
    let document = editor.state().app().document().clone();
    assert_eq!(document.nodes[&editor.state().app().selection()[0]].plugin, "Sound");
    press(&mut editor, CTRL, Key::Z);
    select(&mut editor, "n");
    press(&mut editor, CTRL, Key::Comma);
    fs::remove_file(library).unwrap();
    click(&mut editor, Role::Button, "reload plugins");
    assert_eq!(answer(&editor), None);
    assert!(says(&editor, "there is no node type `sound.node` here"));
}
