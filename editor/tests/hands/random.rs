//! Hundreds of gestures by chance through the window's own commands, keys and pointer: undone to the start, redone to
//! the end, and every document that was met on the way is met again.
//!
//! What lies below the window is tried by thousands of edits in `edit/tests/editing.rs`.

use std::{fs, sync::Arc};

use crate::common::{
    Editor, Place, at, click, copied, drag,
    hand::{boxed, in_window},
    open, title,
};
use eframe::egui::{Event, Key, Modifiers, Pos2, accesskit::Role, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use orograph_editor::Command;
use orograph_engine::Document;

const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const NONE: Modifiers = Modifiers::NONE;

/// Gestures of one run.
const GESTURES: usize = 150;

/// Nodes at which copying ends.
const MOST: usize = 20;

/// Nodes that are added by their names; all are cheap.
const NODES: [&str; 6] = [
    "generate.constant",
    "adjust.clamp",
    "mask.from_height",
    "mask.to_height",
    "look.hillshade",
    "feature.from_curves",
];

/// Numbers that look like chance and are the same in every run (xorshift of Marsaglia, 2003).
struct Chance(u64);

impl Chance {
    fn next(&mut self, below: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 33) as usize) % below.max(1)
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.next(all.len()))
    }
}

fn keys(editor: &mut Editor, modifiers: Modifiers, key: Key) {
    editor.key_press_modifiers(modifiers, key);
    editor.run_steps(1);
}

/// Names of the widgets of the canvas that begin with `kind`.
fn labels(editor: &Editor, kind: &str) -> Vec<String> {
    let buttons = editor.query_all_by_role(Role::Button);
    let labels = buttons.filter_map(|node| node.accesskit_node().label());
    labels.filter(|label| label.starts_with(kind)).collect()
}

/// What the harness finds twice is told twice, and can be pointed at by neither.
fn place_of(editor: &Editor, label: &str) -> Option<Pos2> {
    let twice = editor.query_all_by_role_and_label(Role::Button, label).count() > 1;
    (!twice).then(|| at(editor, label))
}

fn gesture(editor: &mut Editor, chance: &mut Chance, clipboard: &mut Option<String>) {
    let node = {
        let names: Vec<String> = editor.state().app().document().nodes.keys().cloned().collect();
        chance.of(&names).cloned()
    };
    // Copies of copies would soon be all that there is.
    let crowded = editor.state().app().document().nodes.len() > MOST;
    let step = |chance: &mut Chance| vec2(chance.next(160) as f32 - 80.0, chance.next(120) as f32 - 60.0);
    match chance.next(24) {
        0..=3 => {
            keys(editor, NONE, Key::Tab);
            let words = chance.of(&NODES).unwrap().replace(['.', '_'], " ");
            editor.event(Event::Text(words));
            editor.run_steps(1);
            keys(editor, NONE, Key::Enter);
        }
        4..=9 => {
            let (outputs, inputs) = (labels(editor, "output "), labels(editor, "input "));
            let ends = (chance.of(&outputs).cloned(), chance.of(&inputs).cloned());
            if let (Some(from), Some(to)) = ends
                && let (Some(from), Some(to)) = (place_of(editor, &from), place_of(editor, &to))
            {
                drag(editor, from + vec2(3.0, 0.0), to - vec2(3.0, 0.0));
            }
        }
        10..=12 => {
            if let Some(name) = node
                && editor.state().app().document().layout.nodes.contains_key(&name)
            {
                let from = title(editor, &name);
                let to = from + step(chance);
                match chance.next(2) {
                    0 => click(editor, from),
                    _ => drag(editor, from, to),
                }
            }
        }
        13 => {
            let (from, to) = (in_window(editor, -60.0, -60.0), in_window(editor, 400.0, 200.0));
            boxed(editor, NONE, from, to + step(chance));
        }
        14 => {
            let key = [Key::B, Key::L, Key::T, Key::F][chance.next(4)];
            keys(editor, NONE, key);
            keys(editor, NONE, Key::Enter);
        }
        15 => match chance.next(3) {
            0 => keys(editor, NONE, Key::Delete),
            1 => keys(editor, CTRL, Key::Delete),
            _ => keys(editor, NONE, Key::ArrowRight),
        },
        16 if !crowded => keys(editor, CTRL, Key::D),
        17 => {
            editor.event(Event::Copy);
            editor.run_steps(1);
            *clipboard = copied(editor).or(clipboard.take());
        }
        18 => {
            if let Some(text) = clipboard.clone().filter(|_| !crowded) {
                editor.event(Event::Paste(text));
            }
        }
        19 => {
            let dice: Vec<String> =
                labels(editor, "expose ").into_iter().chain(labels(editor, "reset ")).collect();
            if let Some(label) = chance.of(&dice) {
                editor.get_by_role_and_label(Role::Button, label).click();
            }
        }
        20 => {
            let ctx = editor.ctx.clone();
            let command = [Command::Arrange, Command::SelectAll, Command::SelectNone][chance.next(3)];
            editor.state_mut().app_mut().command(&ctx, command);
        }
        21 | 22 => keys(editor, CTRL, Key::Z),
        _ => keys(editor, CTRL.plus(SHIFT), Key::Z),
    }
    editor.run_steps(2);
    let refused = editor.query_by_role_and_label(Role::Button, "Leave it").is_some();
    if refused {
        // A wire that does not fit: now and then what converts is put between.
        let offers = labels(editor, "Insert ");
        let offer = chance.of(&offers).filter(|_| chance_of_two(editor)).cloned();
        editor.get_by_role_and_label(Role::Button, offer.as_deref().unwrap_or("Leave it")).click();
        editor.run_steps(2);
    }
    // A wire that was let go over nothing, or a click there, asks for a node.
    if editor.query_by_label("search nodes").is_some() {
        keys(editor, NONE, Key::Escape);
    }
}

