//! Graphs to compile, and what came of them.
// Each test file uses its part of this.
#![allow(dead_code)]

use std::path::{Path, PathBuf};

use orograph_core::ParamValue;
use orograph_engine::{
    CompileOptions, Compiled, Document, DocumentErrors, Graph, compile,
    graph::{Action, OutputRef},
};

use crate::document_nodes::registry;

/// Compiles `main.ron` of some files in the folder `graphs`.
pub(crate) fn build(files: &[(&str, &str)], overrides: &[(&str, &str)]) -> Result<Compiled, DocumentErrors> {
    let find = |name: &str| files.iter().find(|(file, _)| *file == name).map(|(_, text)| *text);
    let document = Document::parse(find("main.ron").expect("a main file"), "graphs/main.ron")?;
    let options = CompileOptions {
        base_dir: PathBuf::from("graphs"),
        overrides: overrides.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect(),
        loader: &|path: &Path| {
            let name = path.strip_prefix("graphs").ok().and_then(Path::to_str);
            match name.and_then(find) {
                Some(text) => Ok(text.as_bytes().to_vec()),
                None => Err(std::io::ErrorKind::NotFound.into()),
            }
        },
    };
    compile(&document, &registry(), &options)
}

pub(crate) fn one(nodes: &str) -> Result<Compiled, DocumentErrors> {
    build(&[("main.ron", nodes)], &[])
}

pub(crate) fn values<'a>(graph: &'a Graph, name: &str) -> &'a [ParamValue] {
    match &graph.node(graph.find(name).expect("the node is there")).action {
        Action::Run { values, .. } => values,
        Action::Missing(missing) => panic!("{name} is missing: {missing:?}"),
    }
}

pub(crate) fn source(graph: &Graph, node: &str, input: usize) -> Vec<String> {
    let node = graph.node(graph.find(node).expect("the node is there"));
    node.inputs[input].iter().map(|output: &OutputRef| graph.output_name(*output)).collect()
}

/// A graph of these nodes, each on a line of its own from line 2.
pub(crate) fn graph(nodes: &[&str]) -> String {
    let nodes: String = nodes.iter().map(|node| format!("{node},\n")).collect();
    format!("(format: 1, nodes: {{\n{nodes}}})")
}

pub(crate) const DEM: &str = r#""dem": (node: "io.read", version: 1)"#;

pub(crate) const CHAIN: &str = r#"(
    format: 1,
    expose: {"radius": (param: "smooth.radius", doc: "How far.", range: (1, 50))},
    outputs: {"picture": "shade.texture"},
    nodes: {
        "dem": (node: "io.read", version: 1, params: (file: "data/x.tif")),
        "smooth": (node: "filter.smooth", version: 3, params: (radius: 5, rounds: 2.0, way: straight_down,
            falloff: [(0, 1), (0.5, 0.5)], barriers: [[(0, 0, 1), (2, 2, 3)]]), inputs: {"terrain": "dem.terrain"}),
        "shade": (node: "look.shade", version: 1, inputs: {"terrain": "smooth.terrain"}),
        "sheet": (node: "io.sheet", version: 1, inputs: {"pictures": ["shade.texture", "shade.texture"]}),
    },
)"#;

pub(crate) const INNER: &str = r#"(
    format: 1,
    expose: {"reach": (param: "s.radius", range: (1, 100)), "file": (param: "dem.file")},
    inputs: {"terrain": (type: Heightfield), "spare": (type: Heightfield)},
    outputs: {"terrain": "s.terrain", "raw": "graph.terrain", "file": "dem.terrain"},
    nodes: {
        "dem": (node: "io.read", version: 1, params: (file: "inner.tif")),
        "s": (node: "filter.smooth", version: 3, params: (radius: 2), inputs: {"terrain": "graph.terrain"}),
    },
)"#;
pub(crate) const MIDDLE: &str = r#"(
    format: 1,
    expose: {"reach": (param: "in.reach", range: (1, 60))},
    inputs: {"terrain": (type: Heightfield)},
    outputs: {"terrain": "in.terrain", "raw": "in.raw"},
    nodes: {"in": (graph: "deep/inner.ron", params: {"reach": 3}, inputs: {"terrain": "graph.terrain"})},
)"#;
pub(crate) const OUTER: &str = r#"(
    format: 1,
    expose: {"reach": (param: "mid.reach")},
    outputs: {"all": "mid.terrain", "raw": "mid.raw"},
    nodes: {
        "dem": (node: "io.read", version: 1),
        "mid": (graph: "lib/middle.ron", params: (reach: 4), inputs: {"terrain": "dem.terrain"}),
        "in": (graph: "lib/deep/inner.ron", params: (file: "outer.tif"), inputs: {"terrain": "mid.terrain"}),
        "shade": (node: "look.shade", version: 1, inputs: {"terrain": "in.terrain"}),
    },
)"#;
pub(crate) const NESTED: [(&str, &str); 3] =
    [("main.ron", OUTER), ("lib/middle.ron", MIDDLE), ("lib/deep/inner.ron", INNER)];
