//! The whole manual as files: a page for each node type, an index for each family, and one over all.

use std::{collections::BTreeMap, fmt::Write};

use orograph_core::NodeSpec;

use super::{cell, facts};
use crate::Registry;

/// A small graph that shows what a node type does, and what a run of it gave. Its picture lies beside the page.
#[derive(Clone, Debug)]
pub struct Illustration {
    /// What the graph says that it shows.
    pub doc: String,
    /// The graph as it stands in its file.
    pub graph: String,
    /// Where the file lies, seen from the page.
    pub link: String,
    /// The tables that the graph names and their contents in Markdown.
    pub tables: Vec<(String, String)>,
}

/// Family and name of a node type, as its page and, with another ending, its picture are called.
#[must_use]
pub fn page_name(spec: &NodeSpec, ending: &str) -> String {
    let (family, node) = spec.id.split_once('.').unwrap_or(("other", &spec.id));
    format!("{family}/{}.{ending}", node.replace('.', "-"))
}

/// The manual as files: `index.md`, an index for each family, and a page for each node, with what illustrates it.
#[must_use]
pub fn book(registry: &Registry, illustrations: &BTreeMap<String, Illustration>) -> Vec<(String, String)> {
    let mut families: BTreeMap<&str, Vec<&NodeSpec>> = BTreeMap::new();
    for node_type in registry.iter() {
        families.entry(node_type.spec().family()).or_default().push(node_type.spec());
    }
    let mut index = String::from("# Nodes\n");
    let mut files = Vec::new();
    for (family, specs) in &families {
        let _ = write!(index, "\n## [{family}]({family}/index.md)\n\n| Node | |\n|---|---|\n");
        let mut family_index =
            format!("# {family}\n\n[All nodes](../index.md)\n\n| Node | | |\n|---|---|---|\n");
        for spec in specs {
            let page = page_name(spec, "md");
            let file = page.rsplit('/').next().unwrap_or_default();
            let summary = cell(&spec.summary());
            let _ = writeln!(index, "| [`{}`]({page}) | {} |", spec.id, linked(&summary, registry, "", None));
            let _ = writeln!(
                family_index,
                "| [`{}`]({file}) | {} | {} |",
                spec.id,
                linked(&summary, registry, "../", None),
                illustrations.get(&*spec.id).map_or_else(String::new, |_| thumbnail(file))
            );
            files.push((page, node_file(spec, illustrations.get(&*spec.id), registry)));
        }
        files.push((format!("{family}/index.md"), family_index));
    }
    files.insert(0, ("index.md".into(), index));
    files
}

/// The page of one node type.
fn node_file(spec: &NodeSpec, illustration: Option<&Illustration>, registry: &Registry) -> String {
    let mut page = format!("# {}\n\n{}\n\n", spec.id, spec.doc.trim());
    if let Some(Illustration { doc, link, tables, .. }) = illustration {
        let name = page_name(spec, "png");
        let picture = name.rsplit('/').next().unwrap_or_default();
        let _ =
            write!(page, "![{}]({picture})\n\n{doc} ([the graph]({link}))\n\n", doc.trim_end_matches('.'));
        for (name, table) in tables {
            let _ = write!(page, "Its table `{name}`:\n\n{table}\n");
        }
    }
    page.push_str(&facts(spec));
    // Only prose is linked: what stands in code is to be copied.
    let mut page = linked(&page, registry, "../", Some(&spec.id));
    if let Some(Illustration { graph, .. }) = illustration {
        let _ = write!(page, "\n## The graph of the picture\n\n```ron\n{}\n```\n", graph.trim_end());
    }
    let _ = write!(page, "\n[{}](index.md) · [all nodes](../index.md)\n", spec.family());
    page
}

fn thumbnail(page: &str) -> String {
    let picture = page.trim_end_matches(".md");
    format!("<a href=\"{page}\"><img src=\"{picture}.png\" width=\"180\" alt=\"\"></a>")
}

/// The text with the names of node types, where they stand as code, made links to their pages; `own` is the page's.
fn linked(text: &str, registry: &Registry, up: &str, own: Option<&str>) -> String {
    let mut out = String::with_capacity(text.len());
    // Every second part stands between backticks; blocks of code have three, which leave empty parts.
    for (i, part) in text.split('`').enumerate() {
        match registry.get(part) {
            Some(node_type) if i % 2 == 1 && own != Some(part) => {
                let _ = write!(out, "[`{part}`]({up}{})", page_name(node_type.spec(), "md"));
            }
            _ if i % 2 == 1 => {
                let _ = write!(out, "`{part}`");
            }
            _ => out.push_str(part),
        }
    }
    out
}
