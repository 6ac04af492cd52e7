//! What a spec promises: names, docs, limits, defaults, keys.

use std::{collections::BTreeSet, path::Path};

use orograph_core::{Hasher, NodeSpec, NodeType, ParamKind, ParamSpec, ParamValue};

use crate::{defaults, sweep};

#[test]
fn ids_are_unique_and_name_their_file() {
    let mut seen = BTreeSet::new();
    for node in orograph_nodes::all() {
        assert!(seen.insert(node.spec().id.to_string()), "{} comes twice", node.spec().id);
    }
    sweep(|node| {
        let id = node.spec().id.as_ref();
        let Some((family, algorithm)) = id.split_once('.') else {
            return vec!["the id has no dot".into()];
        };
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(family);
        let there =
            source.join(format!("{algorithm}.rs")).exists() || source.join(algorithm).join("mod.rs").exists();
        let mut complaints = Vec::new();
        complain(
            &mut complaints,
            family.chars().all(|c| c.is_ascii_lowercase()),
            "its family is no lower-case word",
        );
        complain(&mut complaints, is_snake_case(algorithm), "its algorithm is not in snake case");
        complain(&mut complaints, there, "no file of its name in its family's folder");
        complain(&mut complaints, node.spec().version > 0, "version 0");
        complaints
    });
}

#[test]
fn everything_has_docs_that_read_as_sentences() {
    sweep(|node| {
        let spec = node.spec();
        let mut complaints = Vec::new();
        let mut doc = |what: &str, doc: &str, summary: &str| {
            // A sentence may open with an acronym, a number or a quoted name, but not in lower case.
            let opens = doc.chars().next().is_some_and(|c| !c.is_lowercase());
            complain(&mut complaints, opens, &format!("{what} does not open with a capital: {doc}"));
            complain(
                &mut complaints,
                doc.ends_with('.'),
                &format!("{what} does not end with a full stop: {doc}"),
            );
            complain(
                &mut complaints,
                summary.chars().count() <= 120,
                &format!("{what} has a long tooltip: {summary}"),
            );
        };
        doc("the node", &spec.doc, &spec.summary());
        for port in spec.inputs.iter().chain(&spec.outputs) {
            doc(&format!("port `{}`", port.name), &port.doc, "");
        }
        for param in &spec.params {
            doc(&format!("parameter `{}`", param.name), &param.doc, &param.summary());
            if let ParamKind::Choice { options } = &param.kind {
                for option in options {
                    doc(&format!("option `{}`", option.name), &option.doc, "");
                }
            }
        }
        complaints
    });
}

#[test]
fn names_are_in_snake_case_and_unique() {
    sweep(|node| {
        let spec = node.spec();
        let mut complaints = Vec::new();
        for names in [
            spec.inputs.iter().map(|port| port.name.as_ref()).collect::<Vec<_>>(),
            spec.outputs.iter().map(|port| port.name.as_ref()).collect(),
            spec.params.iter().map(|param| param.name.as_ref()).collect(),
        ] {
            let unique: BTreeSet<_> = names.iter().collect();
            complain(
                &mut complaints,
                unique.len() == names.len(),
                &format!("a name comes twice in {names:?}"),
            );
            for name in names {
                complain(&mut complaints, is_snake_case(name), &format!("`{name}` is not in snake case"));
            }
        }
        complain(
            &mut complaints,
            spec.writes == spec.outputs.is_empty(),
            "it writes files or has outputs, not both",
        );
        complaints
    });
}

#[test]
fn defaults_are_accepted_and_ranges_make_sense() {
    sweep(|node| {
        let mut complaints = Vec::new();
        for param in &node.spec().params {
            if let Err(error) = param.check(&param.default) {
                complaints.push(format!("the default of `{}`: {error}", param.name));
            }
            let (range, slider) = match param.kind {
                ParamKind::Number { range, slider } => (range, slider),
                ParamKind::Integer { range, slider } => {
                    ((range.0 as f64, range.1 as f64), (slider.0 as f64, slider.1 as f64))
                }
                _ => continue,
            };
            let name = &param.name;
            let finite = [range.0, range.1, slider.0, slider.1].iter().all(|end| end.is_finite());
            complain(&mut complaints, finite, &format!("`{name}` has an infinite limit"));
            complain(&mut complaints, range.0 < range.1, &format!("`{name}` has an empty range"));
            let inside = range.0 <= slider.0 && slider.0 < slider.1 && slider.1 <= range.1;
            complain(&mut complaints, inside, &format!("`{name}` has a slider outside its range"));
        }
        if let Err(error) = node.instantiate(&defaults(node)) {
            complaints.push(format!("the defaults: {error}"));
        }
        complaints
    });
}

