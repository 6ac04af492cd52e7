//! Settings of nodes: what the file, outer graphs and overrides say, lifted, typed and checked.

use std::{path::Path, sync::Arc};

use indexmap::IndexMap;
use orograph_core::{Error, NodeType, ParamKind, ParamSpec, ParamValue, RawParams};

use super::{Compiler, Place, list, scope::no_field, suggest};
use crate::{
    GraphError,
    document::{Body, Document, DocumentError, GRAPH, Link, Literal, Node},
};

/// A value given to a parameter.
#[derive(Clone)]
struct Setting {
    given: Given,
    origin: Origin,
}

#[derive(Clone)]
enum Given {
    /// As a file writes it.
    Literal(Literal),
    /// The text of an override.
    Bare(String),
    /// Out of a node's own upgrade.
    Lifted(ParamValue),
}

/// Who gave a value: a node in a file, or an override.
#[derive(Clone)]
enum Origin {
    File { scope: usize, node: String, param: String },
    Override(usize),
}

/// The settings of one node, by parameter.
type NodeSettings = IndexMap<String, Setting>;

/// What graphs around a node and overrides give to nodes, by scope and name.
#[derive(Default)]
pub(super) struct AllSettings {
    /// By the names that the node's document uses, possibly those of an older version.
    written: IndexMap<(usize, String), NodeSettings>,
    /// By the current names.
    current: IndexMap<(usize, String), NodeSettings>,
}

/// The checked values of one node.
pub(super) struct NodeValues {
    node_type: Arc<NodeType>,
    values: Vec<ParamValue>,
    origins: Vec<Option<Origin>>,
    /// The version that the document names its parameters by.
    version: u32,
}

/// Checked values by scope and node.
pub(super) type Values = IndexMap<(usize, String), NodeValues>;

impl NodeValues {
    /// The parameter that the document calls `name`, and its value.
    pub(super) fn find(&self, name: &str) -> Option<(&ParamSpec, &ParamValue)> {
        self.position(name).map(|index| (&self.node_type.spec().params[index], &self.values[index]))
    }

    fn position(&self, name: &str) -> Option<usize> {
        let params = &self.node_type.spec().params;
        let named = |name: &str| params.iter().position(|spec| spec.name == name);
        named(name).or_else(|| {
            // An older name: the node's own upgrade tells what it became.
            let mut raw = RawParams::default();
            raw.set(name, ParamValue::Number(0.0));
            self.node_type.upgrade(&mut raw, self.version).ok()?;
            raw.0.keys().find_map(|name| named(name))
        })
    }
}

