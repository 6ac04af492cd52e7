//! The page of a node type for a terminal.

use std::fmt::Write;

use orograph_core::{NodeSpec, ParamKind};

use super::{default, example, kind, one_line, range, traits, unit, wires};

/// The page of one node type as plain text for a terminal.
#[must_use]
pub fn terminal_page(spec: &NodeSpec) -> String {
    let mut page = format!("{}\n\n{}\n", spec.id, spec.doc.trim());
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