#[test]
fn specs_and_settings_survive_a_file() {
    sweep(|node| {
        let text = ron::to_string(node.spec()).unwrap();
        let back: NodeSpec = ron::from_str(&text).unwrap();
        let values = ron::to_string(&defaults(node)).unwrap();
        let values: Vec<ParamValue> = ron::from_str(&values).unwrap();
        let mut complaints = Vec::new();
        complain(&mut complaints, back == *node.spec(), "its spec does not survive a file");
        complain(&mut complaints, values == defaults(node), "its settings do not survive a file");
        complaints
    });
}

#[test]
fn a_change_of_any_parameter_changes_the_key() {
    sweep(|node| {
        let mut complaints = Vec::new();
        for (index, param) in node.spec().params.iter().enumerate() {
            let mut values = defaults(node);
            values[index] = nudged(param);
            let differs = key(&values) != key(&defaults(node));
            complain(&mut complaints, differs, &format!("`{}` does not count in the key", param.name));
        }
        complaints
    });
}

#[test]
fn values_beyond_the_range_are_refused() {
    sweep(|node: &NodeType| {
        let mut complaints = Vec::new();
        for (index, param) in node.spec().params.iter().enumerate() {
            let bad = match &param.kind {
                ParamKind::Number { range, .. } => {
                    [range.0.next_down(), range.1.next_up(), f64::NAN, f64::INFINITY]
                        .map(ParamValue::Number)
                        .to_vec()
                }
                ParamKind::Integer { range, .. } => {
                    [range.0 - 1, range.1 + 1].map(ParamValue::Integer).to_vec()
                }
                ParamKind::Choice { .. } => vec![ParamValue::Text("no such option".into())],
                ParamKind::OutputPath => ["", "../x.png", "/x.png", "C:x.png", "a/../../x"]
                    .map(|p| ParamValue::Text(p.into()))
                    .to_vec(),
                _ => continue,
            };
            for bad in bad {
                let mut values = defaults(node);
                values[index] = bad.clone();
                let refused = node.instantiate(&values).is_err();
                complain(&mut complaints, refused, &format!("`{}` takes {bad:?}", param.name));
            }
        }
        complaints
    });
}

fn complain(complaints: &mut Vec<String>, holds: bool, complaint: &str) {
    if !holds {
        complaints.push(complaint.to_owned());
    }
}

fn is_snake_case(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn key(values: &[ParamValue]) -> orograph_core::Digest {
    let mut hasher = Hasher::new("contract");
    values.iter().for_each(|value| value.feed(&mut hasher));
    hasher.finish()
}

/// Another valid value than the default.
fn nudged(param: &ParamSpec) -> ParamValue {
    match (&param.kind, &param.default) {
        (ParamKind::Number { range, .. }, ParamValue::Number(x)) => {
            ParamValue::Number(if *x < range.1 { (x + range.1) / 2.0 } else { (x + range.0) / 2.0 })
        }
        (ParamKind::Integer { range, .. }, ParamValue::Integer(i)) => {
            ParamValue::Integer(if *i < range.1 { i + 1 } else { i - 1 })
        }
        (ParamKind::Choice { options }, ParamValue::Text(text)) => {
            let other = options.iter().find(|option| option.name != *text);
            ParamValue::Text(other.map_or_else(|| "another".into(), |option| option.name.to_string()))
        }
        (_, ParamValue::Boolean(b)) => ParamValue::Boolean(!b),
        (_, ParamValue::Text(text)) => ParamValue::Text(format!("{text}x")),
        (_, ParamValue::Curve(points)) => {
            let mut points = points.clone();
            points[0][1] += 1e-3;
            ParamValue::Curve(points)
        }
        (_, ParamValue::Lines(lines)) => {
            let mut lines = lines.clone();
            lines.push(vec![[0.0; 3]]);
            ParamValue::Lines(lines)
        }
        (_, other) => other.clone(),
    }
}
