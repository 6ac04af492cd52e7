//! What outer graphs and overrides give to nodes.

use indexmap::IndexMap;

use super::{Compiler, typed::Given};
use crate::{
    document::{DocumentError, Link},
    suggest::suggest,
};

/// A value given to a parameter.
#[derive(Clone)]
pub(super) struct Setting {
    pub(super) given: Given,
    pub(super) origin: Origin,
}

/// Who gave a value: a node in a file, or an override.
#[derive(Clone)]
pub(super) enum Origin {
    File { scope: usize, node: String, param: String },
    Override(usize),
}

/// The settings of one node, by parameter.
pub(super) type NodeSettings = IndexMap<String, Setting>;

/// What graphs around a node and overrides give to nodes, by scope and name.
#[derive(Default)]
pub(super) struct AllSettings {
    /// By the names that the node's document uses, possibly those of an older version.
    pub(super) written: IndexMap<(usize, String), NodeSettings>,
    /// By the current names.
    pub(super) current: IndexMap<(usize, String), NodeSettings>,
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
}
