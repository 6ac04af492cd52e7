//! Graph files: the model that the command line and the editor share, its reader and its writer.
//!
//! A [`Document`] is what a graph file says and no more: names are not looked up, and nothing is checked
//! against a registry. [`compile`](crate::compile::compile) does that. Text and places stay aside for
//! messages, and so that nodes of unknown types are written back as they were.

mod error;
mod fields;
mod literal;
mod read;
mod syntax;
mod types;
mod write;

use std::{fmt, io::Read, ops::Range, path::Path, sync::Arc};

use indexmap::IndexMap;
use orograph_core::ValueType;

pub(crate) use error::SourceText;
pub use error::{DocumentError, DocumentErrors};
pub(crate) use fields::{NODE_FIELDS, unknown_fields};
pub use literal::Literal;
pub(crate) use literal::quote;
use syntax::{Parsed, Shape, Tree};
pub(crate) use write::node_ron;

/// The format version that this program reads and writes.
pub const FORMAT: i64 = 1;
/// A larger graph file is refused before it is read.
pub const MAX_BYTES: usize = 64 << 20;
/// The node name by which a graph's own inputs are linked inside it.
pub const GRAPH: &str = "graph";

/// A graph file.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The comments before the graph, as they stand in the file.
    pub header: String,
    /// What the graph shows.
    pub doc: String,
    /// Parameters of the graph as a whole, by name.
    pub expose: IndexMap<String, Exposed>,
    /// Inputs that the graph has as a node of another graph; linked inside as `graph.name`.
    pub inputs: IndexMap<String, GraphInput>,
    /// Named outputs.
    pub outputs: IndexMap<String, Link>,
    /// Nodes by name.
    pub nodes: IndexMap<String, Node>,
    /// Where an editor shows what.
    pub layout: Layout,
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
    source: Option<Arc<Source>>,
}

/// What the document was read from.
#[derive(Debug)]
struct Source {
    text: SourceText,
    tree: Tree,
    /// There are comments inside the graph or after it.
    has_inner_comments: bool,
    /// Places of the nodes among the tree's entries, so that messages about many nodes stay cheap.
    nodes: IndexMap<String, usize>,
}

impl Source {
    fn new(text: SourceText, Parsed { tree, has_inner_comments }: Parsed) -> Self {
        let entries = find(&tree, text.text(), "nodes").and_then(|(_, nodes)| nodes.entries());
        let names = entries.into_iter().flatten().enumerate();
        let nodes = names
            .filter_map(|(index, entry)| Some((entry.key.name(text.text())?.to_owned(), index)))
            .collect();
        Self { text, tree, has_inner_comments, nodes }
    }

    /// The name and the value of a node.
    fn node(&self, name: &str) -> Option<(&Tree, &Tree)> {
        let (_, nodes) = find(&self.tree, self.text.text(), "nodes")?;
        let entry = nodes.entries()?.get(*self.nodes.get(name)?)?;
        Some((&entry.key, &entry.value))
    }

    fn locate(&self, at: &[&str], want_key: bool) -> Range<usize> {
        if let ["nodes", name, rest @ ..] = at
            && let Some(node) = self.node(name)
        {
            return locate(node, self.text.text(), rest, want_key);
        }
        locate((&self.tree, &self.tree), self.text.text(), at, want_key)
    }
}

/// A parameter of a graph: another name for a parameter of one of its nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exposed {
    /// `node.param`.
    pub param: Link,
    /// What it does.
    pub doc: String,
    /// Hard limits, inside those of the node's own parameter.
    pub range: Option<(f64, f64)>,
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// An input of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphInput {
    /// The type of its wires.
    pub value_type: ValueType,
    /// What it carries.
    pub doc: String,
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// `node.port`, or `node.param` where a parameter is meant.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Link {
    /// The node's name.
    pub node: String,
    /// The port's or parameter's name.
    pub port: String,
}

impl Link {
    /// The link to `node.port`.
    pub fn new(node: impl Into<String>, port: impl Into<String>) -> Self {
        Self { node: node.into(), port: port.into() }
    }

    /// The link written as `text`, when it is one.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (node, port) = text.split_once('.')?;
        (is_name(node) && !port.is_empty()).then(|| Self::new(node, port))
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.node, self.port)
    }
}

