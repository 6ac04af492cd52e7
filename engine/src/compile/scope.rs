//! Subgraphs laid flat: one scope for the document and one for each use of a graph as a node.

use std::{
    ops::Deref,
    path::{Component, Path, PathBuf},
    sync::Arc,
};

use indexmap::IndexMap;

use super::{Compiler, MAX_DEPTH, MAX_NODES};
use crate::{
    NodeId,
    document::{Body, Document, DocumentError, NODE_FIELDS, unknown_fields},
    suggest::suggest,
};

/// A document where it is used: errors about it tell the node of the outermost document that they are found at.
#[derive(Clone)]
pub(super) struct Used {
    document: Arc<Document>,
    /// The node that stands for it; none for the outermost document itself.
    outer: Option<Arc<str>>,
}

impl Deref for Used {
    type Target = Document;

    fn deref(&self) -> &Document {
        &self.document
    }
}

impl Used {
    /// As [`Document::error`].
    pub(super) fn error(&self, at: &[&str], message: impl Into<String>) -> DocumentError {
        self.document.error(at, message).about(self.outer.as_deref())
    }

    /// As [`Document::error_at_key`].
    pub(super) fn error_at_key(&self, at: &[&str], message: impl Into<String>) -> DocumentError {
        self.document.error_at_key(at, message).about(self.outer.as_deref())
    }
}

/// One use of a document.
pub(super) struct Scope {
    pub(super) document: Used,
    /// Empty, or `outer/`: what the names of its nodes start with.
    pub(super) prefix: String,
    /// The file's folder.
    pub(super) dir: Arc<Path>,
    /// The scope and node that use it.
    pub(super) parent: Option<(usize, String)>,
    /// Its nodes that are graphs.
    pub(super) children: IndexMap<String, usize>,
    /// Its nodes in the flat graph.
    pub(super) ids: IndexMap<String, NodeId>,
    /// It, or a scope around it, is bypassed: its nodes are not in the flat graph.
    pub(super) bypassed: bool,
}

/// What was read so far: each file once, however often it is used.
struct Files {
    loaded: IndexMap<PathBuf, Option<Arc<Document>>>,
    n_nodes: usize,
}

impl Compiler<'_> {
    pub(super) fn expand_root(&mut self, document: &Document) {
        let dir: Arc<Path> = self.options.base_dir.as_path().into();
        let name = document.path().and_then(|path| Path::new(path).file_name());
        let file = normal(&name.map_or_else(|| dir.to_path_buf(), |name| dir.join(name)));
        self.scopes.push(Scope {
            document: Used { document: Arc::new(document.clone()), outer: None },
            prefix: String::new(),
            dir,
            parent: None,
            children: IndexMap::new(),
            ids: IndexMap::new(),
            bypassed: false,
        });
        let mut files = Files { loaded: IndexMap::new(), n_nodes: 0 };
        self.expand(0, &mut vec![file], &mut files);
    }

    /// Reports a field that the format does not know, and those that it knows there.
    pub(super) fn refuse_field(&mut self, document: &Used, place: &[&str], known: &[&str]) {
        let Some(field) = place.last() else { return };
        let message = match place {
            ["nodes", ..] => format!("a node has no field `{field}`"),
            _ => format!("there is no field `{field}` here"),
        };
        let error = document.error_at_key(place, message);
        self.report(error.help(suggest(field, known.iter().copied(), "fields")));
    }

    fn expand(&mut self, scope: usize, stack: &mut Vec<PathBuf>, files: &mut Files) {
        let document = self.scopes[scope].document.clone();
        files.n_nodes += document.nodes.len();
        if files.n_nodes > MAX_NODES {
            let message = format!("the graph has more than {MAX_NODES} nodes, subgraphs laid flat");
            return self.report(DocumentError::new(message).help("use fewer or smaller subgraphs"));
        }
        for (place, known) in unknown_fields(&document) {
            let place: Vec<&str> = place.iter().map(String::as_str).collect();
            self.refuse_field(&document, &place, known);
        }
        for (name, node) in &document.nodes {
            let Body::Graph { path } = &node.body else { continue };
            if files.n_nodes > MAX_NODES {
                return;
            }
            let error = |message: String| document.error(&["nodes", name, "graph"], message);
            for field in node.extra.keys() {
                self.refuse_field(&document, &["nodes", name, field], &NODE_FIELDS);
            }
            if Path::new(path).is_absolute() || path.contains('\\') || path.is_empty() {
                let message = format!("`{}` is no relative path", path.escape_debug());
                let help = "name the file relative to this one, with `/` between folders";
                self.report(error(message).help(help));
                continue;
            }
            let file = normal(&self.scopes[scope].dir.join(path));
            if let Some(first) = stack.iter().position(|outer| *outer == file) {
                let around: Vec<_> =
                    stack[first..].iter().chain([&file]).map(|file| file.display().to_string()).collect();
                let message = format!("a graph uses itself: {}", around.join(" → "));
                self.report(error(message).help("take one of these uses out"));
                continue;
            }
            if stack.len() > MAX_DEPTH {
                let message = format!("graphs inside graphs go deeper than {MAX_DEPTH} levels");
                self.report(error(message).help("lay some of them flat"));
                continue;
            }
            let inner = match files.loaded.get(&file) {
                Some(known) => known.clone(),
                None => {
                    let loaded = self.load(&file, &error);
                    files.loaded.insert(file.clone(), loaded.clone());
                    loaded
                }
            };
            // A file that could not be read was reported when that was tried first.
            let Some(inner) = inner else { continue };
            let child = self.scopes.len();
            let outer = document.outer.clone().unwrap_or_else(|| name.as_str().into());
            let bypassed = self.scopes[scope].bypassed || node.bypass;
            self.scopes.push(Scope {
                document: Used { document: inner, outer: Some(outer) },
                prefix: format!("{}{name}/", self.scopes[scope].prefix),
                dir: file.parent().unwrap_or(Path::new("")).into(),
                parent: Some((scope, name.clone())),
                children: IndexMap::new(),
                ids: IndexMap::new(),
                bypassed,
            });
            self.scopes[scope].children.insert(name.clone(), child);
            stack.push(file);
            self.expand(child, stack, files);
            stack.pop();
        }
    }

    fn load(&mut self, file: &Path, error: &dyn Fn(String) -> DocumentError) -> Option<Arc<Document>> {
        let name = file.display().to_string();
        let bytes = match (self.options.loader)(file) {
            Ok(bytes) => bytes,
            Err(reason) => {
                let refused = error(format!("the graph file {name} cannot be read: {reason}"));
                self.report(refused.help("check the path; it is relative to this file"));
                return None;
            }
        };
        match Document::from_bytes(&bytes, &name) {
            Ok(document) => Some(Arc::new(document)),
            Err(errors) => {
                let outer = error(String::new());
                for error in errors.into_vec() {
                    self.report(error.about(outer.node()));
                }
                None
            }
        }
    }
}

/// The path without `.` and, as far as that is safe, without `..`: two spellings of one file become one.
fn normal(path: &Path) -> PathBuf {
    let mut parts: Vec<Component<'_>> = Vec::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(parts.last(), Some(Component::Normal(_))) => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.iter().collect()
}
