//! The canonical text of a graph: fixed field order, nodes and settings by name, one thing a line.

use std::fmt::Write;

use indexmap::IndexMap;

use super::{
    Bend, Body, Comment, Document, FORMAT, Layout, Link, Literal, Node, canonical_header, quote,
    syntax::is_space,
};
use crate::Registry;

/// A line longer than this is broken into one setting or wire a line.
const WIDTH: usize = 100;

impl Document {
    /// The graph as text. Reading it gives an equal document, and writing that one the same text. Of comments it has the
    /// [`header`](Self::header) alone.
    ///
    /// A node whose type, or whose version of it, `registry` lacks is written back as it was read.
    #[must_use]
    pub fn to_ron(&self, registry: &Registry) -> String {
        let mut writer = Writer { out: String::new() };
        writer.document(self, registry);
        writer.out
    }
}

/// One node as it stands among a graph's nodes, without indent.
pub(crate) fn node_ron(name: &str, node: &Node) -> String {
    let mut writer = Writer { out: String::new() };
    writer.entry(0, name, node);
    writer.out
}

struct Writer {
    out: String,
}

impl Writer {
    fn line(&mut self, depth: usize, text: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.out, "{:1$}{text}", "", 4 * depth);
    }

    /// `name: {` … `},` around one line for each item; nothing for none.
    fn map<T>(&mut self, name: &str, items: impl Iterator<Item = T>, each: impl Fn(T) -> (String, String)) {
        let mut items = items.peekable();
        if items.peek().is_none() {
            return;
        }
        self.line(1, &format!("{name}: {{"));
        for (key, value) in items.map(each) {
            self.line(2, &format!("{}: {value},", quote(&key)));
        }
        self.line(1, "},");
    }

    fn document(&mut self, document: &Document, registry: &Registry) {
        for line in header_lines(&document.header) {
            self.line(0, &line);
        }
        self.line(0, "(");
        self.line(1, &format!("format: {FORMAT},"));
        if !document.doc.is_empty() {
            self.line(1, &format!("doc: {},", quote(&document.doc)));
        }
        self.map("expose", document.expose.iter(), |(name, exposed)| {
            let mut text = format!("(param: {}", quote(&exposed.param.to_string()));
            push_doc(&mut text, &exposed.doc);
            if let Some((low, high)) = exposed.range {
                let _ = write!(text, ", range: ({low:?}, {high:?})");
            }
            push_extra(&mut text, &exposed.extra);
            (name.clone(), text + ")")
        });
        self.map("inputs", document.inputs.iter(), |(name, input)| {
            let mut text = format!("(type: {}", input.value_type);
            push_doc(&mut text, &input.doc);
            push_extra(&mut text, &input.extra);
            (name.clone(), text + ")")
        });
        self.map("outputs", document.outputs.iter(), |(name, link)| (name.clone(), quote(&link.to_string())));
        if document.nodes.is_empty() {
            self.line(1, "nodes: {},");
        } else {
            self.line(1, "nodes: {");
            for (name, node) in sorted(document.nodes.iter()) {
                self.node(document, registry, name, node);
            }
            self.line(1, "},");
        }
        self.layout(document);
        self.extra(1, &document.extra);
        self.line(0, ")");
    }

    fn node(&mut self, document: &Document, registry: &Registry, name: &str, node: &Node) {
        if !is_known(node, registry)
            && let Some(text) = document.verbatim(name)
        {
            self.line(2, &format!("{}: {text},", quote(name)));
            return;
        }
        self.entry(2, name, node);
    }

    fn entry(&mut self, depth: usize, name: &str, node: &Node) {
        self.line(depth, &format!("{}: (", quote(name)));
        match &node.body {
            Body::Type { id, version: Some(version) } => {
                self.line(depth + 1, &format!("node: {}, version: {version},", quote(id)));
            }
            Body::Type { id, version: None } => self.line(depth + 1, &format!("node: {},", quote(id))),
            Body::Graph { path } => self.line(depth + 1, &format!("graph: {},", quote(path))),
        }
        let plain = node.params.keys().all(|name| is_identifier(name));
        let params = sorted(node.params.iter()).map(|(name, value)| {
            let name = if plain { name.clone() } else { quote(name) };
            format!("{name}: {}", value.to_ron())
        });
        let (open, close) = if plain { ("(", ")") } else { ("{", "}") };
        self.group(depth + 1, "params", open, params.collect(), close);
        let inputs = sorted(node.inputs.iter())
            .map(|(port, links)| format!("{}: {}", quote(port), links_text(links)))
            .collect();
        self.group(depth + 1, "inputs", "{", inputs, "}");
        if node.bypass {
            self.line(depth + 1, "bypass: true,");
        }
        if !node.comment.is_empty() {
            self.line(depth + 1, &format!("comment: {},", quote(&node.comment)));
        }
        if !node.plugin.is_empty() {
            self.line(depth + 1, &format!("plugin: {},", quote(&node.plugin)));
        }
        self.extra(depth + 1, &node.extra);
        self.line(depth, "),");
    }

    /// Fields that this format does not know.
    fn extra(&mut self, depth: usize, fields: &IndexMap<String, Literal>) {
        for (name, value) in sorted(fields.iter()) {
            self.line(depth, &format!("{name}: {},", value.to_ron()));
        }
    }

    /// A field of a node that holds a group: on one line where it fits.
    fn group(&mut self, depth: usize, name: &str, open: &str, items: Vec<String>, close: &str) {
        if items.is_empty() {
            return;
        }
        let line = format!("{name}: {open}{}{close},", items.join(", "));
        if line.chars().count() + 4 * depth <= WIDTH {
            self.line(depth, &line);
            return;
        }
        self.line(depth, &format!("{name}: {open}"));
        for item in items {
            self.line(depth + 1, &format!("{item},"));
        }
        self.line(depth, &format!("{close},"));
    }

    fn layout(&mut self, document: &Document) {
        let layout = &document.layout;
        if *layout == Layout::default() {
            return;
        }
        self.line(1, "layout: (");
        if !layout.nodes.is_empty() {
            self.line(2, "nodes: {");
            for (name, (x, y)) in sorted(layout.nodes.iter()) {
                self.line(3, &format!("{}: ({x:?}, {y:?}),", quote(name)));
            }
            self.line(2, "},");
        }
        if !layout.frames.is_empty() {
            self.line(2, "frames: [");
            for frame in &layout.frames {
                let (x, y, width, height) = frame.rect;
                let title = quote(&frame.title);
                let mut text = format!("(title: {title}, rect: ({x:?}, {y:?}, {width:?}, {height:?})");
                push_extra(&mut text, &frame.extra);
                self.line(3, &format!("{text}),"));
            }
            self.line(2, "],");
        }
        if !layout.comments.is_empty() {
            self.line(2, "comments: [");
            for Comment { text, at: (x, y), extra } in &layout.comments {
                let mut text = format!("(text: {}, at: ({x:?}, {y:?})", quote(text));
                push_extra(&mut text, extra);
                self.line(3, &format!("{text}),"));
            }
            self.line(2, "],");
        }
        if !layout.bends.is_empty() {
            self.line(2, "bends: [");
            for Bend { from, to, through, extra } in &layout.bends {
                let places: Vec<_> = through.iter().map(|(x, y)| format!("({x:?}, {y:?})")).collect();
                let (from, to) = (quote(&from.to_string()), quote(&to.to_string()));
                let mut text = format!("(from: {from}, to: {to}, through: [{}]", places.join(", "));
                push_extra(&mut text, extra);
                self.line(3, &format!("{text}),"));
            }
            self.line(2, "],");
        }
        self.extra(2, &layout.extra);
        self.line(1, "),");
    }
}

