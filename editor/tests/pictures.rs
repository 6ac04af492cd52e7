//! What the main views look like, compared with pictures in `tests/snapshots`.
//!
//! They are drawn by a software driver for Vulkan (`mesa-vulkan-drivers` and `libvulkan1` in Debian), which draws the
//! same everywhere. Without one the run says in its closing lines what it left out, unless
//! `OROGRAPH_PIXELS_REQUIRED=1` forbids that. `UPDATE_SNAPSHOTS=1` draws the pictures anew: look at each before it is
//! committed.

#![allow(clippy::unwrap_used)]
#![expect(clippy::print_stdout, reason = "a test runner reports on standard output")]

#[path = "hands/common/mod.rs"]
mod common;

use std::{env, fs, panic, process::ExitCode};

use common::{
    Editor, Place, at, drag,
    hand::{button, drag_with, in_picture},
    open_sized, press, select, settle, wire,
};
use eframe::{
    egui::{Key, Modifiers, PointerButton, Rect, accesskit::Role, vec2},
    egui_wgpu::RendererOptions,
    wgpu::DeviceType,
};
use egui_kittest::{
    SnapshotOptions,
    kittest::Queryable,
    wgpu::{create_render_state, default_wgpu_setup},
};

/// Small, so that the pictures are: the canvas is about 650 points wide.
const SIZE: eframe::egui::Vec2 = vec2(1000.0, 650.0);

type Scene = fn() -> (Place, Editor);

const SCENES: [(&str, Scene); 8] = [
    ("graph", graph),
    ("ground", ground),
    ("search", search),
    ("refusal", refusal),
    ("sketch", sketch),
    ("keys", keys),
    ("afar", afar),
    ("colours", colours),
];

fn main() -> ExitCode {
    let only: Vec<String> = env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wanted = |name: &str| only.is_empty() || only.iter().any(|part| name.contains(part.as_str()));
    let names: Vec<&str> = SCENES.iter().map(|(name, _)| *name).filter(|name| wanted(name)).collect();
    if let Err(why) = software_driver() {
        println!("left out: {} pictures of the editor ({}): {why}", names.len(), names.join(", "));
        println!("in Debian, apt-get install mesa-vulkan-drivers libvulkan1 brings the driver");
        let required = env::var_os("OROGRAPH_PIXELS_REQUIRED").is_some_and(|value| value == "1");
        return if required { ExitCode::FAILURE } else { ExitCode::SUCCESS };
    }
    let mut failed = 0;
    for (name, scene) in SCENES.iter().filter(|(name, _)| wanted(name)) {
        match panic::catch_unwind(|| compare(name, *scene)) {
            Ok(Ok(())) => println!("ok {name}"),
            Ok(Err(why)) => {
                failed += 1;
                println!("FAILED {name}: {why}");
            }
            Err(_) => {
                failed += 1;
                println!("FAILED {name}");
            }
        }
    }
    println!("{} passed, {failed} failed", names.len() - failed);
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Whether there is a driver that draws on the processor; others draw edges in ways of their own.
fn software_driver() -> Result<(), String> {
    let told = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let state = panic::catch_unwind(|| {
        create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE).adapter.get_info()
    });
    panic::set_hook(told);
    match state {
        Ok(info) if info.device_type == DeviceType::Cpu => Ok(()),
        Ok(info) => Err(format!("{} is no software driver for Vulkan", info.name)),
        Err(_) => Err("there is no driver for Vulkan".into()),
    }
}

fn compare(name: &str, scene: Scene) -> Result<(), String> {
    let (_place, mut editor) = scene();
    editor.remove_cursor();
    settle(&mut editor);
    // Windows fade in.
    editor.run_steps(8);
    cover_times(&mut editor);
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/snapshots");
    let options = SnapshotOptions::new().output_path(folder).threshold(0.6).max_failed_pixels(0);
    editor.try_snapshot_options(name, &options).map_err(|error| error.to_string())
}

/// How long a node took is another time in every run.
fn cover_times(editor: &mut Editor) {
    let to_window = editor.state().app().to_window();
    let times = editor.query_all_by_role(Role::Label).filter(|node| {
        let text = node.value().unwrap_or_default();
        ["computed", "memory", "disk", "cutoff"].iter().any(|how| text.starts_with(how))
            && text.ends_with('B')
    });
    let rects: Vec<Rect> = times
        .map(|node| {
            let min = node.rect().min;
            to_window * Rect::from_min_size(min, vec2(160.0, node.rect().height()))
        })
        .collect();
    // Not over what stands above the graph; through what dims it all is seen.
    let dimmed = editor.query_by_role_and_label(Role::Button, "Leave it").is_some();
    let free = |rect: &Rect| {
        let layer = editor.ctx.layer_id_at(rect.center());
        dimmed || layer.is_none_or(|layer| layer.order == eframe::egui::Order::Background)
    };
    let rects: Vec<Rect> = rects.into_iter().filter(free).collect();
    rects.into_iter().for_each(|rect| editor.mask(rect));
}