/// One node of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it does.
    pub body: Body,
    /// Its settings; those left out have their defaults.
    pub params: IndexMap<String, Literal>,
    /// Its wires, by input port.
    pub inputs: IndexMap<String, Vec<Link>>,
    /// Set to hand its inputs on untouched.
    pub bypass: bool,
    /// Why it is there.
    pub comment: String,
    /// The plugin that supplies its type, told to who has it not.
    pub plugin: String,
    /// Fields that format 1 does not know; kept for nodes of unknown types, refused for the others.
    pub extra: IndexMap<String, Literal>,
}

/// What a node does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Body {
    /// It runs a node type.
    Type {
        /// The type's id.
        id: String,
        /// The version that its settings were written for; the current one when left out.
        version: Option<u32>,
    },
    /// It is another graph.
    Graph {
        /// The file, relative to this one.
        path: String,
    },
}

impl Node {
    /// A node of a type, at its defaults and without wires.
    pub fn of_type(id: impl Into<String>, version: u32) -> Self {
        Self::new(Body::Type { id: id.into(), version: Some(version) })
    }

    /// A node that is another graph.
    pub fn of_graph(path: impl Into<String>) -> Self {
        Self::new(Body::Graph { path: path.into() })
    }

    fn new(body: Body) -> Self {
        Self {
            body,
            params: IndexMap::new(),
            inputs: IndexMap::new(),
            bypass: false,
            comment: String::new(),
            plugin: String::new(),
            extra: IndexMap::new(),
        }
    }
}

/// What stands where on an editor's canvas; it never changes a result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Where nodes stand.
    pub nodes: IndexMap<String, (f64, f64)>,
    /// Titled rectangles behind them.
    pub frames: Vec<Frame>,
    /// Words between the nodes.
    pub comments: Vec<Comment>,
    /// Wires that do not run straight.
    pub bends: Vec<Bend>,
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// A titled rectangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Its title.
    pub title: String,
    /// Left, top, width, height.
    pub rect: (f64, f64, f64, f64),
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// Words on the canvas, about no node in particular.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comment {
    /// The words.
    pub text: String,
    /// Their left and top.
    pub at: (f64, f64),
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// The places that a wire is led through on its way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bend {
    /// The output that the wire starts from.
    pub from: Link,
    /// The input that it ends at.
    pub to: Link,
    /// The places, in the wire's direction.
    pub through: Vec<(f64, f64)>,
    /// Fields that format 1 does not know: kept, and told as faults.
    pub extra: IndexMap<String, Literal>,
}

/// Equal when they say the same, wherever they were read from and in whichever order.
impl PartialEq for Document {
    fn eq(&self, other: &Self) -> bool {
        self.header == other.header
            && self.doc == other.doc
            && self.expose == other.expose
            && self.inputs == other.inputs
            && self.outputs == other.outputs
            && self.nodes == other.nodes
            && self.layout == other.layout
            && self.extra == other.extra
    }
}

/// Whether `name` may name a node, an exposed parameter, or an input or output of a graph.
#[must_use]
pub fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
}

