//! The manual says all that a spec says, and its examples are graphs.

mod document_nodes;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use document_nodes::registry;
use orograph_core::{Arity, NodeSpec};
use orograph_engine::{
    CompileOptions, Document, compile,
    manual::{self, Illustration},
};

/// The page of a node in a manual without pictures.
fn page_of(spec: &NodeSpec) -> String {
    let name = manual::page_name(spec, "md");
    let mut book = manual::book(&registry(), &BTreeMap::new()).into_iter();
    book.find(|(file, _)| *file == name).expect("a page").1
}

#[test]
fn pages_tell_all_of_a_spec() {
    for node_type in registry().iter() {
        let spec = node_type.spec();
        for page in [page_of(spec), manual::terminal_page(spec)] {
            for port in spec.inputs.iter().chain(&spec.outputs) {
                assert!(page.contains(&*port.name) && page.contains(&port.value_type.to_string()), "{page}");
            }
            for param in &spec.params {
                assert!(page.contains(&*param.name) && page.contains(&*param.doc), "{page}");
            }
        }
    }
    let smooth = registry().get("filter.smooth").expect("registered").spec().clone();
    let page = page_of(&smooth);
    assert!(page.starts_with("# filter.smooth\n\nSmooths terrain.\n\nVersion 3. "), "{page}");
    assert!(page.contains("| `radius` | number | m | 0.5 to 1000.0 | `10.0` | How far. |"), "{page}");
    assert!(page.contains("| `mask` | Mask, optional | Where. |"), "{page}");
    assert!(page.contains("- `straight_down`: Straight down."), "{page}");
    let page = manual::terminal_page(&smooth);
    assert!(page.contains("radius    number in m, 0.5 to 1000.0, default 10.0"), "{page}");
}

#[test]
fn examples_are_graphs_at_defaults() {
    for node_type in registry().iter() {
        let spec = node_type.spec();
        // Something for the example's inputs to come from.
        let example = manual::example(spec)
            .replace("other.terrain", "dem.terrain")
            .replace("other.pictures", "shade.texture");
        let text = format!(
            "(format: 1, nodes: {{\n{example}, \"dem\": (node: \"io.read\"),\n\"shade\": (node: \"look.shade\", inputs: {{\"terrain\": \"dem.terrain\"}}),\n}})"
        )
        .replace(",\n,", ",");
        let text = if spec.id == "look.shade" {
            text.replace(
                "\"shade\": (node: \"look.shade\", inputs",
                "\"other\": (node: \"look.shade\", inputs",
            )
        } else {
            text
        };
        let document = Document::parse(&text, "x.ron").unwrap_or_else(|errors| panic!("{errors}\n{text}"));
        let options = CompileOptions {
            base_dir: PathBuf::new(),
            overrides: Vec::new(),
            loader: &|_: &Path| Err(std::io::ErrorKind::NotFound.into()),
        };
        if let Err(errors) = compile(&document, &registry(), &options) {
            panic!("{errors}\n{text}");
        }
        assert!(
            spec.inputs.iter().all(|input| input.arity == Arity::Optional || text.contains(&*input.name))
        );
    }
}

#[test]
fn the_book_has_an_index_an_index_of_each_family_and_a_page_for_each_node() {
    let illustration = Illustration {
        doc: "What it shows.".into(),
        graph: "// A comment.\n(format: 1)\n".into(),
        link: "../g.ron".into(),
        tables: vec![("heights".into(), "| `n` |\n|---|\n| 1 |\n".into())],
    };
    let book = manual::book(&registry(), &BTreeMap::from([("io.read".to_owned(), illustration)]));
    let text = |name: &str| &book.iter().find(|(file, _)| file == name).unwrap_or_else(|| panic!("{name}")).1;
    assert_eq!(book[0].0, "index.md");
    assert!(text("index.md").contains("\n## [io](io/index.md)\n"));
    assert!(text("index.md").contains("| [`io.read`](io/read.md) | Reads terrain. |"));
    let family = text("io/index.md");
    assert!(
        family
            .contains("| [`io.read`](read.md) | Reads terrain. | <a href=\"read.md\"><img src=\"read.png\"")
    );
    assert!(family.contains("| [`io.sheet`](sheet.md) |") && !family.contains("sheet.png"));
    let page = text("io/read.md");
    assert!(
        page.contains("![What it shows](read.png)\n\nWhat it shows. ([the graph](../g.ron))\n"),
        "{page}"
    );
    assert!(page.contains("Its table `heights`:\n\n| `n` |"), "{page}");
    assert!(
        page.contains("\n## The graph of the picture\n\n```ron\n// A comment.\n(format: 1)\n```\n"),
        "{page}"
    );
    assert!(!text("io/sheet.md").contains("The graph of the picture"));
}
