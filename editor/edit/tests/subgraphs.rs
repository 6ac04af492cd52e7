//! Nodes folded into a graph and laid out again give the same results.
#![allow(clippy::unwrap_used)]

mod common;

use std::{fs, path::Path, sync::Arc};

use common::{chain, registry};
use orograph_core::Digest;
use orograph_edit::{Interfaces, subgraph};
use orograph_engine::{
    Cache, CancelToken, CompileOptions, Document, Evaluator, Registry, Request, compile, document::read_file,
    eval::Silent,
};

/// The digest of the document's output.
fn result(document: &Document, registry: &Registry, folder: &Path) -> Digest {
    let options = CompileOptions {
        base_dir: folder.to_owned(),
        overrides: Vec::new(),
        loader: &|path| read_file(path),
    };
    let compiled = compile(document, registry, &options).unwrap();
    let output = compiled.output("picture").unwrap();
    let request = Request::values(Arc::new(compiled.graph), vec![output]);
    let evaluator = Evaluator::new(Cache::new(1 << 28, None), 2).unwrap();
    let report = evaluator.run(request, Arc::new(Silent), &CancelToken::new());
    report.values[0].as_ref().unwrap().digest()
}

#[test]
fn what_was_folded_gives_the_same_and_so_does_what_is_laid_out_again() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let flat = chain(&registry);
    let expected = result(&flat, &registry, folder.path());
    let mut interfaces = Interfaces::new(registry.clone(), folder.path().to_owned());
    for names in [&["soft"][..], &["soft", "shade"], &["hills", "soft", "shade"], &["hills"], &["shade"]] {
        let mut folded = flat.clone();
        let (inner, node) = subgraph::collapse(&mut folded, &mut interfaces, names, "part.ron").unwrap();
        fs::write(folder.path().join("part.ron"), inner.to_ron(&registry)).unwrap();
        interfaces.forget_graphs();
        assert_eq!(folded.nodes.len(), 4 - names.len(), "{names:?}");
        assert_eq!(result(&folded, &registry, folder.path()), expected, "{names:?} folded");
        let laid = subgraph::expand(&mut folded, &mut interfaces, &node).unwrap();
        assert_eq!(laid.len(), names.len());
        assert_eq!(folded.nodes.len(), 3);
        assert_eq!(result(&folded, &registry, folder.path()), expected, "{names:?} laid out again");
    }
}

#[test]
fn nodes_around_another_one_are_not_folded_without_it() {
    let registry = registry();
    let mut document = chain(&registry);
    let mut interfaces = common::interfaces(&registry);
    let refused =
        subgraph::collapse(&mut document, &mut interfaces, &["hills", "shade"], "part.ron").unwrap_err();
    assert!(refused.message.contains("`soft` stands between"), "{refused}");
    assert_eq!(refused.help, "choose `soft`, too");
}