impl Compiler<'_> {
    /// Gathers what overrides and outer graphs give to nodes.
    pub(super) fn settings(&mut self) -> AllSettings {
        let mut all = AllSettings::default();
        // Inner scopes first, so that the outermost has the last word.
        for scope in (0..self.scopes.len()).rev() {
            let document = self.scopes[scope].document.clone();
            let children: Vec<_> =
                self.scopes[scope].children.iter().map(|(name, child)| (name.clone(), *child)).collect();
            for (name, child) in children {
                let Some(node) = document.nodes.get(&name) else { continue };
                for (param, literal) in &node.params {
                    let origin = Origin::File { scope, node: name.clone(), param: param.clone() };
                    let setting = Setting { given: Given::Literal(literal.clone()), origin };
                    let known = &self.scopes[child].document.clone().expose;
                    if known.contains_key(param) {
                        self.give_exposed(child, param, &setting, &mut all);
                    } else {
                        let message = format!("the graph `{name}` exposes no parameter `{param}`");
                        let help = suggest(param, known.keys().map(String::as_str), "exposed parameters");
                        self.report(
                            document.error_at_key(&["nodes", &name, "params", param], message).help(help),
                        );
                    }
                }
            }
        }
        for index in 0..self.options.overrides.len() {
            if let Err(error) = self.give_override(index, &mut all) {
                self.report(error);
            }
        }
        all
    }

    /// Follows exposed parameters inwards to the node that has the parameter.
    pub(super) fn target(&self, scope: usize, link: &Link) -> Option<(usize, Link)> {
        let (mut scope, mut link) = (scope, link.clone());
        loop {
            let current = &self.scopes[scope];
            match current.children.get(&link.node) {
                None => return current.document.nodes.contains_key(&link.node).then_some((scope, link)),
                Some(&child) => {
                    link = self.scopes[child].document.expose.get(&link.port)?.param.clone();
                    scope = child;
                }
            }
        }
    }

    fn give_exposed(&self, scope: usize, name: &str, setting: &Setting, all: &mut AllSettings) {
        let Some(exposed) = self.scopes[scope].document.expose.get(name) else { return };
        // A target that does not exist is reported where it is exposed.
        if let Some((scope, target)) = self.target(scope, &exposed.param) {
            let settings = all.written.entry((scope, target.node)).or_default();
            settings.insert(target.port, setting.clone());
        }
    }

    fn give_override(&self, index: usize, all: &mut AllSettings) -> Result<(), DocumentError> {
        let (name, text) = &self.options.overrides[index];
        let setting = Setting { given: Given::Bare(text.clone()), origin: Origin::Override(index) };
        let mut scope = 0;
        let Some((path, param)) = name.rsplit_once('.') else {
            let exposed = &self.scopes[scope].document.expose;
            if exposed.contains_key(name) {
                self.give_exposed(scope, name, &setting, all);
                return Ok(());
            }
            let help = match suggest(name, exposed.keys().map(String::as_str), "exposed parameters") {
                help if help.starts_with("did") => help,
                help => format!("{help}; a node's own parameter is written `node.param`"),
            };
            return Err(DocumentError::new(format!("the graph exposes no parameter `{name}`")).help(help));
        };
        let mut steps = path.split('/').peekable();
        while let Some(step) = steps.next() {
            let current = &self.scopes[scope];
            let unknown = |what: &str, known: Vec<&str>| {
                DocumentError::new(format!("`{name}`: there is no {what} `{step}`")).help(suggest(
                    step,
                    known,
                    &format!("{what}s"),
                ))
            };
            if steps.peek().is_some() {
                let known = current.children.keys().map(String::as_str).collect();
                scope = *current.children.get(step).ok_or_else(|| unknown("subgraph", known))?;
                continue;
            }
            if let Some(&child) = current.children.get(step) {
                let exposed = &self.scopes[child].document.expose;
                if !exposed.contains_key(param) {
                    let message = format!("the graph `{path}` exposes no parameter `{param}`");
                    let help = suggest(param, exposed.keys().map(String::as_str), "exposed parameters");
                    return Err(DocumentError::new(message).help(help));
                }
                self.give_exposed(child, param, &setting, all);
            } else if current.document.nodes.contains_key(step) {
                let settings = all.current.entry((scope, step.to_owned())).or_default();
                settings.insert(param.to_owned(), setting.clone());
            } else {
                return Err(unknown("node", current.document.nodes.keys().map(String::as_str).collect()));
            }
        }
        Ok(())
    }

    /// Puts every node of every scope into the graph, bypassed ones apart.
    pub(super) fn add_nodes(&mut self, all: &AllSettings) -> Values {
        let mut values = Values::new();
        for scope in 0..self.scopes.len() {
            let document = self.scopes[scope].document.clone();
            for (name, node) in &document.nodes {
                let Body::Type { id, version } = &node.body else { continue };
                let bypassed = node.bypass || self.scopes[scope].bypassed;
                let node_type = match self.node_type(&document, name, id, *version) {
                    Ok(node_type) => node_type,
                    Err(error) if bypassed => {
                        drop(error);
                        continue;
                    }
                    Err(error) => {
                        let full = format!("{}{name}", self.scopes[scope].prefix);
                        if let Some(added) = self.add_missing(&full, id, error) {
                            self.place(scope, name, added);
                        }
                        continue;
                    }
                };
                for field in node.extra.keys() {
                    let known = ["node", "version", "params", "inputs", "bypass", "comment"];
                    let error = document.error_at_key(&["nodes", name, field], no_field(field));
                    self.report(error.help(suggest(field, known, "fields")));
                }
                let Some(checked) = self.node_values(scope, name, node, &node_type, *version, all) else {
                    continue;
                };
                if !bypassed {
                    self.add_node(scope, name, &checked);
                }
                values.insert((scope, name.clone()), checked);
            }
        }
        for scope in 0..self.scopes.len() {
            self.check_exposed(scope, &values);
        }
        values
    }

    fn place(&mut self, scope: usize, name: &str, id: crate::NodeId) {
        self.scopes[scope].ids.insert(name.to_owned(), id);
        self.places.insert(id, Place { scope, node: name.to_owned() });
    }

    fn add_node(&mut self, scope: usize, name: &str, checked: &NodeValues) {
        let full = format!("{}{name}", self.scopes[scope].prefix);
        match self.builder.add(&full, &checked.node_type, checked.values.clone()) {
            Ok(id) => {
                let base = |origin: &Option<Origin>| match origin {
                    Some(Origin::File { scope, .. }) => self.scopes[*scope].dir.clone(),
                    Some(Origin::Override(_)) => self.options.base_dir.as_path().into(),
                    None => self.scopes[scope].dir.clone(),
                };
                let bases: Vec<Arc<Path>> = checked.origins.iter().map(base).collect();
                self.builder.set_base_dirs(id, bases);
                self.place(scope, name, id);
            }
            Err(GraphError::Param { error, .. }) => {
                let message = format!("`{full}`: {error}");
                let told = self.scopes[scope].document.error_at_key(&["nodes", name], message);
                self.report(told.maybe_help(error.hint()));
            }
            Err(error) => {
                let told = self.scopes[scope].document.error_at_key(&["nodes", name], error.to_string());
                self.report(told);
            }
        }
    }

    /// The type of a node, or why there is none here.
    fn node_type(
        &self,
        document: &Document,
        name: &str,
        id: &str,
        version: Option<u32>,
    ) -> Result<Arc<NodeType>, DocumentError> {
        let Some(node_type) = self.registry.get(id) else {
            let error = document.error(&["nodes", name, "node"], format!("there is no node type `{id}`"));
            return Err(match self.registry.nearest(id) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help("`orograph nodes` lists the node types; a plugin may supply more"),
            });
        };
        let newest = node_type.spec().version;
        match version {
            Some(version) if version > newest => {
                let message = format!("`{id}` is known up to version {newest}, not {version}");
                let error = document.error(&["nodes", name, "version"], message);
                Err(error.help("the graph was saved by a newer program or plugin; update this one"))
            }
            _ => Ok(node_type.clone()),
        }
    }

    fn node_values(
        &mut self,
        scope: usize,
        name: &str,
        node: &Node,
        node_type: &Arc<NodeType>,
        version: Option<u32>,
        all: &AllSettings,
    ) -> Option<NodeValues> {
        let key = (scope, name.to_owned());
        let mut given: NodeSettings = node
            .params
            .iter()
            .map(|(param, literal)| {
                let origin = Origin::File { scope, node: name.to_owned(), param: param.clone() };
                (param.clone(), Setting { given: Given::Literal(literal.clone()), origin })
            })
            .collect();
        given.extend(all.written.get(&key).cloned().unwrap_or_default());
        let spec = node_type.spec();
        let version = version.unwrap_or(spec.version);
        if version < spec.version {
            given = self.lift(scope, name, node_type, version, given)?;
        }
        given.extend(all.current.get(&key).cloned().unwrap_or_default());
        let mut values: Vec<_> = spec.params.iter().map(|param| param.default.clone()).collect();
        let mut origins = vec![None; values.len()];
        let mut sound = true;
        for (param, setting) in given {
            let index = spec.params.iter().position(|known| known.name == param);
            let checked = match index {
                Some(index) => typed(&setting.given, &spec.params[index]).map(|value| (index, value)),
                None => {
                    let help = suggest(&param, spec.params.iter().map(|known| &*known.name), "parameters");
                    Err((format!("`{}` has no parameter `{param}`", spec.id), Some(help)))
                }
            };
            match checked {
                Ok((index, value)) => {
                    values[index] = value;
                    origins[index] = Some(setting.origin);
                }
                Err((message, help)) => {
                    sound = false;
                    let error = self.error_from(&setting.origin, index.is_none(), &message);
                    self.report(error.maybe_help(help));
                }
            }
        }
        sound.then(|| NodeValues { node_type: node_type.clone(), values, origins, version })
    }

    fn lift(
        &mut self,
        scope: usize,
        name: &str,
        node_type: &NodeType,
        version: u32,
        given: NodeSettings,
    ) -> Option<NodeSettings> {
        let mut raw = RawParams::default();
        let mut sound = true;
        for (param, setting) in &given {
            match untyped(&setting.given) {
                Some(value) => raw.set(param, value),
                None => {
                    sound = false;
                    let message = format!("`{param}` has a value that no parameter takes");
                    let error = self.error_from(&setting.origin, false, &message);
                    self.report(error);
                }
            }
        }
        if !sound {
            return None;
        }
        if let Err(error) = node_type.upgrade(&mut raw, version) {
            let document = &self.scopes[scope].document;
            let told = document.error(&["nodes", name, "version"], error.to_string());
            self.report(told.maybe_help(error.hint()));
            return None;
        }
        let lifted = raw.0.into_iter().map(|(param, value)| {
            let before = given.get(&param);
            // What kept name and value keeps its own text too, so that integers stay integers.
            let given = match before {
                Some(setting) if untyped(&setting.given).as_ref() == Some(&value) => setting.given.clone(),
                _ => Given::Lifted(value),
            };
            let origin = before.map_or_else(
                || Origin::File { scope, node: name.to_owned(), param: param.clone() },
                |setting| setting.origin.clone(),
            );
            (param, Setting { given, origin })
        });
        Some(lifted.collect())
    }

    fn error_from(&self, origin: &Origin, key: bool, message: &str) -> DocumentError {
        match origin {
            Origin::File { scope, node, param } => {
                let document = &self.scopes[*scope].document;
                let at = ["nodes", node, "params", param];
                if key { document.error_at_key(&at, message) } else { document.error(&at, message) }
            }
            Origin::Override(index) => {
                let (name, text) = &self.options.overrides[*index];
                DocumentError::new(format!("in `{name}={text}`: {message}"))
            }
        }
    }

    /// Checks what a scope exposes: the parameter is there, and its value inside the narrower range.
    fn check_exposed(&mut self, scope: usize, values: &Values) {
        let document = self.scopes[scope].document.clone();
        for (name, exposed) in &document.expose {
            let at = ["expose", name, "param"];
            let Link { node, port } = &exposed.param;
            let Some(named) = document.nodes.get(node) else {
                let known = document.nodes.keys().map(String::as_str);
                let error = document.error(&at, format!("there is no node `{node}`"));
                self.report(error.help(suggest(node, known, "nodes")));
                continue;
            };
            if let Some(child) = self.scopes[scope].children.get(node) {
                let inner = self.scopes[*child].document.clone();
                if !inner.expose.contains_key(port) {
                    let error =
                        document.error(&at, format!("the graph `{node}` exposes no parameter `{port}`"));
                    let known = inner.expose.keys().map(String::as_str);
                    self.report(error.help(suggest(port, known, "exposed parameters")));
                    continue;
                }
            }
            let Some((inner, target)) = self.target(scope, &exposed.param) else { continue };
            // A node with faults of its own, or of an unknown type, tells nothing about its parameters.
            let Some(checked) = values.get(&(inner, target.node.clone())) else { continue };
            let Some(index) = checked.position(&target.port) else {
                if matches!(named.body, Body::Type { .. }) {
                    let spec = checked.node_type.spec();
                    let error = document.error(&at, format!("`{}` has no parameter `{port}`", spec.id));
                    let known = spec.params.iter().map(|param| &*param.name);
                    self.report(error.help(suggest(port, known, "parameters")));
                }
                continue;
            };
            let Some((low, high)) = exposed.range else { continue };
            let spec = &checked.node_type.spec().params[index];
            let number = match &checked.values[index] {
                ParamValue::Number(number) => *number,
                ParamValue::Integer(integer) => *integer as f64,
                _ => {
                    let message = format!("`{name}` has a range, but `{}` is no number", exposed.param);
                    let error = document.error(&["expose", name, "range"], message);
                    self.report(error.help("remove the range"));
                    continue;
                }
            };
            if !(low..=high).contains(&number) {
                let refused =
                    Error::OutOfRange { name: name.clone(), value: number, low, high, unit: spec.unit };
                let error = match &checked.origins[index] {
                    Some(origin) => self.error_from(origin, false, &refused.to_string()),
                    None => document.error(&["expose", name, "range"], refused.to_string()),
                };
                self.report(error.maybe_help(refused.hint()));
            }
        }
        if let Some(input) = document.inputs.keys().find(|input| *input == GRAPH) {
            let error =
                document.error_at_key(&["inputs", input], format!("`{GRAPH}` stands for the graph itself"));
            self.report(error.help("give the input another name"));
        }
    }
}

