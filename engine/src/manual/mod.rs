//! The manual of node types, written from their specs, and what illustrates them.

mod book;
mod terminal;

use std::fmt::Write;

use orograph_core::{Arity, ContextItem, Extent, NodeSpec, ParamKind, ParamSpec, PortSpec};

use crate::document::{Link, Literal, Node, node_ron};

pub use book::{Illustration, book, page_name};
pub use terminal::terminal_page;

/// The traits, ports and parameters of a node type, in Markdown.
fn facts(spec: &NodeSpec) -> String {
    let mut page = format!("{}\n\n", traits(spec).join(" "));
    ports(&mut page, "Input", &spec.inputs);
    ports(&mut page, "Output", &spec.outputs);
    if !spec.params.is_empty() {
        page.push_str("| Parameter | Type | Unit | Range | Default | |\n|---|---|---|---|---|---|\n");
        for param in &spec.params {
            let _ = writeln!(
                page,
                "| `{}` | {} | {} | {} | {} | {} |",
                param.name,
                kind(param),
                unit(param),
                range(param),
                code(&default(param)),
                cell(&param.doc)
            );
        }
        page.push('\n');
        for param in &spec.params {
            let ParamKind::Choice { options } = &param.kind else { continue };
            let _ = writeln!(page, "Options of `{}`:\n", param.name);
            for option in options {
                let _ = writeln!(page, "- `{}`: {}", option.name, one_line(&option.doc));
            }
            page.push('\n');
        }
    }
    let _ = write!(page, "With every parameter at its default:\n\n```ron\n{}```\n", example(spec));
    page
}

/// The node in a graph file, with every parameter at its default.
#[must_use]
pub fn example(spec: &NodeSpec) -> String {
    let mut node = Node::of_type(spec.id.clone(), spec.version);
    for param in &spec.params {
        node.params.insert(param.name.to_string(), Literal::from(&param.default));
    }
    for input in spec.inputs.iter().filter(|input| input.arity != Arity::Optional) {
        node.inputs.insert(input.name.to_string(), vec![Link::new("other", input.name.clone())]);
    }
    node_ron(spec.id.split('.').next_back().unwrap_or(&spec.id), &node)
}

/// What the engine makes of the node, in sentences.
fn traits(spec: &NodeSpec) -> Vec<String> {
    let mut sentences = vec![format!("Version {}.", spec.version)];
    sentences.push(
        match spec.extent {
            Extent::Local => "Each output cell depends on nearby input cells alone.",
            Extent::MultiResolution => "It works on a pyramid of resolutions.",
            Extent::Global => "Any cell may depend on any other.",
        }
        .into(),
    );
    for item in &spec.reads {
        sentences.push(
            match item {
                ContextItem::Seed => "It reads the run's seed.",
                ContextItem::Resolution => "It reads the run's resolution.",
            }
            .into(),
        );
    }
    if spec.writes {
        sentences.push("It writes files.".into());
    }
    if let (true, Some(input)) = (spec.default_writer, spec.inputs.first()) {
        sentences.push(format!("It writes a {} when a run asks for one by name.", input.value_type));
    }
    sentences
}

fn ports(page: &mut String, title: &str, ports: &[PortSpec]) {
    if ports.is_empty() {
        return;
    }
    let _ = write!(page, "| {title} | Type | |\n|---|---|---|\n");
    for port in ports {
        let (name, value_type) = (&port.name, port.value_type);
        let _ = writeln!(page, "| `{name}` | {value_type}{} | {} |", wires(port.arity), cell(&port.doc));
    }
    page.push('\n');
}

fn wires(arity: Arity) -> &'static str {
    match arity {
        Arity::One => "",
        Arity::Optional => ", optional",
        Arity::Many => ", any number",
    }
}

fn kind(param: &ParamSpec) -> &'static str {
    match param.kind {
        ParamKind::Number { .. } => "number",
        ParamKind::Integer { .. } => "integer",
        ParamKind::Boolean => "boolean",
        ParamKind::Text => "text",
        ParamKind::Choice { .. } => "choice",
        ParamKind::InputPath => "file to read",
        ParamKind::OutputPath => "file to write",
        ParamKind::Colour => "colour",
        ParamKind::Gradient => "gradient",
        ParamKind::Curve { .. } => "curve of (x, y)",
        ParamKind::Lines { .. } => "lines of (x, y, height)",
        _ => "value",
    }
}

/// The unit, for numbers that have one.
fn unit(param: &ParamSpec) -> &'static str {
    match param.unit {
        orograph_core::Unit::One | orograph_core::Unit::Seed => "",
        unit => unit.symbol(),
    }
}

fn range(param: &ParamSpec) -> String {
    match &param.kind {
        ParamKind::Number { range: (low, high), .. } => format!("{low:?} to {high:?}"),
        ParamKind::Integer { range: (low, high), .. } => format!("{low} to {high}"),
        ParamKind::Curve { x, y } => format!("x {:?} to {:?}, y {:?} to {:?}", x.0, x.1, y.0, y.1),
        ParamKind::Lines { range: (low, high) } => format!("{low:?} to {high:?}"),
        _ => String::new(),
    }
}

fn default(param: &ParamSpec) -> String {
    Literal::from(&param.default).to_ron()
}

fn code(text: &str) -> String {
    format!("`{}`", text.replace('|', "\\|").replace('`', "'"))
}

/// Text for a cell of a table.
fn cell(text: &str) -> String {
    one_line(text).replace('|', "\\|")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
