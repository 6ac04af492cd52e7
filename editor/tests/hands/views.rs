//! What panes show, and how: compared, wiped, over ground, plotted. Through the accessibility tree: no pixels.

use std::fs;

use crate::common::{Editor, Place, drag, open, press, select, settle};
use eframe::egui::{Key, Modifiers, Pos2, Rect, accesskit::Role, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use orograph_core::Value;

const NONE: Modifiers = Modifiers::NONE;

/// Level ground, the same raised by a slope of 1 in 100 to the east, a part of it, masks, lines and tables of it.
const GROUND: &str = r#"(
    format: 1,
    nodes: {
        "level": (node: "generate.constant", version: 1, params: (level: 100)),
        "slope": (node: "generate.gradient", version: 1, params: (direction: 90, slope: 0.01, base: 100)),
        "part": (node: "transform.crop", version: 1, params: (rows: 100, cols: 100), inputs: {"terrain": "slope.terrain"}),
        "high": (node: "mask.from_height", version: 1, params: (low: 120, high: 160), inputs: {"terrain": "slope.terrain"}),
        "drawn": (
            node: "feature.from_curves", version: 1,
            params: (lines: [[(0.1, 0.5, 1.0), (0.9, 0.5, 1.0)]], kind: "valley"),
            inputs: {"like": "slope.terrain"},
        ),
        "row": (node: "transform.crop", version: 1, params: (rows: 1), inputs: {"terrain": "slope.terrain"}),
        "all": (node: "mask.from_height", version: 1, params: (low: -1000, high: 10000), inputs: {"terrain": "slope.terrain"}),
        "void": (node: "adjust.punch", version: 1, inputs: {"terrain": "slope.terrain", "mask": "all.mask"}),
        "hills": (node: "generate.fbm", version: 1),
        "curve": (node: "measure.slope_distribution", version: 1, inputs: {"terrain": "hills.terrain"}),
    },
    layout: (nodes: {
        "level": (0, 0), "slope": (0, 260), "part": (280, 0), "high": (280, 260),
        "row": (1120, 0), "all": (840, 260), "void": (1120, 260), "drawn": (560, 0), "hills": (560, 260), "curve": (840, 0),
    }),
)
"#;

fn editor() -> (Place, Editor) {
    let place = Place::new();
    fs::write(&place.graph, GROUND).unwrap();
    let editor = open(place.start());
    (place, editor)
}

/// Chooses a way to look in a pane.
fn look(editor: &mut Editor, pane: &str, way: &str) {
    editor.get_by_label(&format!("look of {pane}")).click();
    editor.run_steps(3);
    editor.get_by_role_and_label(Role::Button, way).click();
    settle(editor);
}

fn button(editor: &mut Editor, label: &str) {
    editor.get_by_role_and_label(Role::Button, label).click();
    settle(editor);
}

fn check(editor: &mut Editor, label: &str) {
    editor.get_by_role_and_label(Role::CheckBox, label).click();
    settle(editor);
}

fn rect(editor: &Editor, label: &str) -> Rect {
    editor.get_by_label(label).rect()
}

/// What is told of the place under the pointer: the words at the foot of a view.
fn under(editor: &mut Editor, pos: Pos2, part: &str) -> String {
    editor.hover_at(pos);
    editor.run_steps(3);
    words(editor, part)
}

/// The words of the one widget that says `part`.
fn words(editor: &Editor, part: &str) -> String {
    let node = editor.get_by_label_contains(part).accesskit_node();
    node.value().or_else(|| node.label()).unwrap_or_default()
}

#[test]
fn a_difference_tells_both_heights_and_how_far_the_one_lies_above_the_other() {
    let (_place, mut editor) = editor();
    select(&mut editor, "level");
    press(&mut editor, NONE, Key::V);
    // The second view stays with the level ground, the first follows to the slope.
    select(&mut editor, "slope");
    look(&mut editor, "view", "difference");
    assert!(editor.query_by_label("slope.terrain − level.terrain").is_some());
    // 10 km rise by 100 m, so nearly all of it lies within a round 100 m.
    assert!(editor.query_by_label("colours from -100 m to +100 m").is_some());
    let middle = rect(&editor, "picture view").center();
    let told = under(&mut editor, middle, "against");
    assert!(told.contains("m against 100.00 m: +50.") || told.contains("m against 100.00 m: +49."), "{told}");

    // The other way round, in the other view.
    look(&mut editor, "view", "hillshade");
    look(&mut editor, "second view", "difference");
    assert!(editor.query_by_label("level.terrain − slope.terrain").is_some());
    let middle = rect(&editor, "picture second view").center();
    let told = under(&mut editor, middle, "against");
    assert!(told.contains("100.00 m against"), "{told}");
    assert!(told.contains(": -50.") || told.contains(": -49."), "{told}");
}