fn chain() -> (Place, Editor) {
    let place = Place::new();
    // Smooth ground, so that the files are small.
    fs::write(&place.graph, common::CHAIN.replace("cells: 48", "cells: 48, octaves: 2")).unwrap();
    let mut editor = open_sized(place.start(), SIZE);
    let ctx = editor.ctx.clone();
    ctx.global_style_mut(|style| style.visuals.text_cursor.blink = false);
    show_all(&mut editor);
    (place, editor)
}

/// All nodes in view by the sizes that they have in the end, whichever picture came first.
fn show_all(editor: &mut Editor) {
    for _ in 0..3 {
        press(editor, Modifiers::NONE, Key::Home);
    }
}

/// Nodes with pictures and badges, the inspector, a picture with its scale.
fn graph() -> (Place, Editor) {
    let (place, mut editor) = chain();
    select(&mut editor, "hills");
    button(&mut editor, "expose octaves");
    (place, editor)
}

fn ground() -> (Place, Editor) {
    let (place, mut editor) = chain();
    select(&mut editor, "soft");
    button(&mut editor, "3D");
    (place, editor)
}

fn search() -> (Place, Editor) {
    let (place, mut editor) = chain();
    let from = at(&editor, "output high.mask") + vec2(3.0, 0.0);
    drag(&mut editor, from, from + vec2(60.0, -20.0));
    editor.get_by_label("search nodes").type_text("ma");
    editor.run_steps(3);
    (place, editor)
}

fn refusal() -> (Place, Editor) {
    let (place, mut editor) = chain();
    wire(&mut editor, "high.mask", "shade.terrain");
    (place, editor)
}

/// Lines over a picture; a frame, a comment, a bypass, and a node with a fault.
fn sketch() -> (Place, Editor) {
    let place = Place::new();
    let text = r#"(format: 1, nodes: {
        "ridges": (node: "feature.from_curves", version: 1, comment: "The two ridges of the map."),
        "odd": (node: "acme.magic", version: 1),
        "calm": (node: "filter.gaussian_blur", version: 1, bypass: true),
    }, layout: (nodes: {"ridges": (0, 0), "odd": (280, 0), "calm": (280, 130)},
        frames: [(title: "Drawn", rect: (-24, -52, 240, 260))]))"#;
    fs::write(&place.graph, text).unwrap();
    let mut editor = open_sized(place.start(), SIZE);
    select(&mut editor, "ridges");
    show_all(&mut editor);
    button(&mut editor, "draw");
    for way in [[(0.2, 0.3), (0.5, 0.5), (0.8, 0.35)], [(0.25, 0.8), (0.5, 0.65), (0.7, 0.75)]] {
        let way = way.map(|(x, y)| in_picture(&editor, "view", x, y));
        drag_with(&mut editor, PointerButton::Primary, Modifiers::NONE, &way);
    }
    show_all(&mut editor);
    (place, editor)
}

fn keys() -> (Place, Editor) {
    let (place, mut editor) = chain();
    let ctx = editor.ctx.clone();
    ctx.set_theme(eframe::egui::Theme::Light);
    press(&mut editor, Modifiers::NONE, Key::F1);
    (place, editor)
}

/// Nodes too small to be read, painted instead of made of widgets: one is selected, one bypassed, one at fault.
fn afar() -> (Place, Editor) {
    let place = Place::new();
    let nodes = "\"odd\": (node: \"acme.magic\", version: 1),
        \"calm\": (node: \"filter.gaussian_blur\", version: 1, bypass: true, inputs: {\"terrain\": \"soft.terrain\"}),";
    let text = common::CHAIN
        .replace("cells: 48", "cells: 48, octaves: 2")
        .replace("    nodes: {\n", &format!("    nodes: {{\n        {nodes}\n"))
        .replace("{\"hills\": (0, 0),", "{\"odd\": (0, 1500), \"calm\": (2400, 1500), \"hills\": (0, 0),")
        .replace("(280, ", "(1100, ")
        .replace("260)", "700)")
        .replace("(560, ", "(2400, ")
        .replace("(840, ", "(3600, ");
    fs::write(&place.graph, text).unwrap();
    let mut editor = open_sized(place.start(), SIZE);
    show_all(&mut editor);
    assert!(editor.state().app().to_window().scaling < 0.35, "nobody could read it");
    select(&mut editor, "soft");
    (place, editor)
}

/// Colours and a gradient in the inspector, and the picture that they make.
fn colours() -> (Place, Editor) {
    let place = Place::new();
    let text = r##"(format: 1, nodes: {
        "hills": (node: "generate.fbm", version: 1, params: (cells: 48, octaves: 2)),
        "relief": (node: "look.colour_relief", version: 1, params: (colours: "0 #12324a, 0.3 #3c7a6e, 0.55 #d9c89a, 1 #fff6e8"), inputs: {"terrain": "hills.terrain"}),
    }, layout: (nodes: {"hills": (0, 0), "relief": (280, 0)}))"##;
    fs::write(&place.graph, text).unwrap();
    let mut editor = open_sized(place.start(), SIZE);
    show_all(&mut editor);
    select(&mut editor, "relief");
    (place, editor)
}
