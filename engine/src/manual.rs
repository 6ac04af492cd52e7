//! The manual of node types, written from their specs alone.

use std::{collections::BTreeMap, fmt::Write};

use orograph_core::{Arity, ContextItem, Extent, NodeSpec, ParamKind, ParamSpec, PortSpec};

use crate::{
    Registry,
    document::{Link, Literal, Node, node_ron},
};

/// The page of one node type, in Markdown under a heading of level 2.
#[must_use]
pub fn node_page(spec: &NodeSpec) -> String {
    let mut page = format!("## {}\n\n{}\n\n", spec.id, spec.doc.trim());
    let _ = writeln!(page, "{}\n", traits(spec).join(" "));
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
    let _ = write!(page, "```ron\n{}```\n", example(spec));
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

/// The page of one node type as plain text for a terminal.
#[must_use]
pub fn terminal_page(spec: &NodeSpec) -> String {
    let mut page = format!("{} (version {})\n\n{}\n", spec.id, spec.version, spec.doc.trim());
    let _ = writeln!(page, "\n{}", traits(spec).join("\n"));
    for (title, ports) in [("Inputs", &spec.inputs), ("Outputs", &spec.outputs)] {
        if ports.is_empty() {
            continue;
        }
        let _ = writeln!(page, "\n{title}");
        let width = ports.iter().map(|port| port.name.len()).max().unwrap_or(0);
        for port in ports {
            let _ = writeln!(page, "  {:width$}  {}{}", port.name, port.value_type, wires(port.arity));
            let _ = writeln!(page, "  {:width$}  {}", "", one_line(&port.doc));
        }
    }
    if !spec.params.is_empty() {
        page.push_str("\nParameters\n");
        let width = spec.params.iter().map(|param| param.name.len()).max().unwrap_or(0);
        for param in &spec.params {
            let mut facts = kind(param).to_owned();
            for (label, fact) in
                [(" in ", unit(param)), (", ", &range(param)), (", default ", &default(param))]
            {
                if !fact.is_empty() {
                    let _ = write!(facts, "{label}{fact}");
                }
            }
            let _ = writeln!(page, "  {:width$}  {facts}", param.name);
            let _ = writeln!(page, "  {:width$}  {}", "", one_line(&param.doc));
            if let ParamKind::Choice { options } = &param.kind {
                for option in options {
                    let _ = writeln!(page, "  {:width$}    {}: {}", "", option.name, one_line(&option.doc));
                }
            }
        }
    }
    let _ = write!(page, "\nIn a graph\n{}", example(spec));
    page
}

/// The whole manual as files: `index.md` and one file for each family.
#[must_use]
pub fn book(registry: &Registry) -> Vec<(String, String)> {
    let mut families: BTreeMap<&str, Vec<&NodeSpec>> = BTreeMap::new();
    for node_type in registry.iter() {
        families.entry(node_type.spec().family()).or_default().push(node_type.spec());
    }
    let mut index = String::from("# Nodes\n");
    let mut files = Vec::new();
    for (family, specs) in &families {
        let _ = write!(index, "\n## [{family}]({family}.md)\n\n| Node | |\n|---|---|\n");
        let mut pages = format!("# {family}\n");
        for spec in specs {
            let anchor = spec.id.replace('.', "");
            let _ = writeln!(index, "| [`{}`]({family}.md#{anchor}) | {} |", spec.id, cell(&spec.summary()));
            let _ = write!(pages, "\n{}", node_page(spec));
        }
        files.push((format!("{family}.md"), pages));
    }
    files.insert(0, ("index.md".into(), index));
    files
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
