//! `orograph graph`: a graph for other programs to draw or compare.

use std::fmt::Write;

use orograph_engine::{Document, Graph};

use crate::{arguments::GraphOptions, console, failure::Failure, session};

pub(crate) fn run(options: &GraphOptions) -> Result<(), Failure> {
    if options.ron {
        let document = Document::load(&options.settings.graph)?;
        console::result(document.to_ron(&session::registry(&options.plugins, None)?).trim_end());
        return Ok(());
    }
    let compiled = session::load(&options.settings, &session::registry(&options.plugins, None)?)?;
    console::result(dot(&compiled.graph).trim_end());
    Ok(())
}

/// The graph in Graphviz's language; nodes of a subgraph stand in a box.
fn dot(graph: &Graph) -> String {
    let mut text = String::from("digraph {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n");
    let quote = |name: &str| format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""));
    for node in graph.nodes() {
        let id = node.spec().map_or("unknown", |spec| spec.id.as_ref());
        let style = if node.spec().is_none() { ", style=dashed" } else { "" };
        let label = quote(&format!("{}\n{id}", node.name)).replace('\n', "\\n");
        // Writing into a string cannot fail.
        let _ = writeln!(text, "  {} [label={label}{style}];", quote(&node.name));
    }
    for node in graph.nodes() {
        let ports = node.spec().map(|spec| spec.inputs.as_slice()).unwrap_or_default();
        for (port, wires) in node.inputs.iter().enumerate() {
            let to = ports.get(port).map_or("", |port| port.name.as_ref());
            for wire in wires {
                let source = graph.node(wire.node);
                let from = graph.output_name(*wire);
                let from = from.rsplit_once('.').map_or("", |(_, port)| port);
                let _ = writeln!(
                    text,
                    "  {} -> {} [taillabel={}, headlabel={}];",
                    quote(&source.name),
                    quote(&node.name),
                    quote(from),
                    quote(to)
                );
            }
        }
    }
    text.push_str("}\n");
    text
}