impl Document {
    /// An empty graph.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads a graph file's bytes; `path` names it in messages.
    ///
    /// # Errors
    /// All that is wrong with the text, each with its place.
    pub fn from_bytes(bytes: &[u8], path: &str) -> Result<Self, DocumentErrors> {
        if bytes.len() > MAX_BYTES {
            return Err(too_large(path, bytes.len()).into());
        }
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::parse(text, path),
            // Its first line would be noise, and what it is no matter of one byte.
            Err(_) if bytes.contains(&0) => {
                let source = SourceText::new(path, "".into());
                Err(DocumentError::at(&source, None, "this is no text, so no graph")
                    .help("give a graph file, such as `terrain.ron`; data are read by a graph's nodes")
                    .into())
            }
            Err(error) => {
                let offset = error.valid_up_to();
                let source = SourceText::new(path, String::from_utf8_lossy(bytes).into());
                let message = format!("byte {offset} is not valid UTF-8");
                Err(DocumentError::at(&source, Some(offset..offset + 1), message)
                    .help("save the file as UTF-8; a graph is text")
                    .into())
            }
        }
    }

    /// Reads a graph file's text; `path` names it in messages.
    ///
    /// # Errors
    /// All that is wrong with the text, each with its place.
    pub fn parse(text: &str, path: &str) -> Result<Self, DocumentErrors> {
        if text.len() > MAX_BYTES {
            return Err(too_large(path, text.len()).into());
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = SourceText::new(path, text.into());
        let parsed = syntax::parse(text).map_err(|error| {
            DocumentErrors::from(
                DocumentError::at(&source, Some(error.span), error.message).maybe_help(error.help),
            )
        })?;
        let mut document = read::document(&source, &parsed.tree)?;
        document.header = canonical_header(&text[..parsed.tree.span.start]);
        document.source = Some(Arc::new(Source::new(source, parsed)));
        Ok(document)
    }

    /// Reads the graph file at `path`.
    ///
    /// # Errors
    /// That it cannot be read, or all that is wrong with its text.
    pub fn load(path: &Path) -> Result<Self, DocumentErrors> {
        let name = path.display().to_string();
        let bytes = read_file(path).map_err(|error| {
            DocumentError::new(format!("{name}: {error}")).help("check the path and that you may read it")
        })?;
        Self::from_bytes(&bytes, &name)
    }

    /// The file that it was read from, as it was named then.
    #[must_use]
    pub fn path(&self) -> Option<&str> {
        self.source.as_ref().map(|source| source.text.path())
    }

    /// Whether the file that it was read from has comments inside the graph or after it, which
    /// [`to_ron`](Self::to_ron) cannot keep.
    #[must_use]
    pub fn has_inner_comments(&self) -> bool {
        self.source.as_ref().is_some_and(|source| source.has_inner_comments)
    }

    /// An error about the value at `at`, such as `["nodes", "dem", "params", "file"]`, or about what holds it
    /// when the text has none there.
    pub(crate) fn error(&self, at: &[&str], message: impl Into<String>) -> DocumentError {
        self.error_about(at, false, message)
    }

    /// An error about the key at `at`.
    pub(crate) fn error_at_key(&self, at: &[&str], message: impl Into<String>) -> DocumentError {
        self.error_about(at, true, message)
    }

    fn error_about(&self, at: &[&str], key: bool, message: impl Into<String>) -> DocumentError {
        let error = match &self.source {
            Some(source) => {
                let span = source.locate(at, key);
                DocumentError::at(&source.text, Some(span), message)
            }
            None => DocumentError::new(message),
        };
        let node = match at {
            ["nodes", node, ..] => Some(*node),
            ["expose", name, ..] => self.expose.get(*name).map(|exposed| exposed.param.node.as_str()),
            ["outputs", name, ..] => self.outputs.get(*name).map(|link| link.node.as_str()),
            _ => None,
        };
        error.about(node.filter(|node| self.nodes.contains_key(*node)))
    }

    /// The text of a node as it was read, when the node still says the same.
    fn verbatim(&self, name: &str) -> Option<&str> {
        let source = self.source.as_ref()?;
        let text = source.text.text();
        let (_, tree) = source.node(name)?;
        let node = read::node_of(&source.text, tree)?;
        (self.nodes.get(name) == Some(&node)).then(|| &text[tree.span.clone()])
    }
}

/// Lines without space at their ends, nor empty ones around them.
fn canonical_header(text: &str) -> String {
    let lines: Vec<_> = text.trim().lines().map(str::trim_end).collect();
    lines.join("\n")
}

/// The bytes of a graph file, no more of them than a graph may have and one.
///
/// # Errors
/// Those of the file system.
pub fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn too_large(path: &str, bytes: usize) -> DocumentError {
    DocumentError::at(
        &SourceText::new(path, "".into()),
        None,
        format!("the file has {bytes} bytes or more; a graph has at most {MAX_BYTES}"),
    )
    .help("is this a graph? Data belong in files of their own")
}

fn find<'a>(tree: &'a Tree, text: &str, name: &str) -> Option<(&'a Tree, &'a Tree)> {
    let entry = tree.entries()?.iter().find(|entry| entry.key.name(text) == Some(name))?;
    Some((&entry.key, &entry.value))
}

fn locate(from: (&Tree, &Tree), text: &str, at: &[&str], want_key: bool) -> Range<usize> {
    let (mut key, mut value) = from;
    for step in at {
        let next = match &value.shape {
            Shape::List(items) | Shape::Tuple(items) => {
                step.parse::<usize>().ok().and_then(|index| items.get(index)).map(|item| (item, item))
            }
            _ => find(value, text, step),
        };
        match next {
            Some(found) => (key, value) = found,
            // Point at the name of what lacks the value, not at all of its text.
            None if want_key || value.entries().is_some() => return key.span.clone(),
            None => return value.span.clone(),
        }
    }
    if want_key { key.span.clone() } else { value.span.clone() }
}
