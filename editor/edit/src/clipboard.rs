//! Nodes as text: what is copied is a graph by itself, which a text editor, a message or another window can hold.

use indexmap::IndexMap;
use orograph_engine::{
    Document, Registry,
    document::{Bend, DocumentErrors, Link},
};

use crate::operations::free_name;

/// The text of `names`, with the wires and positions among them.
#[must_use]
pub fn copy(document: &Document, names: &[&str], registry: &Registry) -> String {
    let mut part = document.clone();
    let kept = |name: &String| names.contains(&name.as_str());
    part.doc.clear();
    part.expose.clear();
    part.inputs.clear();
    part.outputs.clear();
    part.nodes.retain(|name, _| kept(name));
    part.layout.nodes.retain(|name, _| kept(name));
    part.layout.frames.clear();
    part.layout.comments.clear();
    part.layout.bends.retain(|bend| kept(&bend.from.node) && kept(&bend.to.node));
    part.to_ron(registry)
}

/// Adds the nodes of a text to the document, under free names. Wires among them follow; wires from others are kept
/// where the document has such a node. The nodes stand as they stood to each other, the first corner at `at`.
///
/// # Errors
/// When the text is no graph.
pub fn paste(document: &mut Document, text: &str, at: (f64, f64)) -> Result<Vec<String>, DocumentErrors> {
    let pasted = Document::parse(text, "clipboard")?;
    let mut names: IndexMap<String, String> = IndexMap::new();
    let before: Vec<String> = document.nodes.keys().cloned().collect();
    for (name, node) in &pasted.nodes {
        let free = free_name(document, name);
        document.nodes.insert(free.clone(), node.clone());
        names.insert(name.clone(), free);
    }
    for name in names.values() {
        let Some(node) = document.nodes.get_mut(name) else { continue };
        for links in node.inputs.values_mut() {
            links.retain_mut(|link| match names.get(&link.node) {
                Some(renamed) => {
                    *link = Link::new(renamed.clone(), link.port.clone());
                    true
                }
                None => before.contains(&link.node),
            });
        }
        node.inputs.retain(|_, links| !links.is_empty());
    }
    let corner = pasted.layout.nodes.values().copied().reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)));
    let corner = corner.unwrap_or_default();
    for (index, (old, new)) in names.iter().enumerate() {
        let step = 24.0 * index as f64;
        let place = pasted.layout.nodes.get(old).copied().unwrap_or((corner.0 + step, corner.1 + step));
        document.layout.nodes.insert(new.clone(), (place.0 - corner.0 + at.0, place.1 - corner.1 + at.1));
    }
    for bend in &pasted.layout.bends {
        let renamed =
            |link: &Link| names.get(&link.node).map(|name| Link::new(name.clone(), link.port.clone()));
        if let (Some(from), Some(to)) = (renamed(&bend.from), renamed(&bend.to)) {
            let moved = |(x, y): &(f64, f64)| (x - corner.0 + at.0, y - corner.1 + at.1);
            document.layout.bends.push(Bend {
                from,
                to,
                through: bend.through.iter().map(moved).collect(),
                extra: bend.extra.clone(),
            });
        }
    }
    Ok(names.into_values().collect())
}
