//! Nodes folded into a graph of their own, and such a graph laid out again.

use std::path::Path;

use indexmap::IndexMap;
use orograph_core::{ParamKind, ValueType};
use orograph_engine::{
    Document,
    document::{Body, Exposed, GRAPH, GraphInput, Link, Literal, Node},
};

use crate::{
    Interfaces, Kind,
    operations::{Refused, depends_on, free, free_name, remove},
};

/// Folds `names` into a graph, which is given back and is to be saved as `path` in the document's folder before the
/// document is. The document gets one node in their place.
///
/// # Errors
/// When a wire leaves the nodes and comes back, so that one node in their place would close a cycle; when the type of
/// a wire that comes in is not known here.
pub fn collapse(
    document: &mut Document,
    interfaces: &mut Interfaces,
    names: &[&str],
    path: &str,
) -> Result<(Document, String), Refused> {
    let inside = |name: &str| names.contains(&name);
    comes_back(document, names)?;
    let mut inner = Document::new();
    let stem = path.rsplit('/').next().unwrap_or(path).split('.').next().unwrap_or("graph");
    let outer_name =
        free_name(document, &stem.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_"));
    let mut outer = Node::of_graph(path);
    for name in names {
        let Some(node) = document.nodes.get(*name) else { continue };
        let mut node = node.clone();
        for link in node.inputs.values_mut().flatten().filter(|link| !inside(&link.node)) {
            let known =
                outer.inputs.iter().find(|(_, links)| links.contains(link)).map(|(name, _)| name.clone());
            let input = match known {
                Some(input) => input,
                None => {
                    let input = free(&link.port, |name| inner.inputs.contains_key(name));
                    let value_type = type_of(document, interfaces, link)?;
                    let doc = format!("As `{link}` of the graph around.");
                    inner
                        .inputs
                        .insert(input.clone(), GraphInput { value_type, doc, extra: IndexMap::new() });
                    outer.inputs.insert(input.clone(), vec![link.clone()]);
                    input
                }
            };
            *link = Link::new(GRAPH, input);
        }
        inner.nodes.insert((*name).to_owned(), node);
        if let Some(place) = document.layout.nodes.get(*name) {
            inner.layout.nodes.insert((*name).to_owned(), *place);
        }
    }
    // From here on links to the nodes lead to the new one.
    let mut leave = |link: &mut Link| {
        if inside(&link.node) {
            let known =
                inner.outputs.iter().find(|(_, output)| *output == link).map(|(name, _)| name.clone());
            let output = known.unwrap_or_else(|| free(&link.port, |name| inner.outputs.contains_key(name)));
            inner.outputs.insert(output.clone(), link.clone());
            *link = Link::new(outer_name.clone(), output);
        }
    };
    for (_, node) in document.nodes.iter_mut().filter(|(name, _)| !inside(name)) {
        node.inputs.values_mut().flatten().for_each(&mut leave);
    }
    document.outputs.values_mut().for_each(&mut leave);
    for (name, exposed) in &mut document.expose {
        if inside(&exposed.param.node) {
            inner.expose.insert(name.clone(), exposed.clone());
            exposed.param = Link::new(outer_name.clone(), name.clone());
        }
    }
    let places = names.iter().filter_map(|name| document.layout.nodes.get(*name));
    let place = places.copied().reduce(|a, b| (a.0.min(b.0), a.1.min(b.1))).unwrap_or_default();
    remove(document, names);
    document.nodes.insert(outer_name.clone(), outer);
    document.layout.nodes.insert(outer_name.clone(), place);
    Ok((inner, outer_name))
}

fn comes_back(document: &Document, names: &[&str]) -> Result<(), Refused> {
    for (name, node) in document.nodes.iter().filter(|(name, _)| names.contains(&name.as_str())) {
        for link in node.inputs.values().flatten().filter(|link| !names.contains(&link.node.as_str())) {
            if let Some(back) = names.iter().find(|inside| depends_on(document, &link.node, inside)) {
                return Err(Refused::new(
                    format!(
                        "`{}` stands between `{back}` and `{name}`, but is not among the nodes",
                        link.node
                    ),
                    format!("choose `{}`, too", link.node),
                ));
            }
        }
    }
    Ok(())
}

fn type_of(document: &Document, interfaces: &mut Interfaces, link: &Link) -> Result<ValueType, Refused> {
    interfaces.type_of(link, document).ok_or_else(|| {
        Refused::new(format!("what `{link}` gives is not known here"), "choose nodes that do not need it")
    })
}

/// Lays the graph that stands behind the node `name` out in its place, and gives the names of its nodes.
///
/// # Errors
/// When the node is no graph or cannot be read, is bypassed, or sets what its graph does not expose.
pub fn expand(
    document: &mut Document,
    interfaces: &mut Interfaces,
    name: &str,
) -> Result<Vec<String>, Refused> {
    let Some(node) = document.nodes.get(name).cloned() else { return Ok(Vec::new()) };
    let interface = interfaces.of(name, &node, document);
    let Kind::Graph(inner) = &interface.kind else {
        return Err(Refused::new(
            format!("`{name}` is no graph that can be read"),
            "choose a node that is one",
        ));
    };
    let Body::Graph { path } = &node.body else { return Ok(Vec::new()) };
    if node.bypass {
        return Err(Refused::new(format!("`{name}` is bypassed"), "end the bypass first"));
    }
    let mut inner = (**inner).clone();
    for (param, value) in &node.params {
        let target = inner.expose.get(param).map(|exposed| exposed.param.clone());
        let Some(target) = target.filter(|target| inner.nodes.contains_key(&target.node)) else {
            return Err(Refused::new(format!("the graph exposes no `{param}`"), "take that setting away"));
        };
        if let Some(node) = inner.nodes.get_mut(&target.node) {
            node.params.insert(target.port, value.clone());
        }
    }
    let names: IndexMap<String, String> = {
        let mut names = IndexMap::new();
        let mut taken = document.clone();
        for inside in inner.nodes.keys() {
            let free = free_name(&taken, &format!("{name}_{inside}"));
            taken.nodes.insert(free.clone(), Node::of_graph(""));
            names.insert(inside.clone(), free);
        }
        names
    };
    let folder = Path::new(path).parent().filter(|folder| !folder.as_os_str().is_empty());
    let corner = inner.layout.nodes.values().copied().reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)));
    let (corner, place) =
        (corner.unwrap_or_default(), document.layout.nodes.get(name).copied().unwrap_or_default());
    for (index, (inside, mut laid)) in std::mem::take(&mut inner.nodes).into_iter().enumerate() {
        for links in laid.inputs.values_mut() {
            *links = links
                .iter()
                .flat_map(|link| match link.node == GRAPH {
                    true => node.inputs.get(&link.port).cloned().unwrap_or_default(),
                    false => vec![renamed(link, &names)],
                })
                .collect();
        }
        laid.inputs.retain(|_, links| !links.is_empty());
        if let Some(folder) = folder {
            let set_outside: Vec<&str> = node
                .params
                .keys()
                .filter_map(|param| inner.expose.get(param))
                .filter(|exposed| exposed.param.node == inside)
                .map(|exposed| exposed.param.port.as_str())
                .collect();
            move_paths(&mut laid, interfaces, folder, &set_outside);
        }
        let step = 24.0 * index as f64;
        let at = inner.layout.nodes.get(&inside).copied().unwrap_or((corner.0 + step, corner.1 + step));
        let new = &names[&inside];
        document.layout.nodes.insert(new.clone(), (place.0 + at.0 - corner.0, place.1 + at.1 - corner.1));
        document.nodes.insert(new.clone(), laid);
    }
    let sources: IndexMap<String, Vec<Link>> = inner
        .outputs
        .iter()
        .map(|(output, link)| {
            let sources = match link.node == GRAPH {
                true => node.inputs.get(&link.port).cloned().unwrap_or_default(),
                false => vec![renamed(link, &names)],
            };
            (output.clone(), sources)
        })
        .collect();
    for other in document.nodes.values_mut() {
        for links in other.inputs.values_mut() {
            *links = links
                .iter()
                .flat_map(|link| match sources.get(&link.port).filter(|_| link.node == name) {
                    Some(sources) => sources.clone(),
                    None => vec![link.clone()],
                })
                .collect();
        }
        other.inputs.retain(|_, links| !links.is_empty());
    }
    for link in document.outputs.values_mut().filter(|link| link.node == name) {
        if let Some(source) = sources.get(&link.port).and_then(|sources| sources.first()) {
            *link = source.clone();
        }
    }
    for Exposed { param, .. } in document.expose.values_mut().filter(|exposed| exposed.param.node == name) {
        if let Some(target) = inner.expose.get(&param.port) {
            *param = renamed(&target.param, &names);
        }
    }
    remove(document, &[name]);
    Ok(names.into_values().collect())
}

fn renamed(link: &Link, names: &IndexMap<String, String>) -> Link {
    let node = names.get(&link.node).unwrap_or(&link.node);
    Link::new(node.clone(), link.port.clone())
}

/// Names files relative to the folder around, as those that the outer graph had set already are.
fn move_paths(node: &mut Node, interfaces: &Interfaces, folder: &Path, set_outside: &[&str]) {
    match &mut node.body {
        Body::Graph { path } => *path = joined(folder, path),
        Body::Type { id, .. } => {
            let Some(known) = interfaces.registry().get(id) else { return };
            for param in known.spec().params.iter().filter(|param| param.kind == ParamKind::InputPath) {
                if let Some(Literal::Text(path)) = node.params.get_mut(&*param.name)
                    && !set_outside.contains(&&*param.name)
                    && !path.starts_with(['/', '$', '~'])
                {
                    *path = joined(folder, path);
                }
            }
        }
    }
}

fn joined(folder: &Path, path: &str) -> String {
    let folder = folder.to_string_lossy().replace('\\', "/");
    format!("{}/{path}", folder.trim_end_matches('/'))
}
