//! A painting of several layers, over a picture of its own.

use std::fs;

use crate::common::{
    Editor, Place, click, drag, hand,
    hand::{button, choosing, in_picture},
    open, select, until,
};
use eframe::egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use orograph_engine::document::Literal;

const PAINTING: &str = r#"(
    format: 1,
    nodes: {"map": (node: "feature.paint", version: 1, params: (
        cells: 64, ridges: [[(0.1, 0.1, 0), (0.9, 0.1, 0)]],
    ))},
    layout: (nodes: {"map": (0, 0)}),
)
"#;

fn painting(place: &Place) -> Editor {
    fs::write(&place.graph, PAINTING).unwrap();
    let mut editor = open(place.start());
    select(&mut editor, "map");
    editor
}

fn lines(editor: &Editor, layer: &str) -> Vec<Vec<(f64, f64, f64)>> {
    let document = editor.state().app().document();
    let Some(Literal::List(lines)) = document.nodes["map"].params.get(layer) else { return Vec::new() };
    let number = |literal: &Literal| match literal {
        Literal::Number(number) => *number,
        Literal::Integer(integer) => *integer as f64,
        other => panic!("{other:?}"),
    };
    let point = |literal: &Literal| match literal {
        Literal::Tuple(xyz) | Literal::List(xyz) => (number(&xyz[0]), number(&xyz[1]), number(&xyz[2])),
        other => panic!("{other:?}"),
    };
    let line = |literal: &Literal| match literal {
        Literal::List(points) => points.iter().map(point).collect(),
        other => panic!("{other:?}"),
    };
    lines.iter().map(line).collect()
}

fn layer(editor: &mut Editor, name: &str) {
    button(editor, &format!("paint {name}"));
}

#[test]
fn strokes_go_to_the_layer_under_the_brush() {
    let place = Place::new();
    let mut editor = painting(&place);
    button(&mut editor, "draw");
    layer(&mut editor, "valleys");
    let at = |editor: &Editor, x, y| in_picture(editor, "view", x, y);
    let (from, to) = (at(&editor, 0.2, 0.8), at(&editor, 0.8, 0.8));
    drag(&mut editor, from, to);
    let drawn = lines(&editor, "valleys");
    assert_eq!((drawn.len(), lines(&editor, "ridges").len()), (1, 1));
    let (first, last) = (drawn[0][0], drawn[0][drawn[0].len() - 1]);
    for (found, wanted) in [(first.0, 0.2), (first.1, 0.8), (last.0, 0.8), (last.1, 0.8)] {
        assert!((found - wanted).abs() < 0.03, "{found} for {wanted}");
    }
    layer(&mut editor, "heights");
    button(&mut editor, "point");
    hand::write(&mut editor, Role::SpinButton, "height of what is drawn", "640");
    let spot = at(&editor, 0.5, 0.5);
    click(&mut editor, spot);
    assert_eq!(lines(&editor, "heights")[0][0].2, 640.0);
    layer(&mut editor, "stamps");
    let spot = at(&editor, 0.3, 0.5);
    click(&mut editor, spot);
    assert_eq!(lines(&editor, "stamps").len(), 1);
    // The eraser takes what is on its layer, and nothing of others that lies under it.
    button(&mut editor, "erase");
    let spot = at(&editor, 0.5, 0.8);
    click(&mut editor, spot);
    assert_eq!(lines(&editor, "valleys").len(), 1);
    layer(&mut editor, "valleys");
    click(&mut editor, spot);
    assert_eq!((lines(&editor, "valleys").len(), lines(&editor, "heights").len()), (0, 1));
}

#[test]
fn a_picture_from_a_file_is_laid_under_the_painting_as_one_step() {
    let place = Place::new();
    let map = place.folder.path().join("map.png");
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/pictures/editor-relief.png"), &map).unwrap();
    let (dialogs, _) = choosing(&map);
    fs::write(&place.graph, PAINTING).unwrap();
    let mut editor = open(orograph_editor::Start { dialogs, ..place.start() });
    select(&mut editor, "map");
    button(&mut editor, "picture under it…");
    until(&mut editor, |app| app.document().nodes.contains_key("read_texture"));
    let document = editor.state().app().document().clone();
    assert_eq!(document.nodes["read_texture"].params["file"], Literal::Text("map.png".into()));
    assert_eq!(document.nodes["map"].inputs["picture"][0].to_string(), "read_texture.texture");
    assert!(editor.query_by_label("picture under it…").is_none(), "there is one now");
    crate::common::press(&mut editor, eframe::egui::Modifiers::COMMAND, eframe::egui::Key::Z);
    assert_eq!(editor.state().app().document().nodes.len(), 1);
}
