//! Steps of the history: whatever was done can be taken back and made again.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use common::{add, chain, interfaces, link, registry};
use orograph_edit::{Delta, Editing, Interfaces, Refused, clipboard, operations, subgraph};
use orograph_engine::{
    Document, Registry,
    document::{Literal, Node},
};
use proptest::prelude::*;

/// A gesture, by numbers that choose among what there is.
#[derive(Clone, Debug)]
enum Step {
    Add(usize),
    Connect(usize, usize, usize, usize),
    Disconnect(usize),
    Remove(usize),
    Dissolve(usize),
    Rename(usize, u8),
    Set(usize, usize, i32),
    Reset(usize, usize),
    Move(usize, i16, i16),
    Bypass(usize),
    Comment(usize, u8),
    Expose(usize, usize),
    Output(usize),
    Frame(u8),
    Copy(usize, usize),
    Collapse(usize, usize),
    Undo,
    Redo,
}

fn step() -> impl Strategy<Value = Step> {
    let n = 0..1000usize;
    prop_oneof![
        4 => n.clone().prop_map(Step::Add),
        6 => (n.clone(), n.clone(), n.clone(), n.clone()).prop_map(|(a, b, c, d)| Step::Connect(a, b, c, d)),
        1 => n.clone().prop_map(Step::Disconnect),
        1 => n.clone().prop_map(Step::Remove),
        1 => n.clone().prop_map(Step::Dissolve),
        1 => (n.clone(), any::<u8>()).prop_map(|(a, b)| Step::Rename(a, b)),
        3 => (n.clone(), n.clone(), any::<i32>()).prop_map(|(a, b, c)| Step::Set(a, b, c)),
        1 => (n.clone(), n.clone()).prop_map(|(a, b)| Step::Reset(a, b)),
        2 => (n.clone(), any::<i16>(), any::<i16>()).prop_map(|(a, x, y)| Step::Move(a, x, y)),
        1 => n.clone().prop_map(Step::Bypass),
        1 => (n.clone(), any::<u8>()).prop_map(|(a, b)| Step::Comment(a, b)),
        1 => (n.clone(), n.clone()).prop_map(|(a, b)| Step::Expose(a, b)),
        1 => n.clone().prop_map(Step::Output),
        1 => any::<u8>().prop_map(Step::Frame),
        1 => (n.clone(), n.clone()).prop_map(|(a, b)| Step::Copy(a, b)),
        1 => (n.clone(), n).prop_map(|(a, b)| Step::Collapse(a, b)),
        2 => Just(Step::Undo),
        1 => Just(Step::Redo),
    ]
}

fn nth(document: &Document, index: usize) -> Option<(String, Node)> {
    let (name, node) = document.nodes.get_index(index % document.nodes.len().max(1))?;
    Some((name.clone(), node.clone()))
}

/// Makes a step; what is refused leaves the document as it was, which is checked too.
fn make(editing: &mut Editing, interfaces: &mut Interfaces, registry: &Arc<Registry>, step: &Step) {
    let before = editing.document().clone();
    let state = editing.state();
    let result = editing.edit("step", |document| perform(document, interfaces, registry, step));
    if result.is_err() {
        assert!(Arc::ptr_eq(&before, editing.document()), "a refused edit leaves no trace");
        assert_eq!(state, editing.state());
    }
}