/// Every second time, by the number of nodes.
fn chance_of_two(editor: &Editor) -> bool {
    editor.state().app().document().nodes.len().is_multiple_of(2)
}

fn play(seed: u64) {
    let place = Place::new();
    let text = r#"(format: 1, nodes: {
        "ground": (node: "generate.constant", version: 1, params: (cells: 16)),
        "kept": (node: "adjust.clamp", version: 1, inputs: {"terrain": "ground.terrain"}),
    }, layout: (nodes: {"ground": (0, 0), "kept": (300, 0)}))"#;
    fs::write(&place.graph, text).unwrap();
    let mut start = place.start();
    start.file = Some(place.graph.clone());
    let mut editor = open(start);
    let ctx = editor.ctx.clone();
    editor.state_mut().app_mut().command(&ctx, Command::Thumbnails);
    let (mut chance, mut clipboard) = (Chance(seed), None);
    let first = editor.state().app().document().clone();
    // Every document met, the newest last; as the history has them: what was undone and then edited over is gone.
    for _ in 0..GESTURES {
        gesture(&mut editor, &mut chance, &mut clipboard);
    }
    // The steps of the history, from the last to the first.
    while redo(&mut editor) {}
    let last = editor.state().app().document().clone();
    let mut met: Vec<Arc<Document>> = vec![last.clone()];
    loop {
        let before = editor.state().app().document().clone();
        keys(&mut editor, CTRL, Key::Z);
        let now = editor.state().app().document().clone();
        if now == before {
            break;
        }
        met.push(now);
    }
    assert!(met.len() > GESTURES / 4, "seed {seed}: {} steps", met.len());
    assert_eq!(met.pop().unwrap(), first, "seed {seed}: undone to the start");
    assert!(!editor.state().app().is_dirty());
    while let Some(expected) = met.pop() {
        assert!(redo(&mut editor), "seed {seed}");
        assert_eq!(*editor.state().app().document(), expected, "seed {seed}");
    }
    assert_eq!(*editor.state().app().document(), last, "seed {seed}: redone to the end");
    assert!(!redo(&mut editor));
    // And what is shown can be saved and read again.
    let registry = orograph_session::built_in().unwrap();
    assert_eq!(Document::parse(&last.to_ron(&registry), "saved").unwrap(), *last, "seed {seed}");
}

fn redo(editor: &mut Editor) -> bool {
    let before = editor.state().app().document().clone();
    keys(editor, CTRL.plus(SHIFT), Key::Z);
    before != *editor.state().app().document()
}

#[test]
fn gestures_by_chance_are_undone_to_the_start_and_redone_to_the_end() {
    play(0x0123_4567_89ab_cdef);
}

#[test]
fn other_gestures_by_chance_are_undone_and_redone() {
    play(0xfeed_beef_0bad_cafe);
}
