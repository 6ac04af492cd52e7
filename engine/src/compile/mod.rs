//! From a [`Document`] to a checked [`Graph`]: names are looked up, settings typed, subgraphs laid flat.
//!
//! Everything that is wrong is told at once, each with its place. Two things are no errors here, because a
//! graph may never need them: a node of an unknown type, and an input that only an outer graph can supply.
//! Both become [`Missing`] nodes, which are refused when an output needs them.

mod lift;
mod path;
mod scope;
mod settings;
mod typed;
mod values;
mod wires;

use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use orograph_core::{ParamSpec, ParamValue};

pub use lift::{lifted, param_value};
pub use path::{PathError, expand_path};
pub use typed::Refused;

use crate::{
    Graph, GraphBuilder, GraphError, NodeId, OutputRef, Registry,
    document::{Document, DocumentError, DocumentErrors, Link},
    graph::Missing,
    registry::nearest,
    suggest::list,
};
use scope::Scope;

/// More nodes than this, subgraphs laid flat, are refused.
pub const MAX_NODES: usize = 100_000;
/// Graphs inside graphs to this depth.
pub const MAX_DEPTH: usize = 32;

/// Reads the file of a subgraph; [`read_file`](crate::document::read_file) is the usual one.
pub type Loader<'a> = &'a dyn Fn(&Path) -> std::io::Result<Vec<u8>>;

/// What a compilation depends on besides document and registry.
pub struct CompileOptions<'a> {
    /// The graph file's folder.
    pub base_dir: PathBuf,
    /// Settings that replace those of the document, by `node.param`, `outer/inner.param` or exposed name. A
    /// value is RON; text, options and paths may stand without quotes.
    pub overrides: Vec<(String, String)>,
    /// Reads subgraphs.
    pub loader: Loader<'a>,
}

/// A graph ready to run, and what its document says of it.
pub struct Compiled {
    /// The graph.
    pub graph: Graph,
    /// The document's named outputs.
    pub outputs: IndexMap<String, OutputRef>,
    /// The document's exposed parameters.
    pub exposed: IndexMap<String, ExposedParam>,
    /// For each placeholder in the graph, why it is one, with its place in the file.
    pub missing: IndexMap<NodeId, DocumentError>,
    /// Outputs of nodes that are not in the graph themselves: bypassed nodes and subgraphs.
    aliases: IndexMap<String, OutputRef>,
}

/// A parameter of the graph as a whole.
#[derive(Clone, Debug)]
pub struct ExposedParam {
    /// What it does.
    pub doc: String,
    /// Hard limits, inside those of `spec`.
    pub range: Option<(f64, f64)>,
    /// The parameter behind it, which tells its type and unit.
    pub spec: ParamSpec,
    /// The node behind it; none when that is bypassed.
    pub node: Option<NodeId>,
    /// The value that it has here.
    pub value: ParamValue,
}

impl Compiled {
    /// The output that `text` names: a named output of the document, `node.output`, or `node` when that has
    /// one output alone.
    ///
    /// # Errors
    /// That there is none, with the nearest name; for a node of unknown type, why it is unknown.
    pub fn output(&self, text: &str) -> Result<OutputRef, DocumentError> {
        if let Some(output) = self.outputs.get(text).or_else(|| self.aliases.get(text)) {
            return Ok(*output);
        }
        let names = self.output_names();
        let whole = format!("{text}.");
        let of_node: Vec<_> = names.iter().filter(|(name, _)| name.starts_with(&whole)).collect();
        if let [(_, output)] = of_node[..] {
            return Ok(*output);
        }
        if let Some((_, output)) = names.iter().find(|(name, _)| name == text) {
            return Ok(*output);
        }
        let node = text.rsplit_once('.').map_or(text, |(node, _)| node);
        if let Some((_, unknown)) = self.missing.iter().find(|(id, _)| self.graph.node(**id).name == node) {
            return Err(unknown.clone());
        }
        let error = DocumentError::new(format!("the graph has no output `{text}`"));
        if !of_node.is_empty() {
            let all: Vec<_> = of_node.iter().map(|(name, _)| name.as_str()).collect();
            return Err(error.help(format!("name one of {}", all.join(", "))));
        }
        let all = names.iter().map(|(name, _)| name.as_str()).chain(self.outputs.keys().map(String::as_str));
        Err(match nearest(text, all) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help(format!("its named outputs are {}", list(self.outputs.keys()))),
        })
    }

    /// Every `node.output`, with those of bypassed nodes and subgraphs.
    fn output_names(&self) -> Vec<(String, OutputRef)> {
        let mut names: Vec<_> = self.aliases.iter().map(|(name, output)| (name.clone(), *output)).collect();
        for (index, node) in self.graph.nodes().iter().enumerate() {
            let id = NodeId(u32::try_from(index).unwrap_or(u32::MAX));
            let outputs = node.spec().map_or(0, |spec| spec.outputs.len());
            for output in 0..u32::try_from(outputs).unwrap_or(u32::MAX) {
                let output = OutputRef { node: id, output };
                names.push((self.graph.output_name(output), output));
            }
        }
        names
    }
}

