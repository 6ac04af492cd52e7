//! The edits that gestures stand for, each a function on a document.

use indexmap::{IndexMap, IndexSet};
use orograph_core::{Arity, NodeType, ValueType};
use orograph_engine::{
    Document,
    document::{Bend, Exposed, Frame, GRAPH, Layout, Link, Literal, Node, is_name},
};

use crate::{Interfaces, Kind};

/// An edit that was not made, and the mend.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}: {help}")]
pub struct Refused {
    /// Why.
    pub message: String,
    /// What would mend it.
    pub help: String,
    /// Node types that could stand between the two ends of a refused wire.
    pub converters: Vec<String>,
}

impl Refused {
    /// A refusal in words.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), converters: Vec::new() }
    }
}

/// `base`, or it with the first number from 2 on that is not taken.
pub(crate) fn free(base: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|n| format!("{base}_{n}"));
    std::iter::once(base.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}

/// A name like `base` that no node of the document has.
#[must_use]
pub fn free_name(document: &Document, base: &str) -> String {
    let taken = |name: &str| name == GRAPH || document.nodes.contains_key(name);
    let stem = base.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
    let stem = if is_name(stem) { stem } else { "node" };
    if is_name(base) && !taken(base) {
        return base.to_owned();
    }
    free(stem, |name| name == stem || taken(name))
}

/// Adds a node of a type and gives its name.
pub fn add(document: &mut Document, node_type: &NodeType, at: (f64, f64)) -> String {
    let spec = node_type.spec();
    let algorithm = spec.id.rsplit('.').next().unwrap_or("node");
    let name = free_name(document, algorithm);
    document.nodes.insert(name.clone(), Node::of_type(spec.id.to_string(), spec.version));
    document.layout.nodes.insert(name.clone(), at);
    name
}