type Refused = (String, Option<String>);

/// The value that a parameter of this spec gets, inside its hard range.
fn typed(given: &Given, spec: &ParamSpec) -> Result<ParamValue, Refused> {
    let value = match given {
        Given::Literal(literal) => literal_value(literal, spec)?,
        Given::Bare(text) => {
            let is_text = matches!(
                spec.kind,
                ParamKind::Text | ParamKind::Choice { .. } | ParamKind::InputPath | ParamKind::OutputPath
            );
            match Literal::parse(text) {
                Ok(literal @ Literal::Text(_)) => literal_value(&literal, spec)?,
                _ if is_text => ParamValue::Text(text.clone()),
                Ok(literal) => literal_value(&literal, spec)?,
                Err(message) => {
                    return Err((message, Some(format!("`{}` takes {}", spec.name, takes(spec)))));
                }
            }
        }
        Given::Lifted(value) => match (&spec.kind, value) {
            (ParamKind::Number { .. }, ParamValue::Integer(integer)) => ParamValue::Number(*integer as f64),
            (ParamKind::Integer { .. }, ParamValue::Number(number)) => {
                ParamValue::Integer(whole(*number).unwrap_or(i64::MAX))
            }
            _ => value.clone(),
        },
    };
    spec.check(&value).map_err(|error| (error.to_string(), hint(&error, spec, &value)))?;
    Ok(value)
}