fn perform(
    document: &mut Document,
    interfaces: &mut Interfaces,
    registry: &Arc<Registry>,
    step: &Step,
) -> Result<(), Refused> {
    let nothing = || Refused::new("there is nothing there", "add something");
    match step {
        Step::Add(index) => {
            let all: Vec<_> = registry.iter().collect();
            operations::add(document, all[index % all.len()], (*index as f64, 0.0));
        }
        Step::Connect(a, out, b, input) => {
            let (from, from_node) = nth(document, *a).ok_or_else(nothing)?;
            let (to, to_node) = nth(document, *b).ok_or_else(nothing)?;
            let source = interfaces.of(&from, &from_node, document);
            let target = interfaces.of(&to, &to_node, document);
            if source.outputs.is_empty() || target.inputs.is_empty() {
                return Err(nothing());
            }
            let from = link(&format!("{from}.{}", source.outputs[out % source.outputs.len()].name));
            let to = link(&format!("{to}.{}", target.inputs[input % target.inputs.len()].name));
            operations::connect(document, interfaces, &from, &to)?;
        }
        Step::Disconnect(index) => {
            let (name, node) = nth(document, *index).ok_or_else(nothing)?;
            let (port, links) = node.inputs.first().ok_or_else(nothing)?;
            operations::disconnect(document, &links[0], &link(&format!("{name}.{port}")));
        }
        Step::Remove(index) => operations::remove(document, &[&nth(document, *index).ok_or_else(nothing)?.0]),
        Step::Dissolve(index) => {
            let name = nth(document, *index).ok_or_else(nothing)?.0;
            operations::dissolve(document, interfaces, &name);
        }
        Step::Rename(index, new) => {
            let name = nth(document, *index).ok_or_else(nothing)?.0;
            operations::rename(document, &name, &format!("n{new}"))?;
        }
        Step::Set(index, param, value) => {
            let (name, node) = nth(document, *index).ok_or_else(nothing)?;
            let params = interfaces.of(&name, &node, document).params.clone();
            let param = params.get(param % params.len().max(1)).ok_or_else(nothing)?;
            operations::set_param(document, &name, &param.name, Some(Literal::Integer(i64::from(*value))))?;
        }
        Step::Reset(index, param) => {
            let (name, node) = nth(document, *index).ok_or_else(nothing)?;
            let param =
                node.params.get_index(param % node.params.len().max(1)).ok_or_else(nothing)?.0.clone();
            operations::set_param(document, &name, &param, None)?;
        }
        Step::Move(index, x, y) => {
            let name = nth(document, *index).ok_or_else(nothing)?.0;
            document.layout.nodes.insert(name, (f64::from(*x), f64::from(*y)));
        }
        Step::Bypass(index) => {
            operations::toggle_bypass(document, &[&nth(document, *index).ok_or_else(nothing)?.0])
        }
        Step::Comment(index, text) => {
            let name = nth(document, *index).ok_or_else(nothing)?.0;
            document.nodes[&name].comment = format!("comment {text}");
        }
        Step::Expose(index, param) => {
            let (name, node) = nth(document, *index).ok_or_else(nothing)?;
            let params = interfaces.of(&name, &node, document).params.clone();
            let param = params.get(param % params.len().max(1)).ok_or_else(nothing)?;
            operations::expose(document, link(&format!("{name}.{}", param.name)));
        }
        Step::Output(index) => {
            let (name, node) = nth(document, *index).ok_or_else(nothing)?;
            let outputs = interfaces.of(&name, &node, document).outputs.clone();
            let output = outputs.first().ok_or_else(nothing)?;
            document.outputs.insert(format!("o{index}"), link(&format!("{name}.{}", output.name)));
        }
        Step::Frame(title) => operations::frame(document, &title.to_string(), (0.0, 0.0), (100.0, 100.0)),
        Step::Copy(a, b) => {
            let names = [nth(document, *a).ok_or_else(nothing)?.0, nth(document, *b).ok_or_else(nothing)?.0];
            let text = clipboard::copy(document, &[&names[0], &names[1]], registry);
            clipboard::paste(document, &text, (5.0, 5.0)).map_err(|e| Refused::new(e.to_string(), ""))?;
        }
        Step::Collapse(a, b) => {
            let names = [nth(document, *a).ok_or_else(nothing)?.0, nth(document, *b).ok_or_else(nothing)?.0];
            let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
            names.dedup();
            subgraph::collapse(document, interfaces, &names, "inner.ron")?;
        }
        Step::Undo | Step::Redo => {}
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Five thousand gestures in all; each document on the way comes back on the way back.
    #[test]
    fn any_gestures_are_undone_to_the_start_and_redone_to_the_end(steps in prop::collection::vec(step(), 1..160)) {
        let registry = registry();
        let mut interfaces = interfaces(&registry);
        let mut editing = Editing::new(chain(&registry));
        let start = editing.document().clone();
        for step in &steps {
            match step {
                Step::Undo => { editing.undo(); }
                Step::Redo => { editing.redo(); }
                step => make(&mut editing, &mut interfaces, &registry, step),
            }
        }
        while editing.redo() {}
        let end = editing.document().clone();
        let mut passed = vec![end.clone()];
        while editing.undo() {
            passed.push(editing.document().clone());
        }
        prop_assert_eq!(&**editing.document(), &*start);
        prop_assert!(!editing.is_dirty());
        while let Some(expected) = passed.pop() {
            prop_assert_eq!(&**editing.document(), &*expected);
            // What is shown can always be saved, and reads back as what it was.
            let text = expected.to_ron(&registry);
            prop_assert_eq!(&Document::parse(&text, "saved").unwrap(), &*expected);
            editing.redo();
        }
        prop_assert_eq!(&**editing.document(), &*end);
    }

    #[test]
    fn a_delta_turns_one_document_into_the_other_and_back(a in prop::collection::vec(step(), 0..40), b in prop::collection::vec(step(), 0..40)) {
        let registry = registry();
        let mut interfaces = interfaces(&registry);
        let mut build = |steps: &[Step]| {
            let mut editing = Editing::new(chain(&registry));
            steps.iter().for_each(|step| make(&mut editing, &mut interfaces, &registry, step));
            (**editing.document()).clone()
        };
        let (one, other) = (build(&a), build(&b));
        let delta = Delta::between(&one, &other);
        let mut document = one.clone();
        delta.apply(&mut document).unwrap();
        prop_assert_eq!(&document, &other);
        delta.inverse().apply(&mut document).unwrap();
        prop_assert_eq!(&document, &one);
        prop_assert_eq!(delta.is_empty(), one == other);
        if !delta.is_empty() && one != other {
            // It fits no other document, and then changes nothing.
            let mut foreign = Document::new();
            foreign.nodes.insert("alone".into(), Node::of_graph("x.ron"));
            let before = foreign.clone();
            if delta.apply(&mut foreign).is_err() {
                prop_assert_eq!(foreign, before);
            }
        }
    }
}

#[test]
fn a_delta_has_the_fields_of_newer_formats_too() {
    let parse = |text: &str| Document::parse(text, "x.ron").unwrap();
    let (one, other) = (
        parse("(format: 1, nodes: {}, layout: (zoom: 2), materials: {})"),
        parse("(format: 1, nodes: {}, layout: (zoom: 3, grid: On))"),
    );
    let delta = Delta::between(&one, &other);
    assert_eq!(delta.changes().len(), 3);
    let mut document = one.clone();
    delta.apply(&mut document).unwrap();
    assert_eq!(document, other);
    delta.inverse().apply(&mut document).unwrap();
    assert_eq!(document, one);
}

#[test]
fn a_drag_is_one_step_and_one_that_ends_where_it_began_is_none() {
    let registry = registry();
    let mut editing = Editing::new(chain(&registry));
    let set = |editing: &mut Editing, value: f64| {
        editing
            .drag("set hills.amplitude", "set", |document| {
                operations::set_param(document, "hills", "amplitude", Some(Literal::Number(value)))
            })
            .unwrap();
    };
    for value in [10.0, 20.0, 30.0] {
        set(&mut editing, value);
    }
    editing.end_gesture();
    assert_eq!(editing.document().nodes["hills"].params["amplitude"], Literal::Number(30.0));
    assert!(editing.undo());
    assert!(!editing.document().nodes["hills"].params.contains_key("amplitude"));
    assert!(!editing.undo(), "three moves of one drag are one step");
    assert!(editing.redo());
    for value in [40.0, 50.0, 30.0] {
        set(&mut editing, value);
    }
    editing.end_gesture();
    assert!(editing.undo());
    assert!(!editing.document().nodes["hills"].params.contains_key("amplitude"), "there and back is no step");
}

#[test]
fn saving_is_remembered_by_state_and_not_by_count() {
    let registry = registry();
    let mut editing = Editing::new(chain(&registry));
    let bypass = |editing: &mut Editing, name: &str| {
        editing
            .edit("bypass", |document| {
                operations::toggle_bypass(document, &[name]);
                Ok::<_, Refused>(())
            })
            .unwrap();
    };
    bypass(&mut editing, "soft");
    let state = editing.to_be_saved();
    editing.saved(state);
    assert!(!editing.is_dirty());
    editing.undo();
    assert!(editing.is_dirty());
    bypass(&mut editing, "shade");
    assert!(editing.is_dirty(), "one step from the start again, but another one");
    editing.undo();
    assert!(editing.redo_label().is_some());
}

#[test]
fn a_wire_between_types_is_refused_with_what_would_convert() {
    let registry = registry();
    let mut interfaces = interfaces(&registry);
    let mut document = chain(&registry);
    let mask = add(&mut document, &registry, "mask.from_height");
    let to_blur = (link(&format!("{mask}.mask")), link("soft.terrain"));
    let refused = operations::connect(&mut document, &mut interfaces, &to_blur.0, &to_blur.1).unwrap_err();
    assert_eq!(refused.message, format!("`{mask}.mask` gives a Mask, `soft.terrain` takes a Heightfield"));
    assert!(refused.converters.iter().any(|id| id == "mask.to_height"), "{:?}", refused.converters);
    let name =
        operations::connect_through(&mut document, &mut interfaces, "mask.to_height", &to_blur.0, &to_blur.1)
            .unwrap();
    assert_eq!(document.nodes["soft"].inputs["terrain"], [link(&format!("{name}.terrain"))]);
    let cycle = operations::connect(
        &mut document,
        &mut interfaces,
        &link("soft.terrain"),
        &link(&format!("{mask}.terrain")),
    );
    assert!(cycle.unwrap_err().message.contains("cycle"));
}

#[test]
fn what_is_copied_is_a_graph_of_its_own_and_pastes_under_free_names() {
    let registry = registry();
    let mut document = chain(&registry);
    let text = clipboard::copy(&document, &["soft", "shade"], &registry);
    let names = clipboard::paste(&mut document, &text, (100.0, 300.0)).unwrap();
    assert_eq!(names, ["shade_2", "soft_2"]);
    assert_eq!(document.nodes["shade_2"].inputs["terrain"], [link("soft_2.terrain")]);
    assert_eq!(
        document.nodes["soft_2"].inputs["terrain"],
        [link("hills.terrain")],
        "its source is still there"
    );
    assert_eq!(document.layout.nodes["soft_2"], (100.0, 300.0));
    assert_eq!(document.layout.nodes["shade_2"], (350.0, 300.0));
    let mut elsewhere = Document::new();
    clipboard::paste(&mut elsewhere, &text, (0.0, 0.0)).unwrap();
    assert!(elsewhere.nodes["soft"].inputs.is_empty(), "there is no `hills` there");
    assert!(clipboard::paste(&mut elsewhere, "good morning", (0.0, 0.0)).is_err());
}

#[test]
fn a_node_of_an_unknown_type_survives_every_edit_around_it() {
    let registry = registry();
    let text = r#"(format: 1, nodes: {
        "odd": (node: "acme.magic", version: 3, params: (power: 9, spell: [(1, 2)]), plugin: "Acme", later_field: 7),
        "soft": (node: "filter.gaussian_blur", version: 1, inputs: {"terrain": "odd.out"}),
    })"#;
    let mut document = Document::parse(text, "odd").unwrap();
    let mut interfaces = interfaces(&registry);
    let interface = interfaces.of("odd", &document.nodes["odd"], &document);
    assert!(matches!(interface.kind, orograph_edit::Kind::Unknown(_)));
    assert_eq!(interface.outputs[0].name, "out", "its ports are those that wires name");
    operations::rename(&mut document, "soft", "softer").unwrap();
    let saved = Document::parse(&document.to_ron(&registry), "saved").unwrap();
    assert_eq!(saved.nodes["odd"], Document::parse(text, "odd").unwrap().nodes["odd"]);
}
