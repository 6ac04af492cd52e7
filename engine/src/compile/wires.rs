//! Wires: each link is followed through subgraphs and bypassed nodes to the output that feeds it.

use indexmap::{IndexMap, IndexSet};
use orograph_core::{Arity, PortSpec, ValueType};

use super::Compiler;
use crate::{
    GraphError, NodeId, OutputRef,
    document::{Body, DocumentError, GRAPH, Link, Node},
    suggest::{list, suggest},
};

/// More links than this through subgraphs and bypassed nodes, one after the other, are refused.
const MAX_TRAIL: usize = 1000;

/// An output in the flat graph.
type Source = (NodeId, String);

/// The links, each with its scope, that were followed so far.
type Trail = IndexSet<(usize, Link)>;

/// The fault was reported, or will be.
struct Reported;

impl Compiler<'_> {
    pub(super) fn connect_all(&mut self) {
        for scope in 0..self.scopes.len() {
            let document = self.scopes[scope].document.clone();
            for (name, node) in &document.nodes {
                if self.has_enough_errors() {
                    return;
                }
                match &node.body {
                    Body::Graph { .. } => self.check_subgraph(scope, name, node),
                    Body::Type { .. } => self.connect_node(scope, name, node),
                }
            }
        }
    }

    /// The wires of a node that is a graph: its ports are there and of the right type.
    fn check_subgraph(&mut self, scope: usize, name: &str, node: &Node) {
        let Some(&child) = self.scopes[scope].children.get(name) else { return };
        let (document, inner) = (self.scopes[scope].document.clone(), self.scopes[child].document.clone());
        for (port, links) in &node.inputs {
            let at = ["nodes", name, "inputs", port];
            let Some(input) = inner.inputs.get(port) else {
                let error = document.error_at_key(&at, format!("the graph `{name}` has no input `{port}`"));
                self.report(error.help(suggest(port, inner.inputs.keys().map(String::as_str), "inputs")));
                continue;
            };
            for (index, link) in links.iter().enumerate() {
                if let Some(from) = self.type_of(scope, link)
                    && from != input.value_type
                {
                    let at = ["nodes", name, "inputs", port, &index.to_string()];
                    let error = self.mismatch(link, from, &format!("{name}.{port}"), input.value_type);
                    self.report(document.error(&at, error.0).help(error.1));
                }
            }
        }
    }

    fn connect_node(&mut self, scope: usize, name: &str, node: &Node) {
        let document = self.scopes[scope].document.clone();
        let Body::Type { id, .. } = &node.body else { return };
        let spec = self.registry.get(id).map(|node_type| node_type.spec().clone());
        let target = self.scopes[scope].ids.get(name).copied();
        let is_missing = target.is_some_and(|target| self.missing.contains_key(&target));
        let spec = spec.filter(|_| !is_missing);
        let full = format!("{}{name}", self.scopes[scope].prefix);
        // Ports that something is wired to, or was meant to be.
        let mut wired = Vec::new();
        // A slip of the pen is told as such, not again as an input without wire.
        let mut has_slip = !node.extra.is_empty();
        for (port, links) in &node.inputs {
            let to_type = match &spec {
                None => None,
                Some(spec) => {
                    let Some(input) = spec.inputs.iter().find(|input| input.name == *port) else {
                        let message = format!("`{id}` has no input `{port}`");
                        let error = document.error_at_key(&["nodes", name, "inputs", port], message);
                        self.report(error.help(suggest(port, names(&spec.inputs), "inputs")));
                        has_slip = true;
                        continue;
                    };
                    Some(input.value_type)
                }
            };
            for (index, link) in links.iter().enumerate() {
                let at = ["nodes", name, "inputs", port, &index.to_string()];
                let Ok(sources) = self.resolve(scope, link, &at, &mut Trail::new()) else {
                    wired.push(port);
                    continue;
                };
                if !sources.is_empty() {
                    wired.push(port);
                }
                let Some(target) = target else { continue };
                let to = format!("{full}.{port}");
                let declared = if link.node == GRAPH { self.type_of(scope, link) } else { None };
                if let (Some(from_type), Some(to_type)) = (declared, to_type)
                    && from_type != to_type
                {
                    let (message, help) = self.mismatch(link, from_type, &to, to_type);
                    self.report(document.error(&at, message).help(help));
                    continue;
                }
                for (from, output) in sources {
                    if let Err(refused) = self.builder.connect(from, &output, target, port) {
                        let error = document.error(&at, refused.to_string());
                        self.report(match refused {
                            GraphError::TypeMismatch { from_type, to_type, .. } => {
                                error.help(self.converter(from_type, to_type))
                            }
                            GraphError::TooManyWires { .. } => error.help("keep one of them"),
                            _ => error,
                        });
                    }
                }
            }
        }
        if target.is_none() || has_slip {
            return;
        }
        for input in spec.iter().flat_map(|spec| &spec.inputs) {
            if input.arity == Arity::One && !wired.iter().any(|port| **port == *input.name) {
                let unconnected = GraphError::Unconnected {
                    to: format!("{full}.{}", input.name),
                    value_type: input.value_type,
                };
                let error = document.error_at_key(&["nodes", name], unconnected.to_string());
                let help = format!(
                    "wire an output into it; in the file, `inputs: {{\"{}\": \"node.output\"}}` in `{name}`",
                    input.name
                );
                self.report(error.help(match &self.scopes[scope].parent {
                    Some((_, outer)) if node.inputs.contains_key(&*input.name) => {
                        format!("give `{outer}` the input that it is linked to")
                    }
                    _ => help,
                }));
            }
        }
    }

    /// The message and the help for a wire between types.
    fn mismatch(&self, from: &Link, from_type: ValueType, to: &str, to_type: ValueType) -> (String, String) {
        let error =
            GraphError::TypeMismatch { from: from.to_string(), from_type, to: to.to_owned(), to_type };
        (error.to_string(), self.converter(from_type, to_type))
    }

    /// Names the node types that turn the one type into the other.
    fn converter(&self, from: ValueType, to: ValueType) -> String {
        let converters = self.registry.converters(from, to);
        let ids: Vec<_> = converters.iter().take(3).map(|spec| spec.id.to_string()).collect();
        match ids.is_empty() {
            true => format!("link an output that gives a {to}"),
            false => format!("put a node between them that makes a {to} of a {from}, such as {}", list(&ids)),
        }
    }

    /// The outputs that feed a link written at `at`: none for an input that the outer graph leaves open.
    fn resolve(
        &mut self,
        scope: usize,
        link: &Link,
        at: &[&str],
        trail: &mut Trail,
    ) -> Result<Vec<Source>, Reported> {
        let document = self.scopes[scope].document.clone();
        let step = (scope, link.clone());
        if let Some(first) = trail.get_index_of(&step) {
            let around = trail.iter().skip(first).chain([&step]);
            let path: Vec<_> =
                around.map(|(scope, link)| format!("{}{}", self.scopes[*scope].prefix, link.node)).collect();
            let error = document.error(at, GraphError::Cycle { path }.to_string());
            self.report(error.help("remove one of the wires on it"));
            return Err(Reported);
        }
        if trail.len() >= MAX_TRAIL {
            let message = format!("more than {MAX_TRAIL} bypassed nodes or subgraphs stand in a row here");
            self.report(document.error(at, message).help("remove some of them"));
            return Err(Reported);
        }
        trail.insert(step);
        let sources = self.resolve_step(scope, link, at, trail);
        trail.pop();
        sources
    }

    fn resolve_step(
        &mut self,
        scope: usize,
        link: &Link,
        at: &[&str],
        trail: &mut Trail,
    ) -> Result<Vec<Source>, Reported> {
        let document = self.scopes[scope].document.clone();
        let Link { node: name, port } = link;
        if name == GRAPH {
            if !document.inputs.contains_key(port) {
                let error = document.error(at, format!("the graph has no input `{port}`"));
                self.report(error.help(suggest(port, document.inputs.keys().map(String::as_str), "inputs")));
                return Err(Reported);
            }
            let Some((outer, user)) = self.scopes[scope].parent.clone() else {
                let message = format!("the input `{port}` is given by the graph that uses this one");
                let error = document
                    .error(at, message)
                    .help("run a graph that uses it as a node, or wire a reader here");
                return Ok(self.stand_in(&format!("{GRAPH}.{port}"), error));
            };
            return self.resolve_input(outer, &user, port, trail);
        }
        let Some(node) = document.nodes.get(name) else {
            let error = document.error(at, format!("there is no node `{name}`"));
            let known = document.nodes.keys().map(String::as_str);
            self.report(error.help(suggest(name, known, "nodes")));
            return Err(Reported);
        };
        if let Some(&child) = self.scopes[scope].children.get(name) {
            let inner = self.scopes[child].document.clone();
            let Some(output) = inner.outputs.get(port) else {
                let error = document.error(at, format!("the graph `{name}` has no output `{port}`"));
                self.report(error.help(suggest(port, inner.outputs.keys().map(String::as_str), "outputs")));
                return Err(Reported);
            };
            if !node.bypass {
                return self.resolve(child, output, &["outputs", port], trail);
            }
            let value_type = self.type_of(child, output);
            let inputs = inner.inputs.iter();
            let inputs = inputs.map(|(name, input)| (name.clone(), input.value_type)).collect();
            return self.pass_through(scope, link, at, value_type, inputs, trail);
        }
        let Body::Type { id, .. } = &node.body else {
            // The subgraph's file was refused.
            return Err(Reported);
        };
        let is_missing = |id: &NodeId| self.missing.contains_key(id);
        let target = self.scopes[scope].ids.get(name).copied();
        if let Some(target) = target.filter(is_missing) {
            return Ok(vec![(target, port.clone())]);
        }
        let Some(node_type) = self.registry.get(id).cloned() else {
            let error = document.error(at, format!("what the bypassed `{name}` hands on is not known here"));
            let help = format!("there is no node type `{id}`");
            return Ok(self.stand_in(&format!("{}{link}", self.scopes[scope].prefix), error.help(help)));
        };
        let spec = node_type.spec();
        let Some(output) = spec.outputs.iter().find(|output| output.name == *port) else {
            let error = document.error(at, format!("`{id}` has no output `{port}`"));
            self.report(error.help(suggest(port, names(&spec.outputs), "outputs")));
            return Err(Reported);
        };
        if node.bypass {
            let inputs = spec.inputs.iter().map(|input| (input.name.to_string(), input.value_type)).collect();
            return self.pass_through(scope, link, at, Some(output.value_type), inputs, trail);
        }
        match target {
            Some(target) => Ok(vec![(target, port.clone())]),
            None => Err(Reported),
        }
    }

    /// What is wired to an input of a node.
    fn resolve_input(
        &mut self,
        scope: usize,
        name: &str,
        port: &str,
        trail: &mut Trail,
    ) -> Result<Vec<Source>, Reported> {
        let document = self.scopes[scope].document.clone();
        let links = document.nodes.get(name).and_then(|node| node.inputs.get(port));
        let mut sources = Vec::new();
        for (index, link) in links.into_iter().flatten().enumerate() {
            let at = ["nodes", name, "inputs", port, &index.to_string()];
            sources.extend(self.resolve(scope, link, &at, trail)?);
        }
        Ok(sources)
    }

    /// What a bypassed node hands on: the wire of its first input of the output's type.
    fn pass_through(
        &mut self,
        scope: usize,
        link: &Link,
        at: &[&str],
        value_type: Option<ValueType>,
        inputs: Vec<(String, ValueType)>,
        trail: &mut Trail,
    ) -> Result<Vec<Source>, Reported> {
        let full = format!("{}{link}", self.scopes[scope].prefix);
        let refuse = |compiler: &mut Self, why: String, help: &str| {
            let document = compiler.scopes[scope].document.clone();
            let message = format!("the bypassed `{}` has nothing to hand on as `{link}`: {why}", link.node);
            Ok(compiler.stand_in(&full, document.error(at, message).help(help)))
        };
        let Some(value_type) = value_type else {
            return refuse(self, "its type is not known here".into(), "do not bypass it");
        };
        let Some((port, _)) = inputs.into_iter().find(|(_, input)| *input == value_type) else {
            return refuse(self, format!("no input takes a {value_type}"), "do not bypass it");
        };
        let sources = self.resolve_input(scope, &link.node, &port, trail)?;
        if sources.is_empty() {
            return refuse(
                self,
                format!("`{port}` is not connected"),
                "connect it, or do not bypass the node",
            );
        }
        Ok(sources)
    }

    /// A placeholder in the place of an output that there is none of.
    fn stand_in(&mut self, name: &str, error: DocumentError) -> Vec<Source> {
        let id = match self.stand_ins.get(name) {
            Some(id) => Some(*id),
            None => self.add_missing(name, name, error),
        };
        if let Some(id) = id {
            self.stand_ins.insert(name.to_owned(), id);
        }
        id.map(|id| (id, String::new())).into_iter().collect()
    }

    /// The type that a link gives, as specs and declared inputs tell it.
    fn type_of(&self, scope: usize, link: &Link) -> Option<ValueType> {
        let (mut scope, mut link) = (scope, link);
        loop {
            let current = &self.scopes[scope];
            if link.node == GRAPH {
                return current.document.inputs.get(&link.port).map(|input| input.value_type);
            }
            if let Some(&child) = current.children.get(&link.node) {
                link = self.scopes[child].document.outputs.get(&link.port)?;
                scope = child;
                continue;
            }
            let Body::Type { id, .. } = &current.document.nodes.get(&link.node)?.body else { return None };
            let spec = self.registry.get(id)?.spec();
            return spec.outputs.iter().find(|output| output.name == *link.port).map(|port| port.value_type);
        }
    }

    /// The output of the flat graph behind a link of a scope; what is wrong is reported.
    pub(super) fn output_of(&mut self, scope: usize, link: &Link, at: &[&str]) -> Option<OutputRef> {
        let sources = self.resolve(scope, link, at, &mut Trail::new()).ok()?;
        let (node, port) = sources.first()?;
        match self.builder.output(*node, port) {
            Ok(output) => Some(output),
            Err(error) => {
                let document = self.scopes[scope].document.clone();
                self.report(document.error(at, error.to_string()));
                None
            }
        }
    }

    /// Outputs of bypassed nodes and of subgraphs, by `node.output`.
    pub(super) fn aliases(&mut self) -> IndexMap<String, OutputRef> {
        let mut aliases = IndexMap::new();
        for scope in 0..self.scopes.len() {
            let current = &self.scopes[scope];
            let (document, prefix) = (current.document.clone(), current.prefix.clone());
            for (name, node) in &document.nodes {
                if self.has_enough_errors() {
                    return aliases;
                }
                let ports: Vec<String> = match (&node.body, current_child(self, scope, name)) {
                    (Body::Graph { .. }, Some(child)) => {
                        self.scopes[child].document.outputs.keys().cloned().collect()
                    }
                    (Body::Type { id, .. }, _) if node.bypass => self
                        .registry
                        .get(id)
                        .map(|known| names(&known.spec().outputs).map(str::to_owned).collect())
                        .unwrap_or_default(),
                    _ => continue,
                };
                for port in ports {
                    let link = Link::new(name.clone(), port);
                    if let Some(output) = self.output_of(scope, &link, &["nodes", name]) {
                        aliases.insert(format!("{prefix}{link}"), output);
                    }
                }
            }
        }
        aliases
    }
}

fn current_child(compiler: &Compiler<'_>, scope: usize, name: &str) -> Option<usize> {
    compiler.scopes[scope].children.get(name).copied()
}

fn names(ports: &[PortSpec]) -> impl Iterator<Item = &str> {
    ports.iter().map(|port| &*port.name)
}