/// What would mend a refused value: the nearest option where there is one.
fn hint(error: &Error, spec: &ParamSpec, value: &ParamValue) -> Option<String> {
    match (&spec.kind, value) {
        (ParamKind::Choice { options }, ParamValue::Text(text)) => {
            Some(suggest(text, options.iter().map(|option| &*option.name), "options"))
        }
        _ => error.hint(),
    }
}

fn takes(spec: &ParamSpec) -> String {
    match &spec.kind {
        ParamKind::Number { .. } => "a number".into(),
        ParamKind::Integer { .. } => "a whole number".into(),
        ParamKind::Boolean => "`true` or `false`".into(),
        ParamKind::Text => "a string".into(),
        ParamKind::Choice { options } => {
            format!("one of {}", list(options.iter().map(|option| &option.name)))
        }
        ParamKind::InputPath | ParamKind::OutputPath => "a path as a string".into(),
        ParamKind::Curve { .. } => "a curve, as in `[(0.0, 0.0), (1.0, 1.0)]`".into(),
        ParamKind::Lines { .. } => "lines, as in `[[(x, y, height), (x, y, height)]]`".into(),
        _ => "another kind of value".into(),
    }
}

fn literal_value(literal: &Literal, spec: &ParamSpec) -> Result<ParamValue, Refused> {
    let value = match &spec.kind {
        ParamKind::Number { .. } => number(literal).map(ParamValue::Number),
        ParamKind::Integer { .. } => match literal {
            Literal::Integer(integer) => Some(ParamValue::Integer(*integer)),
            Literal::Number(number) => whole(*number).map(ParamValue::Integer),
            _ => None,
        },
        ParamKind::Boolean => match literal {
            Literal::Boolean(value) => Some(ParamValue::Boolean(*value)),
            _ => None,
        },
        ParamKind::Choice { .. } => match literal {
            Literal::Text(text) | Literal::Word(text) => Some(ParamValue::Text(text.clone())),
            _ => None,
        },
        ParamKind::Text | ParamKind::InputPath | ParamKind::OutputPath => match literal {
            Literal::Text(text) => Some(ParamValue::Text(text.clone())),
            _ => None,
        },
        ParamKind::Curve { .. } => points(literal).map(ParamValue::Curve),
        ParamKind::Lines { .. } => lines(literal),
        _ => None,
    };
    value.ok_or_else(|| match literal {
        Literal::Other(raw) if raw.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
            let raw: String = raw.chars().take(40).collect();
            (format!("`{}` is {raw}, which is more than a number can hold", spec.name), None)
        }
        _ => (format!("`{}` takes {}, not {}", spec.name, takes(spec), literal.noun()), None),
    })
}

