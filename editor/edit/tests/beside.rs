//! What a picture can show besides its value: which terrain it lies on, and what it is compared with.
#![allow(clippy::unwrap_used)]

mod common;

use std::{path::PathBuf, sync::Arc};

use common::{interfaces, link, registry};
use orograph_core::{Context, Value};
use orograph_edit::{
    Beside, Fault, News, Runner, Scene, Shown, Wish,
    beside::ground,
    looks::{Colours, DIFFERENCE},
};
use orograph_engine::{Cache, Document, Evaluator, document::Link};

const GRAPH: &str = r#"(format: 1, nodes: {
    "slope": (node: "generate.gradient", version: 1, params: (direction: 90, slope: 0.01, base: 100)),
    "level": (node: "generate.constant", version: 1, params: (level: 100)),
    "part": (node: "transform.crop", version: 1, params: (rows: 8), inputs: {"terrain": "slope.terrain"}),
    "band": (node: "mask.from_height", version: 1, params: (low: 120, high: 160), inputs: {"terrain": "slope.terrain"}),
    "both": (node: "mask.arithmetic", version: 1, inputs: {"a": "band.mask", "b": "band.mask"}),
    "ridges": (node: "feature.ppa", version: 1, inputs: {"terrain": "part.terrain"}),
    "drawn": (node: "feature.from_curves", version: 1, params: (lines: [[(0.1, 0.5, 1.0), (0.9, 0.5, 1.0)]])),
    "made": (
        node: "synthesis.synthesise", version: 1,
        inputs: {"exemplars": ["slope.terrain"], "features": ["ridges.features"], "sketches": ["drawn.features"]},
    ),
})"#;

fn document() -> Document {
    Document::parse(GRAPH, "test").unwrap()
}

fn grounds(output: &str) -> Vec<String> {
    let registry = registry();
    let found = ground(&document(), &mut interfaces(&registry), &link(output));
    found.iter().map(ToString::to_string).collect()
}

#[test]
fn ground_is_what_a_node_took_or_made() {
    assert_eq!(grounds("slope.terrain"), ["slope.terrain"], "terrain lies on itself");
    assert_eq!(grounds("ridges.features"), ["part.terrain", "slope.terrain"], "the nearest first");
    assert_eq!(grounds("both.mask"), ["slope.terrain"], "a mask of masks lies where those do");
    assert_eq!(grounds("made.placement")[0], "made.terrain", "patches lie on what they became");
    assert_eq!(grounds("drawn.features"), [""; 0], "drawn on nothing");
    assert_eq!(grounds("gone.terrain"), [""; 0]);
}

/// The answer to one wish, at 64 cells.
fn answer(output: &str, look: &str, beside: Beside) -> Result<Shown, Vec<Fault>> {
    let evaluator = Arc::new(Evaluator::new(Cache::new(1 << 26, None), 2).unwrap());
    let mut runner = Runner::new(evaluator, registry(), Arc::new(|| {}));
    let context = Context { seed: 0, resolution: Some(64) };
    let scene = Scene { document: Arc::new(document()), folder: PathBuf::new(), context };
    let wish = Wish {
        name: "it".into(),
        output: link(output),
        look: Some(look.into()),
        beside,
        overrides: Vec::new(),
    };
    runner.show(scene, vec![wish]);
    runner.wait();
    let answers = runner.news().into_iter().filter_map(|news| match news {
        News::Shown(name, result) => Some((name, result)),
        News::Node(name, _) => {
            assert!(document().nodes.contains_key(&name), "`{name}` is no node of the document");
            None
        }
        _ => None,
    });
    let answers: Vec<_> = answers.collect();
    let [(name, result)] = <[_; 1]>::try_from(answers).unwrap();
    assert_eq!(name, "it");
    result
}

fn terrain(value: &Option<Value>) -> Option<(usize, usize)> {
    match value {
        Some(Value::Heightfield(terrain)) => Some((terrain.rows(), terrain.cols())),
        _ => None,
    }
}

#[test]
fn a_difference_is_coloured_alike_to_both_sides() {
    let shown = answer("slope.terrain", DIFFERENCE, Beside::Against(link("level.terrain"))).unwrap();
    assert_eq!(terrain(&shown.beside), Some((64, 64)));
    let scale = shown.scale.unwrap();
    // 10 km rise by 100 m.
    assert_eq!((scale.low, scale.high, scale.colours), (-100.0, 100.0, Colours::Diverging));
    let Some(Value::Texture(picture)) = shown.picture else { panic!("a picture") };
    assert_eq!((picture.rows(), picture.cols()), (64, 64), "nothing stands beside the ground");
    let [white, .., red] = [picture.at(32, 0), picture.at(32, 63)];
    assert!(white.iter().all(|part| *part > 235), "no difference is white: {white:?}");
    assert!(red[0] > red[2] + 60, "higher is red: {red:?}");
    let back = answer("level.terrain", DIFFERENCE, Beside::Against(link("slope.terrain"))).unwrap();
    let Some(Value::Texture(picture)) = back.picture else { panic!("a picture") };
    let blue = picture.at(32, 63);
    assert!(blue[2] > blue[0] + 60, "lower is blue: {blue:?}");
}

#[test]
fn what_cannot_be_compared_names_the_mend() {
    let against = |output: &str, other: &str| {
        let faults = answer(output, DIFFERENCE, Beside::Against(link(other))).err().unwrap();
        let [fault] = <[_; 1]>::try_from(faults).unwrap();
        assert_eq!(fault.node, Some(link(output).node));
        (fault.message, fault.help.unwrap_or_default())
    };
    let (message, help) = against("slope.terrain", "part.terrain");
    assert!(message.contains("64 × 64") && message.contains("8 × 64"), "{message}");
    assert!(help.contains("transform.resize"), "{help}");
    assert!(against("slope.terrain", "band.mask").0.contains("no difference"));
}

#[test]
fn a_picture_is_drawn_over_the_first_terrain_on_its_grid() {
    let over = |links: &[&str]| {
        let links: Vec<Link> = links.iter().map(|text| link(text)).collect();
        answer("band.mask", "look.mask_overlay", Beside::Over(links)).unwrap()
    };
    let bare = over(&[]);
    let found = over(&["part.terrain", "slope.terrain"]);
    assert_eq!(terrain(&found.beside), Some((64, 64)));
    assert!(matches!(found.ground, Some(Value::Texture(_))));
    let pixels = |shown: &Shown| match &shown.picture {
        Some(Value::Texture(picture)) => picture.cells().to_vec(),
        _ => panic!("a picture"),
    };
    assert_ne!(pixels(&bare), pixels(&found), "the ground is seen");
    // Without ground of its size, and with ground that is not there, it is drawn over nothing.
    for links in [&["part.terrain"][..], &["gone.terrain"], &["band.mask"]] {
        let shown = over(links);
        assert_eq!(pixels(&shown), pixels(&bare));
        assert!(shown.beside.is_none() && shown.ground.is_none());
    }
}