#[test]
fn terrains_of_other_sizes_have_no_difference_and_the_mend_is_told() {
    let (_place, mut editor) = editor();
    select(&mut editor, "part");
    press(&mut editor, NONE, Key::V);
    select(&mut editor, "slope");
    look(&mut editor, "view", "difference");
    let why = "`slope.terrain` has 512 × 512 cells and `part.terrain` 100 × 100 cells";
    assert!(editor.query_by_label(why).is_some());
    assert!(editor.query_by_label_contains("or `transform.crop`").is_some());
    // A mask is no terrain.
    select(&mut editor, "high");
    assert!(
        editor.query_by_label_contains("`high.mask` is a Mask and `part.terrain` a Heightfield").is_some()
    );
}

#[test]
fn two_masks_differ_by_shares() {
    let (_place, mut editor) = editor();
    select(&mut editor, "high");
    press(&mut editor, NONE, Key::V);
    look(&mut editor, "view", "difference");
    assert!(editor.query_by_label("colours from -1 to +1").is_some());
    let middle = rect(&editor, "picture view").center();
    let told = under(&mut editor, middle, "against");
    assert!(told.ends_with(": 0.000"), "{told}");
}

#[test]
fn linked_views_look_at_the_same_place_until_they_are_let_go() {
    let (_place, mut editor) = editor();
    select(&mut editor, "slope");
    press(&mut editor, NONE, Key::V);
    let (first, second) = (rect(&editor, "picture view"), rect(&editor, "picture second view"));
    let at = |rect: Rect| rect.left_top() + rect.size() * vec2(0.4, 0.5);
    let before = under(&mut editor, at(second), "row ");
    drag(&mut editor, first.center(), first.center() + vec2(40.0, 0.0));
    let moved = under(&mut editor, at(first), "row ");
    assert_ne!(moved, before, "the picture was moved");
    assert_eq!(under(&mut editor, at(second), "row "), moved, "and took the other along");

    check(&mut editor, "linked");
    drag(&mut editor, first.center(), first.center() - vec2(40.0, 0.0));
    assert_eq!(under(&mut editor, at(second), "row "), moved, "it stays");
    assert_ne!(under(&mut editor, at(first), "row "), moved);
}

#[test]
fn a_line_can_be_drawn_over_two_pictures_of_one_place() {
    let (_place, mut editor) = editor();
    select(&mut editor, "level");
    press(&mut editor, NONE, Key::V);
    select(&mut editor, "slope");
    check(&mut editor, "wipe");
    let line = || "line between the pictures";
    let share = |editor: &Editor| editor.get_by_label(line()).accesskit_node().numeric_value().unwrap();
    assert_eq!(share(&editor), 0.5);
    let both = rect(&editor, "both pictures, with a line between");
    let handle = rect(&editor, line()).center();
    assert!((handle.x - both.center().x).abs() < 1.0);
    drag(&mut editor, handle, pos2(both.left() + both.width() * 0.25, handle.y));
    assert!((share(&editor) - 0.25).abs() < 0.01, "{}", share(&editor));
    // Both values are told, on either side of the line.
    let told = under(&mut editor, both.center(), " | ");
    assert!(told.contains("m   |   100.00 m"), "{told}");

    // What is no picture cannot be wiped.
    select(&mut editor, "curve");
    assert!(editor.query_by_label_contains("The view shows no picture of `curve.metrics`").is_some());
    check(&mut editor, "wipe");
    assert!(editor.query_by_label("picture second view").is_some());
}