/// The lines of a header; what would be no comment in the file becomes one.
fn header_lines(header: &str) -> Vec<String> {
    let header = canonical_header(header);
    let is_comment = is_space(&header);
    let line = |line: &str| match is_comment {
        true => line.to_owned(),
        false => format!("// {line}").trim_end().to_owned(),
    };
    header.lines().map(line).collect()
}

/// Whether the registry has the node's type at the node's version or a later one.
fn is_known(node: &Node, registry: &Registry) -> bool {
    match &node.body {
        Body::Type { id, version } => registry
            .get(id)
            .is_some_and(|known| version.is_none_or(|version| version <= known.spec().version)),
        Body::Graph { .. } => true,
    }
}

fn push_doc(text: &mut String, doc: &str) {
    if !doc.is_empty() {
        let _ = write!(text, ", doc: {}", quote(doc));
    }
}

fn push_extra(text: &mut String, extra: &IndexMap<String, Literal>) {
    for (name, value) in sorted(extra.iter()) {
        let _ = write!(text, ", {name}: {}", value.to_ron());
    }
}

fn links_text(links: &[Link]) -> String {
    match links {
        [link] => quote(&link.to_string()),
        _ => Literal::List(links.iter().map(|link| Literal::Text(link.to_string())).collect()).to_ron(),
    }
}

fn sorted<'a, T: 'a>(items: impl Iterator<Item = (&'a String, T)>) -> impl Iterator<Item = (&'a String, T)> {
    let mut items: Vec<_> = items.collect();
    items.sort_by_key(|(name, _)| *name);
    items.into_iter()
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
