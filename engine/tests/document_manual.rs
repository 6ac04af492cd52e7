//! The manual says all that a spec says, and its examples are graphs.

mod document_nodes;

use std::path::{Path, PathBuf};

use document_nodes::registry;
use orograph_core::Arity;
use orograph_engine::{CompileOptions, Document, compile, manual};

#[test]
fn pages_tell_all_of_a_spec() {
    for node_type in registry().iter() {
        let spec = node_type.spec();
        for page in [manual::node_page(spec), manual::terminal_page(spec)] {
            for port in spec.inputs.iter().chain(&spec.outputs) {
                assert!(page.contains(&*port.name) && page.contains(&port.value_type.to_string()), "{page}");
            }
            for param in &spec.params {
                assert!(page.contains(&*param.name) && page.contains(&*param.doc), "{page}");
            }
        }
    }
    let smooth = registry().get("filter.smooth").expect("registered").spec().clone();
    let page = manual::node_page(&smooth);
    assert!(page.starts_with("## filter.smooth\n\nSmooths terrain.\n\nVersion 3. "), "{page}");
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
fn the_book_has_an_index_and_a_file_for_each_family() {
    let book = manual::book(&registry());
    let names: Vec<_> = book.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["index.md", "filter.md", "io.md", "look.md"]);
    assert!(book[0].1.contains("| [`io.read`](io.md#ioread) | Reads terrain. |"), "{}", book[0].1);
    assert!(book[2].1.contains("\n## io.read\n") && book[2].1.contains("\n## io.sheet\n"));
}