/// Adds a node that is the graph in the file `path`, relative to the document's folder.
pub fn add_graph(document: &mut Document, path: &str, at: (f64, f64)) -> String {
    let stem = path.rsplit('/').next().unwrap_or(path).split('.').next().unwrap_or("graph");
    let name = free_name(document, &stem.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_"));
    document.nodes.insert(name.clone(), Node::of_graph(path));
    document.layout.nodes.insert(name.clone(), at);
    name
}

/// Lays a wire from an output to an input. An input that takes one wire gives up the one that it has.
///
/// # Errors
/// When the types differ, with node types that convert; when there is no such port; when it would close a cycle.
pub fn connect(
    document: &mut Document,
    interfaces: &mut Interfaces,
    from: &Link,
    to: &Link,
) -> Result<(), Refused> {
    let (from_type, to_type, arity) = ends(document, interfaces, from, to)?;
    if let (Some(from_type), Some(to_type)) = (from_type, to_type)
        && from_type != to_type
    {
        let converters = interfaces.registry().converters(from_type, to_type);
        let converters: Vec<_> = converters.iter().map(|spec| spec.id.to_string()).collect();
        let help = match converters.first() {
            Some(first) => format!("put a node between them, such as {first}"),
            None => format!("wire an output that gives a {to_type}"),
        };
        let message = format!("`{from}` gives a {from_type}, `{to}` takes a {to_type}");
        return Err(Refused { message, help, converters });
    }
    if from.node == to.node || depends_on(document, &from.node, &to.node) {
        return Err(Refused::new(
            format!("`{}` needs what `{}` gives: the wire would close a cycle", from.node, to.node),
            "take one of the wires on it away first",
        ));
    }
    let Some(node) = document.nodes.get_mut(&to.node) else { return Ok(()) };
    let links = node.inputs.entry(to.port.clone()).or_default();
    match arity {
        Arity::Many if links.contains(from) => {}
        Arity::Many => links.push(from.clone()),
        Arity::One | Arity::Optional => *links = vec![from.clone()],
    }
    Ok(())
}

type Ends = (Option<ValueType>, Option<ValueType>, Arity);

fn ends(document: &Document, interfaces: &mut Interfaces, from: &Link, to: &Link) -> Result<Ends, Refused> {
    let mut look = |name: &str| match document.nodes.get(name) {
        Some(node) => Ok(interfaces.of(name, node, document)),
        None => Err(Refused::new(format!("there is no node `{name}`"), "add it first")),
    };
    let no_port = |link: &Link, kind| {
        Refused::new(format!("`{}` has no {kind} `{}`", link.node, link.port), "wire one that it has")
    };
    let source = look(&from.node)?;
    let from_type = match (source.output(&from.port), &source.kind) {
        (Some(port), _) => port.value_type,
        (None, Kind::Unknown(_)) => None,
        (None, _) => return Err(no_port(from, "output")),
    };
    let target = look(&to.node)?;
    match (target.input(&to.port), &target.kind) {
        (Some(port), _) => Ok((from_type, port.value_type, port.arity)),
        (None, Kind::Unknown(_)) => Ok((from_type, None, Arity::Many)),
        (None, _) => Err(no_port(to, "input")),
    }
}

/// Whether the node `name` needs, through any number of wires, the node `other`.
#[must_use]
pub fn depends_on(document: &Document, name: &str, other: &str) -> bool {
    let mut seen = IndexSet::from([name]);
    let mut next = 0;
    while let Some(&name) = seen.get_index(next) {
        next += 1;
        if name == other {
            return true;
        }
        let inputs = document.nodes.get(name).into_iter().flat_map(|node| node.inputs.values().flatten());
        seen.extend(inputs.map(|link| link.node.as_str()));
    }
    false
}

/// The nodes that `names` need, themselves among them, in the document's order.
#[must_use]
pub fn upstream<'d>(document: &'d Document, names: impl IntoIterator<Item = &'d str>) -> IndexSet<&'d str> {
    let mut seen: IndexSet<&str> = names.into_iter().collect();
    let mut next = 0;
    while let Some(&name) = seen.get_index(next) {
        next += 1;
        let inputs = document.nodes.get(name).into_iter().flat_map(|node| node.inputs.values().flatten());
        seen.extend(inputs.map(|link| link.node.as_str()).filter(|name| *name != GRAPH));
    }
    document.nodes.keys().map(String::as_str).filter(|name| seen.contains(name)).collect()
}

/// The part of the document that `names` need, without its outputs: what else is wrong with it does not matter there.
#[must_use]
pub fn part(document: &Document, names: &[&str]) -> Document {
    let kept = upstream(document, names.iter().copied());
    let mut part = document.clone();
    part.nodes.retain(|name, _| kept.contains(name.as_str()));
    part.outputs.clear();
    part.expose.retain(|_, exposed| kept.contains(exposed.param.node.as_str()));
    part.layout = Layout::default();
    // Fields of a newer format change nothing that this one knows of.
    part.extra.clear();
    part.expose.values_mut().for_each(|exposed| exposed.extra.clear());
    part.inputs.values_mut().for_each(|input| input.extra.clear());
    part
}

/// Puts a node of a type between two ends whose types differ.
///
/// # Errors
/// As [`connect`], and when the type converts nothing of the kind.
pub fn connect_through(
    document: &mut Document,
    interfaces: &mut Interfaces,
    id: &str,
    from: &Link,
    to: &Link,
) -> Result<String, Refused> {
    let (from_type, to_type, _) = ends(document, interfaces, from, to)?;
    let node_type = interfaces.registry().get(id).cloned();
    let Some(node_type) = node_type else {
        return Err(Refused::new(format!("there is no node type `{id}`"), "choose another"));
    };
    let spec = node_type.spec();
    let input = spec.inputs.iter().find(|port| Some(port.value_type) == from_type);
    let output = spec.outputs.iter().find(|port| Some(port.value_type) == to_type);
    let (Some(input), Some(output)) = (input, output) else {
        return Err(Refused::new(format!("`{id}` does not turn the one into the other"), "choose another"));
    };
    let place = |name: &str| document.layout.nodes.get(name).copied().unwrap_or_default();
    let ((x0, y0), (x1, y1)) = (place(&from.node), place(&to.node));
    let name = add(document, &node_type, (f64::midpoint(x0, x1), f64::midpoint(y0, y1)));
    connect(document, interfaces, from, &Link::new(name.clone(), input.name.to_string()))?;
    connect(document, interfaces, &Link::new(name.clone(), output.name.to_string()), to)?;
    Ok(name)
}

/// Takes a wire away.
pub fn disconnect(document: &mut Document, from: &Link, to: &Link) {
    let Some(node) = document.nodes.get_mut(&to.node) else { return };
    let Some(links) = node.inputs.get_mut(&to.port) else { return };
    links.retain(|link| link != from);
    if links.is_empty() {
        node.inputs.shift_remove(&to.port);
    }
}

/// Removes nodes with their wires, named outputs and exposed parameters.
pub fn remove(document: &mut Document, names: &[&str]) {
    document.nodes.retain(|name, _| !names.contains(&name.as_str()));
    document.layout.nodes.retain(|name, _| !names.contains(&name.as_str()));
    let gone = |link: &Link| names.contains(&link.node.as_str());
    document.outputs.retain(|_, link| !gone(link));
    document.expose.retain(|_, exposed| !gone(&exposed.param));
    for node in document.nodes.values_mut() {
        for links in node.inputs.values_mut() {
            links.retain(|link| !gone(link));
        }
        node.inputs.retain(|_, links| !links.is_empty());
    }
}

/// Removes a node and joins what came in to what went out, as far as its bypass would.
pub fn dissolve(document: &mut Document, interfaces: &mut Interfaces, name: &str) {
    let Some(node) = document.nodes.get(name) else { return };
    let interface = interfaces.of(name, node, document);
    let passed: IndexMap<String, Vec<Link>> = interface
        .outputs
        .iter()
        .filter_map(|output| {
            let input = interface.inputs.iter().find(|input| input.value_type == output.value_type)?;
            Some((output.name.clone(), node.inputs.get(&input.name)?.clone()))
        })
        .collect();
    for node in document.nodes.values_mut() {
        for links in node.inputs.values_mut() {
            *links = replaced(links, name, &passed);
        }
    }
    for link in document.outputs.values_mut().filter(|link| link.node == name) {
        if let Some(source) = passed.get(&link.port).and_then(|links| links.first()) {
            *link = source.clone();
        }
    }
    remove(document, &[name]);
}

fn replaced(links: &[Link], name: &str, passed: &IndexMap<String, Vec<Link>>) -> Vec<Link> {
    let of = |link: &Link| match passed.get(&link.port).filter(|_| link.node == name) {
        Some(sources) => sources.clone(),
        None => vec![link.clone()],
    };
    let links: IndexSet<Link> = links.iter().flat_map(of).collect();
    links.into_iter().collect()
}

/// Gives a node another name, everywhere.
///
/// # Errors
/// When that is no name, or taken.
pub fn rename(document: &mut Document, old: &str, new: &str) -> Result<(), Refused> {
    if old == new {
        return Ok(());
    }
    if !is_name(new) || new == GRAPH {
        return Err(Refused::new(
            format!("`{new}` is no name"),
            "a name starts with a letter and has letters, digits, `_` and `-` alone",
        ));
    }
    if document.nodes.contains_key(new) {
        return Err(Refused::new(format!("there is a node `{new}` already"), "choose another name"));
    }
    rename_key(&mut document.nodes, old, new);
    rename_key(&mut document.layout.nodes, old, new);
    let inputs = document.nodes.values_mut().flat_map(|node| node.inputs.values_mut().flatten());
    let exposed = document.expose.values_mut().map(|exposed| &mut exposed.param);
    let bent = document.layout.bends.iter_mut().flat_map(|bend| [&mut bend.from, &mut bend.to]);
    let links = inputs.chain(document.outputs.values_mut()).chain(exposed).chain(bent);
    for link in links.filter(|link| link.node == old) {
        link.node = new.to_owned();
    }
    Ok(())
}

fn rename_key<T>(map: &mut IndexMap<String, T>, old: &str, new: &str) {
    if let Some((index, _, value)) = map.shift_remove_full(old) {
        map.shift_insert(index, new.to_owned(), value);
    }
}

/// Sets a parameter, or with `None` takes its setting away, so that the default holds.
///
/// # Errors
/// When there is no such node.
pub fn set_param(
    document: &mut Document,
    node: &str,
    param: &str,
    value: Option<Literal>,
) -> Result<(), Refused> {
    let Some(node) = document.nodes.get_mut(node) else {
        return Err(Refused::new(format!("there is no node `{node}`"), "choose one that is there"));
    };
    match value {
        Some(value) => {
            node.params.insert(param.to_owned(), value);
        }
        None => {
            node.params.shift_remove(param);
        }
    }
    Ok(())
}

/// Makes a parameter one of the graph as a whole, by a name that it does not yet use.
pub fn expose(document: &mut Document, param: Link) -> String {
    let taken = |name: &str| document.expose.contains_key(name);
    let name = match taken(&param.port) {
        false => param.port.clone(),
        true => free(&format!("{}_{}", param.node, param.port), taken),
    };
    document.expose.insert(name.clone(), Exposed { param, ..Exposed::default() });
    name
}

/// Makes an output one of the graph as a whole, by a name that it does not yet use.
pub fn add_output(document: &mut Document, output: Link) -> String {
    let name = free(&output.port, |name| document.outputs.contains_key(name));
    document.outputs.insert(name.clone(), output);
    name
}

/// Bypasses all of `names`, or none of them when all are bypassed.
pub fn toggle_bypass(document: &mut Document, names: &[&str]) {
    let all = names.iter().filter_map(|name| document.nodes.get(*name)).all(|node| node.bypass);
    for name in names {
        if let Some(node) = document.nodes.get_mut(*name) {
            node.bypass = !all;
        }
    }
}

/// Whether there is such a wire.
#[must_use]
pub fn has_wire(document: &Document, from: &Link, to: &Link) -> bool {
    let links = document.nodes.get(&to.node).and_then(|node| node.inputs.get(&to.port));
    links.is_some_and(|links| links.contains(from))
}

/// Leads a wire through these places and no others.
pub fn bend(document: &mut Document, from: &Link, to: &Link, through: Vec<(f64, f64)>) {
    let bends = &mut document.layout.bends;
    match bends.iter_mut().find(|bend| bend.from == *from && bend.to == *to) {
        Some(bend) => bend.through = through,
        None => bends.push(Bend { from: from.clone(), to: to.clone(), through, ..Bend::default() }),
    }
    bends.retain(|bend| !bend.through.is_empty());
}

/// Forgets the bends of wires that are gone.
pub(crate) fn forget_bends(document: &mut Document) {
    let mut bends = std::mem::take(&mut document.layout.bends);
    bends.retain(|bend| has_wire(document, &bend.from, &bend.to));
    document.layout.bends = bends;
}

/// Puts a titled frame around the rectangle `min`–`max` that holds nodes.
pub fn frame(document: &mut Document, title: &str, min: (f64, f64), max: (f64, f64)) {
    const MARGIN: f64 = 24.0;
    const TITLE: f64 = 28.0;
    let (x, y) = (min.0 - MARGIN, min.1 - MARGIN - TITLE);
    let (width, height) = (max.0 - min.0 + 2.0 * MARGIN, max.1 - min.1 + 2.0 * MARGIN + TITLE);
    document.layout.frames.push(Frame {
        title: title.to_owned(),
        rect: (x, y, width, height),
        ..Frame::default()
    });
}
