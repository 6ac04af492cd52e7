//! Readers of what people, and plugins, write as text.

use std::{path::Path, sync::LazyLock};

use orograph_engine::{
    CompileOptions, Document, DocumentErrors, Registry, compile, document::Literal, untrusted,
};
use orograph_session::{Settings, vars};

static REGISTRY: LazyLock<Registry> = LazyLock::new(|| orograph_session::built_in().expect("built-in nodes"));

/// A graph.
pub(super) fn document(bytes: &[u8]) {
    let document = match Document::from_bytes(bytes, "x.ron") {
        Ok(document) => document,
        Err(errors) => return are_told(&errors),
    };
    // What is written is read as the same, and written as the same text.
    let text = document.to_ron(&REGISTRY);
    let back = match Document::parse(&text, "x.ron") {
        Ok(back) => back,
        Err(errors) => panic!("{errors}\n{text}"),
    };
    assert!(back == document, "{text}");
    assert_eq!(back.to_ron(&REGISTRY), text);
    compiles(&document, Vec::new());
}

/// A file of settings: the user's, or of a graph's parameters.
pub(super) fn settings(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = Settings::parse(text, Path::new("settings.ron")) {
        assert!(!error.to_string().is_empty() && error.help().is_some());
    }
    if let Ok(literal) = Literal::parse(text) {
        let text = literal.to_ron();
        assert_eq!(Literal::parse(&text).as_ref(), Ok(&literal), "{text}");
    }
    match vars::parse(text, "x.ron") {
        Ok(overrides) => {
            static GRAPH: LazyLock<Document> =
                LazyLock::new(|| Document::parse(CHAIN, "g.ron").expect("a graph"));
            compiles(&GRAPH, overrides);
        }
        Err(error) => assert!(!error.to_string().is_empty() && error.help().is_some()),
    }
}

/// A graph to be set: numbers, a choice, a path, a curve and lines.
const CHAIN: &str = r#"(
    format: 1,
    expose: {"cells": (param: "hills.cells")},
    nodes: {
        "hills": (node: "generate.fbm", version: 1),
        "bent": (node: "adjust.curve", version: 1, inputs: {"terrain": "hills.terrain"}),
        "painted": (node: "feature.paint", version: 1),
        "tif": (node: "io.write_geotiff", version: 1, inputs: {"terrain": "hills.terrain"}),
    },
)"#;

/// What a plugin says of itself.
pub(super) fn plugin_spec(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match untrusted::plugin_spec(text) {
        Ok(spec) => assert!(!spec.nodes.is_empty()),
        Err(reason) => assert!(!reason.is_empty()),
    }
}

/// Checks a graph, which need not be sound, and reads no other.
fn compiles(document: &Document, overrides: Vec<(String, String)>) {
    let options = CompileOptions {
        base_dir: "nowhere".into(),
        overrides,
        loader: &|_| Err(std::io::ErrorKind::NotFound.into()),
    };
    if let Err(errors) = compile(document, &REGISTRY, &options) {
        are_told(&errors);
    }
}

/// Errors must say what is wrong, and those with a place name it.
fn are_told(errors: &DocumentErrors) {
    assert!(!errors.errors().is_empty() && errors.errors().len() <= DocumentErrors::MOST);
    for error in errors.errors() {
        assert!(!error.message().is_empty());
        assert_eq!(error.line().is_some(), error.line_text().is_some(), "{error}");
        assert!(!error.to_string().is_empty());
    }
}
