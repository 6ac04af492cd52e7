//! An editor without a window. A helper that fails is a test that fails.
#![allow(clippy::unwrap_used, dead_code)]

pub(crate) mod hand;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use eframe::egui::{self, Event, Key, Modifiers, Pos2, Vec2, accesskit::Role, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use orograph_editor::{App, Start};
use orograph_engine::{Cache, Evaluator};

/// The editor, made when the first frame gives it a context.
pub(crate) struct Window {
    start: Option<Start>,
    app: Option<App>,
}

impl Window {
    pub(crate) fn app(&self) -> &App {
        self.app.as_ref().unwrap()
    }

    pub(crate) fn app_mut(&mut self) -> &mut App {
        self.app.as_mut().unwrap()
    }
}

pub(crate) type Editor = Harness<'static, Window>;

pub(crate) const CHAIN: &str = r#"// Kept when it is saved.
(
    format: 1,
    nodes: {
        "hills": (node: "generate.fbm", version: 1, params: (cells: 48)),
        "soft": (node: "filter.gaussian_blur", version: 1, inputs: {"terrain": "hills.terrain"}),
        "high": (node: "mask.from_height", version: 1, inputs: {"terrain": "hills.terrain"}),
        "shade": (node: "look.hillshade", version: 1, inputs: {"terrain": "soft.terrain"}),
        "picture": (node: "io.write_texture", version: 1, params: (file: "shade.png"), inputs: {"texture": "shade.picture"}),
    },
    layout: (nodes: {"hills": (0, 0), "soft": (280, 0), "high": (280, 260), "shade": (560, 0), "picture": (840, 0)}),
)
"#;

/// A folder with the graph above in it.
pub(crate) struct Place {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) graph: PathBuf,
}

impl Place {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let graph = folder.path().join("chain.ron");
        fs::write(&graph, CHAIN).unwrap();
        Self { folder, graph }
    }

    pub(crate) fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    pub(crate) fn start(&self) -> Start {
        let registry = Arc::new(orograph_session::built_in().unwrap());
        let evaluator = Arc::new(Evaluator::new(Cache::new(1 << 28, None), 2).unwrap());
        Start { file: Some(self.graph.clone()), out: self.out(), ..Start::with(registry, evaluator) }
    }
}

pub(crate) fn open(start: Start) -> Editor {
    open_with(start, 4.0, vec2(1500.0, 1000.0))
}

/// An editor that draws so many frames a second of its time.
pub(crate) fn open_at(start: Start, frames: f32) -> Editor {
    open_with(start, frames, vec2(1500.0, 1000.0))
}

/// An editor in a window of another size.
pub(crate) fn open_sized(start: Start, size: Vec2) -> Editor {
    open_with(start, 4.0, size)
}

fn open_with(start: Start, frames: f32, size: Vec2) -> Editor {
    let harness = Harness::builder().with_size(size).with_step_dt(1.0 / frames);
    let mut editor = harness.with_max_steps(200).build_ui_state(
        |ui, window: &mut Window| {
            if let Some(start) = window.start.take() {
                window.app = Some(App::new(ui.ctx(), start));
            }
            if let Some(app) = &mut window.app {
                app.ui(ui);
            }
        },
        Window { start: Some(start), app: None },
    );
    settle(&mut editor);
    editor
}

/// Frames until nothing is computed any more.
pub(crate) fn settle(editor: &mut Editor) {
    let begun = Instant::now();
    let mut quiet = 0;
    while quiet < 4 {
        editor.run_steps(1);
        quiet = if editor.state().app().is_idle() { quiet + 1 } else { 0 };
        assert!(begun.elapsed() < Duration::from_secs(120), "the editor does not come to rest");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Frames until something is so, which may take more than what is computed: a dialog, a thread.
pub(crate) fn until(editor: &mut Editor, is_so: impl Fn(&App) -> bool) {
    let begun = Instant::now();
    while !is_so(editor.state().app()) {
        editor.run_steps(1);
        assert!(begun.elapsed() < Duration::from_secs(120), "it does not come to be so");
        std::thread::sleep(Duration::from_millis(2));
    }
    settle(editor);
}

/// Frames until words stand somewhere in the window.
pub(crate) fn until_shown(editor: &mut Editor, words: &str) {
    let begun = Instant::now();
    while editor.query_all_by_label_contains(words).count() == 0 {
        editor.run_steps(1);
        assert!(begun.elapsed() < Duration::from_secs(120), "nothing says `{words}`");
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub(crate) fn press(editor: &mut Editor, modifiers: Modifiers, key: Key) {
    editor.key_press_modifiers(modifiers, key);
    settle(editor);
}

/// Where a widget of the canvas stands in the window: the tree tells places in the graph.
pub(crate) fn at(editor: &Editor, label: &str) -> Pos2 {
    let rect = editor.get_by_role_and_label(Role::Button, label).rect();
    editor.state().app().to_window() * rect.center()
}

pub(crate) fn drag(editor: &mut Editor, from: Pos2, to: Pos2) {
    editor.hover_at(from);
    editor.run_steps(2);
    editor.drag_at(from);
    editor.run_steps(2);
    for share in 1..=8u8 {
        editor.hover_at(from.lerp(to, f32::from(share) / 8.0));
        editor.run_steps(1);
    }
    editor.run_steps(2);
    editor.drop_at(to);
    settle(editor);
}

/// Draws a wire from an output to an input, from just outside the one to just outside the other.
pub(crate) fn wire(editor: &mut Editor, output: &str, input: &str) {
    let from = at(editor, &format!("output {output}")) + vec2(3.0, 0.0);
    let to = at(editor, &format!("input {input}")) - vec2(3.0, 0.0);
    drag(editor, from, to);
}

pub(crate) fn click(editor: &mut Editor, pos: Pos2) {
    editor.hover_at(pos);
    editor.run_steps(1);
    editor.drag_at(pos);
    editor.run_steps(1);
    editor.drop_at(pos);
    settle(editor);
}

/// A place on a node's title, right of its inputs.
pub(crate) fn title(editor: &Editor, name: &str) -> Pos2 {
    let app = editor.state().app();
    let (x, y) = app.document().layout.nodes[name];
    app.to_window() * (egui::pos2(x as f32, y as f32) + Vec2::new(70.0, 22.0))
}

pub(crate) fn select(editor: &mut Editor, name: &str) {
    let pos = title(editor, name);
    click(editor, pos);
    assert_eq!(editor.state().app().selection(), [name.to_owned()], "a click selects `{name}`");
}

pub(crate) fn copied(editor: &Editor) -> Option<String> {
    editor.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

pub(crate) fn event(editor: &mut Editor, event: Event) {
    editor.event(event);
    editor.run_steps(1);
}

pub(crate) fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap()
}
