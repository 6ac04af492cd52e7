//! What a spec promises: names, docs, limits, defaults, keys.

use orograph_core::{Digest, Hasher, NodeSpec, NodeType, ParamKind, ParamSpec, ParamValue};

use crate::{complain, defaults};

/// Names, limits and defaults make sense, and the defaults go together.
#[must_use]
pub fn names_and_limits(node: &NodeType) -> Vec<String> {
    let mut complaints = node.spec().complaints();
    if let Err(error) = node.instantiate(&defaults(node)) {
        complaints.push(format!("the defaults: {error}"));
    }
    complaints
}

/// Everything has docs that read as sentences.
#[must_use]
pub fn docs(node: &NodeType) -> Vec<String> {
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
}

/// Spec and settings come back from a file as they were.
#[must_use]
pub fn survives_a_file(node: &NodeType) -> Vec<String> {
    let spec: Option<NodeSpec> = ron::to_string(node.spec()).ok().and_then(|text| ron::from_str(&text).ok());
    let values: Option<Vec<ParamValue>> =
        ron::to_string(&defaults(node)).ok().and_then(|text| ron::from_str(&text).ok());
    let mut complaints = Vec::new();
    complain(&mut complaints, spec.as_ref() == Some(node.spec()), "its spec does not survive a file");
    complain(&mut complaints, values == Some(defaults(node)), "its settings do not survive a file");
    complaints
}

/// A change of any parameter changes the key.
#[must_use]
pub fn keys(node: &NodeType) -> Vec<String> {
    let mut complaints = Vec::new();
    for (index, param) in node.spec().params.iter().enumerate() {
        let mut values = defaults(node);
        values[index] = nudged(param);
        let differs = key(&values) != key(&defaults(node));
        complain(&mut complaints, differs, &format!("`{}` does not count in the key", param.name));
    }
    complaints
}

/// Values beyond a hard range are refused.
#[must_use]
pub fn ranges_are_enforced(node: &NodeType) -> Vec<String> {
    let mut complaints = Vec::new();
    for (index, param) in node.spec().params.iter().enumerate() {
        let bad = match &param.kind {
            ParamKind::Number { range, .. } => {
                [range.0.next_down(), range.1.next_up(), f64::NAN, f64::INFINITY]
                    .map(ParamValue::Number)
                    .to_vec()
            }
            ParamKind::Integer { range, .. } => {
                [range.0.saturating_sub(1), range.1.saturating_add(1)].map(ParamValue::Integer).to_vec()
            }
            ParamKind::Choice { .. } => vec![ParamValue::Text("no such option".into())],
            ParamKind::OutputPath => ["", "../x.png", "/x.png", "C:x.png", "a/../../x"]
                .map(|p| ParamValue::Text(p.into()))
                .to_vec(),
            ParamKind::Colour | ParamKind::Gradient => {
                ["red", "#12", "0 #12"].map(|text| ParamValue::Text(text.into())).to_vec()
            }
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
}

fn key(values: &[ParamValue]) -> Digest {
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
        (ParamKind::Colour, ParamValue::Text(text)) => {
            ParamValue::Text(if text == "#123456" { "#654321" } else { "#123456" }.into())
        }
        (ParamKind::Gradient, ParamValue::Text(text)) => {
            ParamValue::Text(if text == "0 #123456" { "0 #654321" } else { "0 #123456" }.into())
        }
        (_, ParamValue::Text(text)) => ParamValue::Text(format!("{text}x")),
        (_, ParamValue::Curve(points)) => {
            let mut points = points.clone();
            if let Some(first) = points.first_mut() {
                first[1] += 1e-3;
            }
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
