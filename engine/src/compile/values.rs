//! Nodes put into the graph with their settings: lifted, typed and checked.

use std::{path::Path, sync::Arc};

use indexmap::IndexMap;
use orograph_core::{Error, NodeType, ParamSpec, ParamValue, RawParams};

use super::{
    Compiler, Place,
    scope::Used,
    settings::{AllSettings, NodeSettings, Origin, Setting},
    typed::{Given, typed, untyped},
};
use crate::{
    GraphError, NodeId,
    document::{Body, DocumentError, GRAPH, Link, NODE_FIELDS, Node},
    suggest::suggest,
};

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
    /// Puts every node of every scope into the graph, bypassed ones apart.
    pub(super) fn add_nodes(&mut self, all: &AllSettings) -> Values {
        let mut values = Values::new();
        for scope in 0..self.scopes.len() {
            let document = self.scopes[scope].document.clone();
            for (name, node) in &document.nodes {
                if self.has_enough_errors() {
                    return values;
                }
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
                    self.refuse_field(&document, &["nodes", name, field], &NODE_FIELDS);
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

    fn place(&mut self, scope: usize, name: &str, id: NodeId) {
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

    /// The known id most like `id`, unless there are so many unknown ones that a plugin must be lacking.
    fn nearest_type(&self, id: &str) -> Option<&str> {
        if self.missing.len() < 100 { self.registry.nearest(id) } else { None }
    }

    /// The type of a node, or why there is none here.
    fn node_type(
        &self,
        document: &Used,
        name: &str,
        id: &str,
        version: Option<u32>,
    ) -> Result<Arc<NodeType>, DocumentError> {
        let Some(node_type) = self.registry.get(id) else {
            let error = document.error(&["nodes", name, "node"], format!("there is no node type `{id}`"));
            let plugin = document.nodes.get(name).map_or("", |node| node.plugin.as_str());
            if !plugin.is_empty() {
                let plugin = plugin.escape_debug();
                return Err(error.help(format!(
                    "the plugin `{plugin}` supplies it: install it, or name its folder with --plugins"
                )));
            }
            return Err(match self.nearest_type(id) {
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
            let given = Given::after_upgrade(before.map(|setting| &setting.given), value);
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
                let node = name.rsplit_once('.').and_then(|(path, _)| path.split('/').next());
                DocumentError::new(format!("in `{name}={text}`: {message}")).about(node)
            }
        }
    }

    /// Checks what a scope exposes: the parameter is there, and its value inside the narrower range.
    fn check_exposed(&mut self, scope: usize, values: &Values) {
        let document = self.scopes[scope].document.clone();
        for (name, exposed) in &document.expose {
            if self.has_enough_errors() {
                return;
            }
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
