//! What a node of a document offers: its ports and parameters, whether it is of a type, a graph, or unknown here.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use orograph_core::{Arity, NodeSpec, NodeType, ParamSpec, ValueType};
use orograph_engine::{
    Document, Registry,
    compile::MAX_DEPTH,
    document::{Body, GRAPH, Link, Node, read_file},
};

/// What a node is.
#[derive(Clone)]
pub enum Kind {
    /// Of a type that the registry has.
    Type(Arc<NodeType>),
    /// A graph, read from its file.
    Graph(Arc<Document>),
    /// Neither: a placeholder that keeps what it says. Why.
    Unknown(String),
}

/// A port of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// What it carries.
    pub doc: String,
    /// The type of its wires; none where that is not known here.
    pub value_type: Option<ValueType>,
    /// How many wires it takes.
    pub arity: Arity,
}

/// A parameter that a node offers.
#[derive(Clone, Debug, PartialEq)]
pub struct Offered {
    /// The name by which the node's settings call it.
    pub name: String,
    /// What it is; of a graph's exposed parameter, what stands behind it, with the graph's words about it.
    pub spec: ParamSpec,
}

/// What a node offers.
#[derive(Clone)]
pub struct Interface {
    /// What the node is.
    pub kind: Kind,
    /// Its inputs.
    pub inputs: Vec<Port>,
    /// Its outputs.
    pub outputs: Vec<Port>,
    /// Its parameters.
    pub params: Vec<Offered>,
}

impl Interface {
    /// The spec of the node's type, when it has one.
    #[must_use]
    pub fn spec(&self) -> Option<&NodeSpec> {
        match &self.kind {
            Kind::Type(node_type) => Some(node_type.spec()),
            _ => None,
        }
    }

    /// The input of that name.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<&Port> {
        self.inputs.iter().find(|port| port.name == name)
    }

    /// The output of that name.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<&Port> {
        self.outputs.iter().find(|port| port.name == name)
    }

    /// What the node does, in a sentence.
    #[must_use]
    pub fn summary(&self) -> String {
        match &self.kind {
            Kind::Type(node_type) => node_type.spec().summary(),
            Kind::Graph(graph) => graph.doc.clone(),
            Kind::Unknown(reason) => reason.clone(),
        }
    }
}

/// Looks nodes up: in a registry, and in the files of subgraphs, each once, as every frame asks for all of them.
pub struct Interfaces {
    registry: Arc<Registry>,
    folder: PathBuf,
    graphs: HashMap<PathBuf, Result<Arc<Document>, String>>,
    of_types: HashMap<String, Arc<Interface>>,
    of_graphs: HashMap<PathBuf, Arc<Interface>>,
    looks: Vec<(ValueType, Option<String>)>,
}

impl Interfaces {
    /// Looks types up in `registry` and subgraphs relative to `folder`.
    #[must_use]
    pub fn new(registry: Arc<Registry>, folder: PathBuf) -> Self {
        Self {
            registry,
            folder,
            graphs: HashMap::new(),
            of_types: HashMap::new(),
            of_graphs: HashMap::new(),
            looks: Vec::new(),
        }
    }

    /// The node types.
    #[must_use]
    pub fn registry(&self) -> &Arc<Registry> {
        &self.registry
    }

    /// The folder that files are named relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Reads subgraphs again when they are next asked for.
    pub fn forget_graphs(&mut self) {
        self.graphs.clear();
        self.of_graphs.clear();
    }

    /// The node type that shows a value of a type first; see [`looks`](crate::looks).
    pub fn first_look(&mut self, value_type: ValueType) -> Option<String> {
        if let Some((_, look)) = self.looks.iter().find(|(of, _)| *of == value_type) {
            return look.clone();
        }
        let look = crate::looks::first(&self.registry, value_type);
        self.looks.push((value_type, look.clone()));
        look
    }

    /// What a node offers.
    pub fn of(&mut self, name: &str, node: &Node, document: &Document) -> Arc<Interface> {
        let unknown = |reason| Arc::new(unknown(name, node, document, reason));
        match &node.body {
            Body::Type { id, version } => match self.registry.get(id) {
                Some(known) if version.is_none_or(|version| version <= known.spec().version) => {
                    let known = known.clone();
                    self.of_types.entry(id.clone()).or_insert_with(|| Arc::new(of_type(known))).clone()
                }
                Some(known) => {
                    let newest = known.spec().version;
                    unknown(format!("`{id}` is known up to version {newest} here"))
                }
                None if node.plugin.is_empty() => unknown(format!("there is no node type `{id}` here")),
                None => unknown(format!("the plugin `{}` is not here", node.plugin)),
            },
            Body::Graph { path } => {
                let file = self.folder.join(path);
                if let Some(known) = self.of_graphs.get(&file) {
                    return known.clone();
                }
                match self.graph(&file) {
                    Ok(graph) => {
                        let interface = Arc::new(self.of_graph(&file, graph, 0));
                        self.of_graphs.insert(file, interface.clone());
                        interface
                    }
                    Err(reason) => unknown(reason),
                }
            }
        }
    }