/// Checks a document against a registry and makes a graph of it.
///
/// # Errors
/// All that is wrong with the document, its subgraphs and the overrides.
pub fn compile(
    document: &Document,
    registry: &Registry,
    options: &CompileOptions<'_>,
) -> Result<Compiled, DocumentErrors> {
    let mut compiler = Compiler {
        registry,
        options,
        scopes: Vec::new(),
        builder: GraphBuilder::new(),
        places: IndexMap::new(),
        missing: IndexMap::new(),
        stand_ins: IndexMap::new(),
        errors: Vec::new(),
    };
    compiler.expand_root(document);
    let given = compiler.settings();
    let values = compiler.add_nodes(&given);
    compiler.connect_all();
    let outputs = compiler.outputs();
    let aliases = compiler.aliases();
    let exposed = compiler.exposed(&values);
    let Compiler { builder, scopes, places, missing, mut errors, .. } = compiler;
    match builder.build() {
        Ok(graph) if errors.is_empty() => return Ok(Compiled { graph, outputs, exposed, missing, aliases }),
        Ok(_) => {}
        // Every other fault was found, with its place, while the parts were put in.
        Err(error @ GraphError::Cycle { .. }) => errors.push(cycle_error(&error, &scopes, &places)),
        Err(error) if errors.is_empty() => errors.push(DocumentError::new(error.to_string())),
        Err(_) => {}
    }
    Err(DocumentErrors::new(errors))
}

fn cycle_error(error: &GraphError, scopes: &[Scope], places: &IndexMap<NodeId, Place>) -> DocumentError {
    let GraphError::Cycle { path } = error else { return DocumentError::new(error.to_string()) };
    let outer = path.first().and_then(|first| first.split('/').next());
    let place = path.first().and_then(|first| {
        places.values().find(|place| format!("{}{}", scopes[place.scope].prefix, place.node) == *first)
    });
    let error = match place {
        Some(place) => scopes[place.scope].document.error_at_key(&["nodes", &place.node], error.to_string()),
        None => DocumentError::new(error.to_string()).about(outer),
    };
    error.label("the cycle passes here").help("remove one of the wires on it")
}

/// Which node of which scope a node of the flat graph comes from.
struct Place {
    scope: usize,
    node: String,
}

struct Compiler<'a> {
    registry: &'a Registry,
    options: &'a CompileOptions<'a>,
    /// The document and every subgraph, each time that it is used; outer before inner.
    scopes: Vec<Scope>,
    builder: GraphBuilder,
    places: IndexMap<NodeId, Place>,
    missing: IndexMap<NodeId, DocumentError>,
    /// Placeholders for outputs that there are none of, by what they stand for.
    stand_ins: IndexMap<String, NodeId>,
    errors: Vec<DocumentError>,
}

impl Compiler<'_> {
    /// As many errors as are told were found; looking on would only take time.
    fn has_enough_errors(&self) -> bool {
        self.errors.len() >= DocumentErrors::MOST
    }

    /// Reports an error, once.
    fn report(&mut self, error: DocumentError) {
        // One file may be used for several nodes; without a file, nodes alone tell errors apart.
        let same = |other: &DocumentError| {
            (other.span(), other.path(), other.message()) == (error.span(), error.path(), error.message())
                && (error.path().is_some() || other.node() == error.node())
        };
        if !self.has_enough_errors() && !self.errors.iter().any(same) {
            self.errors.push(error);
        }
    }

    /// Adds a placeholder and remembers why.
    fn add_missing(&mut self, name: &str, id: &str, error: DocumentError) -> Option<NodeId> {
        let mut reason = error.message().to_owned();
        if let Some(help) = error.help_text() {
            reason = format!("{reason}; {help}");
        }
        match self.builder.add_missing(name, Missing { id: id.into(), reason }) {
            Ok(node) => {
                self.missing.insert(node, error);
                Some(node)
            }
            Err(error) => {
                self.report(DocumentError::new(error.to_string()));
                None
            }
        }
    }

    /// The named outputs of the outermost document.
    fn outputs(&mut self) -> IndexMap<String, OutputRef> {
        let Some(root) = self.scopes.first() else { return IndexMap::new() };
        let document = root.document.clone();
        let mut outputs = IndexMap::new();
        for (name, link) in &document.outputs {
            if let Some(output) = self.output_of(0, link, &["outputs", name]) {
                outputs.insert(name.clone(), output);
            }
        }
        outputs
    }

    /// Exposed parameters of the outermost document, with their values.
    fn exposed(&mut self, values: &values::Values) -> IndexMap<String, ExposedParam> {
        let Some(root) = self.scopes.first() else { return IndexMap::new() };
        let document = root.document.clone();
        let mut exposed = IndexMap::new();
        for (name, entry) in &document.expose {
            let Some((scope, Link { node, port })) = self.target(0, &entry.param) else { continue };
            let Some((spec, value)) =
                values.get(&(scope, node.clone())).and_then(|values| values.find(&port))
            else {
                continue;
            };
            let param = ExposedParam {
                doc: if entry.doc.is_empty() { spec.doc.to_string() } else { entry.doc.clone() },
                range: entry.range,
                spec: spec.clone(),
                node: self.scopes[scope].ids.get(&node).copied(),
                value: value.clone(),
            };
            exposed.insert(name.clone(), param);
        }
        exposed
    }
}
