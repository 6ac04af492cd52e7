//! Every built-in node has a graph that shows it, and its picture is small. What the pictures show, `orograph manual
//! --check` compares.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use orograph_engine::{Document, document::Body, manual::page_name};

const GRAPHS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/graphs/nodes");
const MANUAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/manual");

fn graphs() -> Vec<(String, PathBuf)> {
    let paths = fs::read_dir(GRAPHS).unwrap().map(|entry| entry.unwrap().path());
    let mut graphs: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "ron"))
        .map(|path| (path.file_stem().unwrap().to_string_lossy().into_owned(), path))
        .collect();
    graphs.sort();
    graphs
}

#[test]
fn every_node_has_a_graph_that_shows_it() {
    let registry = orograph_session::built_in().unwrap();
    let with: BTreeSet<String> = graphs().into_iter().map(|(id, _)| id).collect();
    let nodes: BTreeSet<String> = registry.iter().map(|node_type| node_type.spec().id.to_string()).collect();
    let without: Vec<_> = nodes.difference(&with).collect();
    assert!(without.is_empty(), "no graph in graphs/nodes shows {without:?}");
    let strange: Vec<_> = with.difference(&nodes).collect();
    assert!(strange.is_empty(), "graphs in graphs/nodes of no node: {strange:?}");
    for (id, path) in graphs() {
        let document = Document::load(&path).unwrap_or_else(|errors| panic!("{errors}"));
        let shows = |body: &Body| matches!(body, Body::Type { id: found, .. } if *found == id);
        assert!(document.nodes.values().any(|node| shows(&node.body)), "{id}.ron has no node {id}");
    }
}

#[test]
fn they_are_as_the_program_writes_them() {
    let registry = orograph_session::built_in().unwrap();
    for (id, path) in graphs() {
        let document = Document::load(&path).unwrap_or_else(|errors| panic!("{errors}"));
        assert!(
            document.to_ron(&registry) == fs::read_to_string(&path).unwrap(),
            "{id}.ron is laid out otherwise"
        );
    }
}

#[test]
fn pictures_are_small() {
    /// A page shows them at their size.
    const WIDEST: u32 = 760;
    const MOST: u64 = 5_000_000;
    let registry = orograph_session::built_in().unwrap();
    let mut bytes = 0;
    for node_type in registry.iter() {
        let file = Path::new(MANUAL).join(page_name(node_type.spec(), "png"));
        let picture = orograph_session::pictures::read(&file).unwrap_or_else(|error| panic!("{error}"));
        assert!(picture.grid().cols <= WIDEST as usize, "{} is too wide", file.display());
        bytes += fs::metadata(&file).unwrap().len();
    }
    assert!(bytes <= MOST, "the manual's pictures have {bytes} bytes");
}
