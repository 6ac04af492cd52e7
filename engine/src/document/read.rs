//! From the syntax tree to the model.

use indexmap::IndexMap;

use super::{
    Bend, Body, Comment, Document, DocumentError, DocumentErrors, Exposed, FORMAT, Frame, GRAPH, GraphInput,
    Layout, Link, Literal, Node, SourceText,
    fields::{BEND, COMMENT, DOCUMENT, EXPOSED, FRAME, INPUT, LAYOUT, NODE_FIELDS},
    is_name,
    syntax::{Entry, Shape, Tree},
    types::value_type,
};
use crate::{registry::nearest, suggest::suggest};

pub(super) fn document(source: &SourceText, tree: &Tree) -> Result<Document, DocumentErrors> {
    let mut reader = Reader { source, errors: Vec::new(), unknown: Vec::new() };
    let document = reader.document(tree);
    if reader.errors.is_empty() {
        return Ok(document);
    }
    // Beside what cannot be read they are slips of the pen, and may be what is wrong.
    reader.errors.append(&mut reader.unknown);
    Err(DocumentErrors::new(reader.errors))
}

/// The node that `tree` describes, when it describes one without fault.
pub(super) fn node_of(source: &SourceText, tree: &Tree) -> Option<Node> {
    let mut reader = Reader { source, errors: Vec::new(), unknown: Vec::new() };
    reader.node("", tree).filter(|_| reader.errors.is_empty())
}

/// Fields that are known, and those that are not.
type Fields<'t> = (IndexMap<&'t str, &'t Entry>, IndexMap<String, Literal>);

struct Reader<'a> {
    source: &'a SourceText,
    errors: Vec<DocumentError>,
    /// Fields that are kept, though not known.
    unknown: Vec<DocumentError>,
}