#[test]
fn lines_are_told_with_the_ground_that_they_were_drawn_on() {
    let (_place, mut editor) = editor();
    select(&mut editor, "drawn");
    assert!(matches!(editor.state().app().shown(), Some(Value::Features(_))));
    let middle = rect(&editor, "picture view").center();
    let told = under(&mut editor, middle, "valley 1");
    assert!(told.contains("valley 1 of 1   at 1"), "{told}");
    // In three dimensions they lie on that ground.
    button(&mut editor, "3D");
    assert!(editor.query_by_label("ground view").is_some());
    select(&mut editor, "high");
    assert!(editor.query_by_label("ground view").is_some(), "so does a mask");
    button(&mut editor, "2D");
    let middle = rect(&editor, "picture view").center();
    let told = under(&mut editor, middle, "row ");
    assert!(told.contains("at 1"), "{told}");
}

#[test]
fn arrows_walk_around_ground_that_was_clicked() {
    let (_place, mut editor) = editor();
    select(&mut editor, "slope");
    button(&mut editor, "3D");
    assert!(editor.query_by_label("seen from 200°, 35° up").is_some());
    let middle = rect(&editor, "ground view").center();
    crate::common::click(&mut editor, middle);
    press(&mut editor, NONE, Key::ArrowRight);
    press(&mut editor, NONE, Key::ArrowUp);
    assert!(editor.query_by_label("seen from 205°, 40° up").is_some());
    assert_eq!(editor.state().app().selection(), ["slope"], "the arrows are the view's");
    // All other keys are still those of the window.
    press(&mut editor, NONE, Key::B);
    assert!(editor.state().app().document().nodes["slope"].bypass);
    press(&mut editor, Modifiers::COMMAND, Key::Z);
    assert!(!editor.state().app().document().nodes["slope"].bypass);
}

#[test]
fn ground_that_is_level_thin_or_void_is_told_and_breaks_nothing() {
    let (_place, mut editor) = editor();
    select(&mut editor, "level");
    button(&mut editor, "3D");
    assert!(editor.query_by_label("ground view").is_some());
    select(&mut editor, "row");
    assert!(editor.query_by_label_contains("two rows and two columns").is_some());
    select(&mut editor, "void");
    assert!(editor.query_by_label_contains("every cell is a void").is_some());
    button(&mut editor, "2D");
    let middle = rect(&editor, "picture view").center();
    assert!(under(&mut editor, middle, "row ").ends_with("void"));
}

#[test]
fn a_legend_says_what_colours_mean() {
    let (_place, mut editor) = editor();
    select(&mut editor, "level");
    assert!(editor.query_by_label_contains("colours from").is_none(), "shading has no numbers");
    look(&mut editor, "view", "slope");
    assert!(editor.query_by_label("colours from 0 deg to 60 deg").is_some());
    select(&mut editor, "high");
    assert!(editor.query_by_label("colours from 0 to 1").is_some());
}

#[test]
fn a_table_is_read_or_plotted_and_so_is_another_output_of_its_node() {
    let (_place, mut editor) = editor();
    select(&mut editor, "curve");
    let rows = |editor: &Editor| match editor.state().app().shown() {
        Some(Value::Table(table)) => table.rows(),
        other => panic!("{other:?} is no table"),
    };
    assert_eq!(rows(&editor), 1);
    button(&mut editor, "plot");
    assert!(editor.query_by_label_contains("A plot needs two rows").is_some());

    editor.get_by_label("output in view").click();
    editor.run_steps(3);
    button(&mut editor, "histogram");
    assert!(rows(&editor) > 10);
    let plot =
        |editor: &Editor| editor.get_by_label_contains("plot view: ").accesskit_node().label().unwrap();
    let drawn = plot(&editor);
    assert!(drawn.contains(" over slope (deg)"), "{drawn}");
    check(&mut editor, "log y");
    check(&mut editor, "over rows");
    assert!(plot(&editor).ends_with(" over row"), "{}", plot(&editor));
    assert!(!plot(&editor).contains("slope (deg)"), "degrees are not drawn over percents unasked");
    button(&mut editor, "columns");
    check(&mut editor, "slope");
    press(&mut editor, NONE, Key::Escape);
    assert!(plot(&editor).contains("slope (deg), "), "{}", plot(&editor));
    button(&mut editor, "table");
    assert!(editor.query_by_label_contains("plot view: ").is_none());
}