    /// The type of what a link gives, where that is known here.
    pub fn type_of(&mut self, link: &Link, document: &Document) -> Option<ValueType> {
        if link.node == GRAPH {
            return document.inputs.get(&link.port).map(|input| input.value_type);
        }
        let node = document.nodes.get(&link.node)?;
        self.of(&link.node, node, document).output(&link.port)?.value_type
    }

    fn graph(&mut self, file: &Path) -> Result<Arc<Document>, String> {
        let read = || {
            let name = file.display().to_string();
            let bytes = read_file(file).map_err(|error| format!("{name}: {error}"))?;
            Document::from_bytes(&bytes, &name).map(Arc::new).map_err(|errors| errors.to_string())
        };
        self.graphs.entry(file.to_owned()).or_insert_with(read).clone()
    }

    fn of_graph(&mut self, file: &Path, graph: Arc<Document>, depth: usize) -> Interface {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let port = |name: &String, doc: &str, value_type, arity| Port {
            name: name.clone(),
            doc: doc.to_owned(),
            value_type,
            arity,
        };
        let inputs = graph.inputs.iter();
        let inputs = inputs.map(|(name, input)| port(name, &input.doc, Some(input.value_type), Arity::Many));
        let inputs = inputs.collect();
        let outputs = graph.outputs.iter().map(|(name, link)| {
            let value_type = self.type_in(&folder, &graph, link, depth);
            port(name, "", value_type, Arity::One)
        });
        let outputs = outputs.collect();
        let params = graph.expose.iter().filter_map(|(name, exposed)| {
            let spec = self.param_in(&folder, &graph, &exposed.param, depth)?;
            let mut spec = ParamSpec { name: name.clone().into(), ..spec };
            if !exposed.doc.is_empty() {
                spec.doc = exposed.doc.clone().into();
            }
            Some(Offered { name: name.clone(), spec })
        });
        let params = params.collect();
        Interface { kind: Kind::Graph(graph), inputs, outputs, params }
    }

    fn inner(&mut self, folder: &Path, graph: &Document, name: &str, depth: usize) -> Option<Interface> {
        if depth > MAX_DEPTH {
            return None;
        }
        let node = graph.nodes.get(name)?;
        match &node.body {
            Body::Type { id, .. } => self.registry.get(id).cloned().map(of_type),
            Body::Graph { path } => {
                let file = folder.join(path);
                let inner = self.graph(&file).ok()?;
                Some(self.of_graph(&file, inner, depth + 1))
            }
        }
    }

    fn type_in(&mut self, folder: &Path, graph: &Document, link: &Link, depth: usize) -> Option<ValueType> {
        if link.node == GRAPH {
            return graph.inputs.get(&link.port).map(|input| input.value_type);
        }
        self.inner(folder, graph, &link.node, depth)?.output(&link.port)?.value_type
    }

    fn param_in(&mut self, folder: &Path, graph: &Document, link: &Link, depth: usize) -> Option<ParamSpec> {
        let offered = self.inner(folder, graph, &link.node, depth)?.params;
        offered.into_iter().find(|param| param.name == link.port).map(|param| param.spec)
    }
}

fn of_type(node_type: Arc<NodeType>) -> Interface {
    let spec = node_type.spec();
    let ports = |ports: &[orograph_core::PortSpec]| {
        let port = |port: &orograph_core::PortSpec| Port {
            name: port.name.to_string(),
            doc: port.doc.to_string(),
            value_type: Some(port.value_type),
            arity: port.arity,
        };
        ports.iter().map(port).collect()
    };
    let params = spec.params.iter();
    let params = params.map(|spec| Offered { name: spec.name.to_string(), spec: spec.clone() }).collect();
    Interface {
        inputs: ports(&spec.inputs),
        outputs: ports(&spec.outputs),
        params,
        kind: Kind::Type(node_type),
    }
}

/// The ports of a node that nobody knows are those that wires name.
fn unknown(name: &str, node: &Node, document: &Document, reason: String) -> Interface {
    let port = |name: &str| Port {
        name: name.to_owned(),
        doc: "of a node that is not known here".into(),
        value_type: None,
        arity: Arity::Many,
    };
    let inputs = node.inputs.keys().map(|input| port(input)).collect();
    let links = document.nodes.values().flat_map(|node| node.inputs.values().flatten());
    let mut outputs: Vec<&str> = links
        .chain(document.outputs.values())
        .filter(|link| link.node == name)
        .map(|link| link.port.as_str())
        .collect();
    outputs.sort_unstable();
    outputs.dedup();
    let outputs = outputs.into_iter().map(port).collect();
    Interface { kind: Kind::Unknown(reason), inputs, outputs, params: Vec::new() }
}