impl<'a> Reader<'a> {
    fn text(&self) -> &'a str {
        self.source.text()
    }

    fn report(&mut self, tree: &Tree, message: impl Into<String>, help: Option<String>) {
        // A hostile file can hold a million faults; more than are told need not be kept.
        if self.errors.len() < DocumentErrors::MOST {
            let error = DocumentError::at(self.source, Some(tree.span.clone()), message);
            self.errors.push(error.maybe_help(help));
        }
    }

    fn expected(&mut self, tree: &Tree, what: &str) {
        self.report(tree, format!("expected {what}, found {}", tree.noun()), None);
    }

    /// The entries of a struct or map by name, each name once.
    fn entries<'t>(&mut self, tree: &'t Tree, what: &str) -> IndexMap<&'t str, &'t Entry>
    where
        'a: 't,
    {
        let Some(entries) = tree.entries() else {
            self.expected(tree, what);
            return IndexMap::new();
        };
        let mut by_name = IndexMap::with_capacity(entries.len());
        for entry in entries {
            let text: &'t str = self.source.text();
            let Some(name) = entry.key.name(text) else {
                self.expected(&entry.key, "a name");
                continue;
            };
            if by_name.insert(name, entry).is_some() {
                let help = Some("remove one of the two, or give it another name".to_owned());
                self.report(&entry.key, format!("`{name}` stands here twice"), help);
            }
        }
        by_name
    }

    /// The fields of a struct: the `known`, and what others hold.
    fn fields<'t>(&mut self, tree: &'t Tree, what: &str, known: &[&str]) -> Fields<'t>
    where
        'a: 't,
    {
        let mut fields = self.entries(tree, what);
        let mut extra = IndexMap::new();
        fields.retain(|name, entry| {
            if !known.contains(name) {
                self.keep(&mut extra, name, entry);
                if self.unknown.len() < DocumentErrors::MOST {
                    let message = format!("there is no field `{name}` here");
                    let error = DocumentError::at(self.source, Some(entry.key.span.clone()), message);
                    self.unknown.push(error.help(suggest(name, known.iter().copied(), "fields")));
                }
            }
            known.contains(name)
        });
        (fields, extra)
    }

    /// Keeps a field that is not known, as long as it can be written back.
    fn keep(&mut self, extra: &mut IndexMap<String, Literal>, name: &str, entry: &Entry) {
        if !matches!(entry.key.shape, Shape::Word) {
            self.expected(&entry.key, "a field's name without quotes");
        }
        extra.insert(name.to_owned(), Literal::of(&entry.value, self.text()));
    }

    /// A map of named things, each read by `each`.
    fn named<T>(
        &mut self,
        tree: &Tree,
        what: &str,
        mut each: impl FnMut(&mut Self, &str, &Tree) -> Option<T>,
    ) -> IndexMap<String, T> {
        let mut things = IndexMap::new();
        for (name, entry) in self.entries(tree, what) {
            if !is_name(name) {
                let help = "a name starts with a letter and has letters, digits, `_` and `-` alone";
                self.report(&entry.key, format!("`{}` is no name", name.escape_debug()), Some(help.into()));
            }
            if let Some(thing) = each(self, name, &entry.value) {
                things.insert(name.to_owned(), thing);
            }
        }
        things
    }

    fn string(&mut self, tree: &Tree) -> Option<String> {
        match &tree.shape {
            Shape::Text(text) => Some(text.clone()),
            _ => {
                self.expected(tree, "a string");
                None
            }
        }
    }

    fn number(&mut self, tree: &Tree) -> Option<f64> {
        match Literal::of(tree, self.text()) {
            Literal::Integer(value) => Some(value as f64),
            Literal::Number(value) => Some(value),
            _ if matches!(tree.shape, Shape::Number) => {
                self.report(tree, "this number is too large to hold, or no number", None);
                None
            }
            _ => {
                self.expected(tree, "a number");
                None
            }
        }
    }

    /// A tuple or list of `N` numbers.
    fn numbers<const N: usize>(&mut self, tree: &Tree) -> Option<[f64; N]> {
        match &tree.shape {
            Shape::Tuple(items) | Shape::List(items) if items.len() == N => {
                let mut numbers = [0.0; N];
                for (number, item) in numbers.iter_mut().zip(items) {
                    *number = self.number(item)?;
                }
                Some(numbers)
            }
            _ => {
                self.expected(tree, &format!("{N} numbers in parentheses"));
                None
            }
        }
    }

    fn link(&mut self, tree: &Tree, what: &str) -> Option<Link> {
        let text = self.string(tree)?;
        let link = Link::parse(&text);
        if link.is_none() {
            let help = "a link names a node of this graph, then a dot, then the port".to_owned();
            self.report(tree, format!("expected \"{what}\", found \"{}\"", text.escape_debug()), Some(help));
        }
        link
    }

    fn document(&mut self, tree: &Tree) -> Document {
        let Some(format) = tree.entries().map(|_| self.entries(tree, "").get("format").copied()) else {
            self.expected(tree, "a graph in parentheses, as in `(format: 1, nodes: {…})`");
            return Document::new();
        };
        // Repeated names were reported by that first look; the second one reports them again.
        self.errors.clear();
        match format {
            None => {
                let help = format!("write `format: {FORMAT},` first");
                let start = Tree { span: tree.span.start..tree.span.start + 1, shape: Shape::Other };
                self.report(&start, "the graph does not say its `format`", Some(help));
            }
            Some(entry) => match Literal::of(&entry.value, self.text()) {
                Literal::Integer(FORMAT) => {}
                Literal::Integer(other) => {
                    let help = format!("this program reads format {FORMAT}; a newer one may read this file");
                    self.report(&entry.value, format!("graph format {other} is unknown"), Some(help));
                    return Document::new();
                }
                _ => self.expected(&entry.value, &format!("the format version, {FORMAT}")),
            },
        }
        let mut document = Document::new();
        let (fields, extra) = self.fields(tree, "a graph in parentheses", &DOCUMENT);
        document.extra = extra;
        if !fields.contains_key("nodes") {
            let start = Tree { span: tree.span.start..tree.span.start + 1, shape: Shape::Other };
            self.report(&start, "the graph has no `nodes`", Some("write `nodes: {}` for none".into()));
        }
        for (name, entry) in fields {
            let value = &entry.value;
            match name {
                "doc" => document.doc = self.string(value).unwrap_or_default(),
                "expose" => document.expose = self.named(value, "a map of parameters", Self::exposed),
                "inputs" => document.inputs = self.named(value, "a map of inputs", Self::input),
                "outputs" => {
                    document.outputs = self
                        .named(value, "a map of outputs", |reader, _, tree| reader.link(tree, "node.output"));
                }
                "nodes" => document.nodes = self.named(value, "a map of nodes", Self::node),
                "layout" => document.layout = self.layout(value),
                _ => {}
            }
        }
        document
    }

    fn exposed(&mut self, _: &str, tree: &Tree) -> Option<Exposed> {
        let (fields, extra) = self.fields(tree, "`(param: \"node.param\")`", &EXPOSED);
        let mut exposed = Exposed { extra, ..Exposed::default() };
        if let Some(entry) = fields.get("doc") {
            exposed.doc = self.string(&entry.value)?;
        }
        if let Some(entry) = fields.get("range") {
            let [low, high] = self.numbers(&entry.value)?;
            if low > high {
                self.report(&entry.value, format!("this range ends at {high}, below its start {low}"), None);
            }
            exposed.range = Some((low, high));
        }
        match fields.get("param") {
            Some(entry) => exposed.param = self.link(&entry.value, "node.param")?,
            None if tree.entries().is_some() => self.report(tree, "`param` is missing here", None),
            None => {}
        }
        Some(exposed)
    }

    fn input(&mut self, _: &str, tree: &Tree) -> Option<GraphInput> {
        let (fields, extra) = self.fields(tree, "`(type: Heightfield)`", &INPUT);
        let doc = match fields.get("doc") {
            Some(entry) => self.string(&entry.value)?,
            None => String::new(),
        };
        let Some(entry) = fields.get("type") else {
            if tree.entries().is_some() {
                self.report(tree, "`type` is missing here", Some("write `type: Heightfield`".into()));
            }
            return None;
        };
        let Some(name) = entry.value.name(self.text()) else {
            self.expected(&entry.value, "a type, such as Heightfield");
            return None;
        };
        match value_type(name) {
            Ok(value_type) => Some(GraphInput { value_type, doc, extra }),
            Err(help) => {
                self.report(&entry.value, format!("there is no type `{name}`"), Some(help));
                None
            }
        }
    }

    fn node(&mut self, name: &str, tree: &Tree) -> Option<Node> {
        if name == GRAPH {
            let help = Some("give the node another name".to_owned());
            self.report(tree, format!("`{GRAPH}` stands for the graph itself"), help);
        }
        let fields = self.entries(tree, "a node, as in `(node: \"family.algorithm\", version: 1)`");
        let body = self.body(tree, &fields);
        let mut node = Node::of_graph("");
        for (name, entry) in fields {
            let value = &entry.value;
            match name {
                "params" => {
                    let params = self.entries(value, "parameters, as in `(name: value)`");
                    let text = self.text();
                    node.params = params
                        .iter()
                        .map(|(name, entry)| ((*name).to_owned(), Literal::of(&entry.value, text)))
                        .collect();
                }
                "inputs" => {
                    for (port, entry) in self.entries(value, "inputs, as in `{\"port\": \"node.output\"}`") {
                        let links = self.links(&entry.value);
                        node.inputs.insert(port.to_owned(), links);
                    }
                }
                "bypass" => match Literal::of(value, self.text()) {
                    Literal::Boolean(bypass) => node.bypass = bypass,
                    _ => self.expected(value, "`true` or `false`"),
                },
                "comment" => node.comment = self.string(value).unwrap_or_default(),
                "plugin" => node.plugin = self.string(value).unwrap_or_default(),
                name if NODE_FIELDS.contains(&name) => {}
                _ => self.keep(&mut node.extra, name, entry),
            }
        }
        node.body = body?;
        Some(node)
    }

    fn body(&mut self, tree: &Tree, fields: &IndexMap<&str, &Entry>) -> Option<Body> {
        match (fields.get("node"), fields.get("graph")) {
            (Some(id), None) => {
                let version = match fields.get("version") {
                    None => None,
                    Some(entry) => match Literal::of(&entry.value, self.text()) {
                        Literal::Integer(version) if (1..=i64::from(u32::MAX)).contains(&version) => {
                            u32::try_from(version).ok()
                        }
                        _ => {
                            self.report(
                                &entry.value,
                                "expected the node's version, a whole number from 1",
                                None,
                            );
                            None
                        }
                    },
                };
                Some(Body::Type { id: self.string(&id.value)?, version })
            }
            (None, Some(path)) => {
                if let Some(version) = fields.get("version") {
                    let help = Some("remove it; the file says its own format".to_owned());
                    self.report(&version.key, "a graph used as a node has no `version`", help);
                }
                Some(Body::Graph { path: self.string(&path.value)? })
            }
            (Some(_), Some(path)) => {
                let help = Some("keep one of the two".to_owned());
                self.report(&path.key, "a node is either of a `node` type or a `graph`, not both", help);
                None
            }
            (None, None) => {
                if tree.entries().is_some() {
                    let help = "write `node: \"family.algorithm\"`, or `graph: \"file.ron\"`".to_owned();
                    let near = fields.iter().find_map(|(name, entry)| {
                        nearest(name, NODE_FIELDS).filter(|near| near != name).map(|near| (name, near, entry))
                    });
                    match near {
                        Some((name, near, entry)) => self.report(
                            &entry.key,
                            format!("there is no field `{name}` here"),
                            Some(format!("did you mean `{near}`?")),
                        ),
                        None => self.report(tree, "the node does not say its type", Some(help)),
                    }
                }
                None
            }
        }
    }

    fn links(&mut self, tree: &Tree) -> Vec<Link> {
        match &tree.shape {
            Shape::List(items) => items.iter().filter_map(|item| self.link(item, "node.output")).collect(),
            Shape::Text(_) => self.link(tree, "node.output").into_iter().collect(),
            _ => {
                self.expected(tree, "\"node.output\" or a list of such");
                Vec::new()
            }
        }
    }

    fn layout(&mut self, tree: &Tree) -> Layout {
        let (fields, extra) = self.fields(tree, "`(nodes: {…}, frames: […])`", &LAYOUT);
        let mut layout = Layout { extra, ..Layout::default() };
        if let Some(entry) = fields.get("nodes") {
            layout.nodes = self.named(&entry.value, "a map of positions", |reader, _, tree| {
                reader.numbers(tree).map(|[x, y]| (x, y))
            });
        }
        layout.frames = self.list(fields.get("frames").copied(), "a list of frames", Self::frame);
        layout.comments = self.list(fields.get("comments").copied(), "a list of comments", Self::comment);
        layout.bends = self.list(fields.get("bends").copied(), "a list of bent wires", Self::bend);
        layout
    }

    fn list<T>(
        &mut self,
        entry: Option<&Entry>,
        what: &str,
        mut item: impl FnMut(&mut Self, &Tree) -> Option<T>,
    ) -> Vec<T> {
        let Some(entry) = entry else { return Vec::new() };
        match &entry.value.shape {
            Shape::List(items) => items.iter().filter_map(|tree| item(self, tree)).collect(),
            _ => {
                self.expected(&entry.value, what);
                Vec::new()
            }
        }
    }

    /// A field without which its struct says nothing.
    fn needed<'t>(
        &mut self,
        tree: &Tree,
        fields: &IndexMap<&str, &'t Entry>,
        name: &str,
    ) -> Option<&'t Tree> {
        let field = fields.get(name);
        if field.is_none() && tree.entries().is_some() {
            self.report(tree, format!("`{name}` is missing here"), None);
        }
        field.map(|entry| &entry.value)
    }

    fn comment(&mut self, tree: &Tree) -> Option<Comment> {
        let (fields, extra) = self.fields(tree, "`(text: \"…\", at: (x, y))`", &COMMENT);
        let (text, at) = (self.needed(tree, &fields, "text"), self.needed(tree, &fields, "at"));
        let (text, [x, y]) = (self.string(text?)?, self.numbers(at?)?);
        Some(Comment { text, at: (x, y), extra })
    }

    fn bend(&mut self, tree: &Tree) -> Option<Bend> {
        let what = "`(from: \"node.output\", to: \"node.input\", through: [(x, y), …])`";
        let (fields, extra) = self.fields(tree, what, &BEND);
        let (from, to) = (self.needed(tree, &fields, "from"), self.needed(tree, &fields, "to"));
        let (from, to) = (self.link(from?, "node.output")?, self.link(to?, "node.input")?);
        let through = self.list(fields.get("through").copied(), "a list of places", |reader, tree| {
            reader.numbers(tree).map(|[x, y]| (x, y))
        });
        Some(Bend { from, to, through, extra })
    }

    fn frame(&mut self, tree: &Tree) -> Option<Frame> {
        let (fields, extra) = self.fields(tree, "`(title: \"…\", rect: (x, y, width, height))`", &FRAME);
        let title = match fields.get("title") {
            Some(entry) => self.string(&entry.value)?,
            None => String::new(),
        };
        let rect = self.needed(tree, &fields, "rect")?;
        let [x, y, width, height] = self.numbers(rect)?;
        Some(Frame { title, rect: (x, y, width, height), extra })
    }
}