fn number(literal: &Literal) -> Option<f64> {
    match literal {
        Literal::Number(number) => Some(*number),
        Literal::Integer(integer) => Some(*integer as f64),
        _ => None,
    }
}

/// A number without fraction as an integer, where it holds one exactly.
fn whole(number: f64) -> Option<i64> {
    (number.trunc() == number && number.abs() <= 9_007_199_254_740_992.0).then_some(number as i64)
}

fn items(literal: &Literal) -> Option<&[Literal]> {
    match literal {
        Literal::List(items) | Literal::Tuple(items) => Some(items),
        _ => None,
    }
}

fn point<const N: usize>(literal: &Literal) -> Option<[f64; N]> {
    let numbers: Option<Vec<_>> = items(literal)?.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn points<const N: usize>(literal: &Literal) -> Option<Vec<[f64; N]>> {
    items(literal)?.iter().map(point).collect()
}

fn lines(literal: &Literal) -> Option<ParamValue> {
    Some(ParamValue::Lines(items(literal)?.iter().map(points).collect::<Option<_>>()?))
}

/// A value as its text alone tells its type, for parameters that the current spec may not have.
fn untyped(given: &Given) -> Option<ParamValue> {
    let literal = match given {
        Given::Literal(literal) => literal.clone(),
        Given::Bare(text) => Literal::parse(text).unwrap_or_else(|_| Literal::Text(text.clone())),
        Given::Lifted(value) => return Some(value.clone()),
    };
    Some(match &literal {
        Literal::Boolean(value) => ParamValue::Boolean(*value),
        Literal::Integer(integer) => ParamValue::Integer(*integer),
        Literal::Number(number) => ParamValue::Number(*number),
        Literal::Text(text) | Literal::Word(text) => ParamValue::Text(text.clone()),
        Literal::List(_) => match points(&literal) {
            Some(points) => ParamValue::Curve(points),
            None => lines(&literal)?,
        },
        _ => return None,
    })
}
