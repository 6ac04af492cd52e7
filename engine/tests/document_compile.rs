//! From document to graph: what compiles, and what each fault says of itself.

mod document_nodes;

use std::path::{Path, PathBuf};

use document_nodes::registry;
use orograph_core::ParamValue;
use orograph_engine::{
    CompileOptions, Compiled, Document, DocumentErrors, Graph, compile,
    graph::{Action, OutputRef},
};

/// Compiles `main.ron` of some files in the folder `graphs`.
fn build(files: &[(&str, &str)], overrides: &[(&str, &str)]) -> Result<Compiled, DocumentErrors> {
    let find = |name: &str| files.iter().find(|(file, _)| *file == name).map(|(_, text)| *text);
    let document = Document::parse(find("main.ron").unwrap(), "graphs/main.ron")?;
    let options = CompileOptions {
        base_dir: PathBuf::from("graphs"),
        overrides: overrides.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect(),
        loader: &|path: &Path| {
            let name = path.strip_prefix("graphs").unwrap().to_str().unwrap();
            match find(name) {
                Some(text) => Ok(text.as_bytes().to_vec()),
                None => Err(std::io::ErrorKind::NotFound.into()),
            }
        },
    };
    compile(&document, &registry(), &options)
}

fn one(nodes: &str) -> Result<Compiled, DocumentErrors> {
    build(&[("main.ron", nodes)], &[])
}

fn values<'a>(graph: &'a Graph, name: &str) -> &'a [ParamValue] {
    match &graph.node(graph.find(name).unwrap()).action {
        Action::Run { values, .. } => values,
        Action::Missing(missing) => panic!("{name} is missing: {missing:?}"),
    }
}

fn source(graph: &Graph, node: &str, input: usize) -> Vec<String> {
    let node = graph.node(graph.find(node).unwrap());
    node.inputs[input].iter().map(|output: &OutputRef| graph.output_name(*output)).collect()
}

const CHAIN: &str = r#"(
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

#[test]
fn a_graph_compiles_with_typed_settings_and_wires() {
    let compiled = one(CHAIN).unwrap();
    let graph = &compiled.graph;
    let settings = values(graph, "smooth");
    assert_eq!(settings[0], ParamValue::Number(5.0));
    assert_eq!(settings[1], ParamValue::Integer(2));
    assert_eq!(settings[2], ParamValue::Text("straight_down".into()));
    assert_eq!(settings[5], ParamValue::Curve(vec![[0.0, 1.0], [0.5, 0.5]]));
    assert_eq!(settings[6], ParamValue::Lines(vec![vec![[0.0, 0.0, 1.0], [2.0, 2.0, 3.0]]]));
    assert_eq!(source(graph, "smooth", 0), ["dem.terrain"]);
    assert_eq!(source(graph, "sheet", 0), ["shade.texture", "shade.texture"]);
    assert_eq!(graph.output_name(compiled.outputs["picture"]), "shade.texture");
    assert_eq!(compiled.exposed["radius"].value, ParamValue::Number(5.0));
    let dem = graph.node(graph.find("dem").unwrap());
    assert_eq!(dem.base_dir("data/x.tif"), Path::new("graphs"));
}
