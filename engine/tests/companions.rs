//! Files beside a file: which a node is given, and what their coming, changing and going makes it do.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

mod support;

use std::{fs, path::Path, sync::Arc};

use orograph_core::{NodeType, ParamValue, Value, prelude::*};
use orograph_engine::{
    CancelToken, Evaluator, Graph, GraphBuilder, NodeId, OutputRef, Request, eval::Silent,
};
use support::{in_memory, on_disk};

/// Adds up the lengths of a file and of those beside it.
#[derive(Params)]
struct Lengths {
    /// The file.
    #[param(default = "")]
    file: InputPath,
    /// Names of files beside it.
    #[param(default = "east west")]
    beside: String,
    /// A file beside it that was not declared.
    #[param(default = "")]
    secret: String,
}

/// A number.
#[derive(Outputs)]
struct LengthsOut {
    /// The sum.
    number: f64,
}

impl Node for Lengths {
    const ID: &'static str = "test.lengths";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = LengthsOut;

    fn companions(&self, file: &str) -> Vec<String> {
        assert_eq!(file, "middle", "the name without its folder");
        self.beside.split_whitespace().map(str::to_owned).collect()
    }

    fn run(&self, (): (), job: &Job) -> Result<LengthsOut> {
        let length =
            |path: &Path| Ok(fs::metadata(path).map_err(|error| Error::reading("a file", error))?.len());
        let mut sum = length(&job.input_path(&self.file)?)?;
        for name in self.beside.split_whitespace().chain((!self.secret.is_empty()).then_some(&*self.secret)) {
            if let Some(path) = job.companion(&self.file, name)? {
                sum += length(&path)?;
            }
        }
        Ok(LengthsOut { number: sum as f64 })
    }
}

fn graph(folder: &Path, beside: &str, secret: &str) -> (Arc<Graph>, NodeId) {
    let mut builder = GraphBuilder::new();
    let file = folder.join("middle").display().to_string();
    let values = [file.as_str(), beside, secret].map(|text| ParamValue::Text(text.into())).to_vec();
    let node = builder.add("lengths", &Arc::new(NodeType::of::<Lengths>()), values).unwrap();
    (Arc::new(builder.build().unwrap()), node)
}

/// The sum, whether it was computed, why, or what went wrong.
fn pull(evaluator: &Evaluator, (graph, node): &(Arc<Graph>, NodeId)) -> (Option<f64>, bool, String) {
    let mut request = Request::values(Arc::clone(graph), vec![OutputRef { node: *node, output: 0 }]);
    request.history = Some("lengths".into());
    let report = evaluator.run(request, Arc::new(Silent), &CancelToken::new());
    let number = match report.values[0] {
        Some(Value::Number(number)) => Some(number),
        _ => None,
    };
    let told = match &report.nodes[0].outcome {
        orograph_engine::Outcome::Failed(error) => error.to_string(),
        _ => report.nodes[0].reason.clone().unwrap_or_default(),
    };
    (number, report.counts().computed == 1, told)
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("middle"), "1").unwrap();
    folder
}

#[test]
fn what_comes_changes_and_goes_is_computed_again_and_nothing_else() {
    let folder = folder();
    let graph = graph(folder.path(), "east west", "");
    let cache = tempfile::tempdir().unwrap();
    let evaluator = on_disk(cache.path(), 1 << 20);
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let (sum, computed) =
        (|found: &(Option<f64>, bool, String)| found.0, |found: &(_, bool, String)| found.1);

    let first = pull(&evaluator, &graph);
    assert_eq!((sum(&first), computed(&first)), (Some(1.0), true));
    write("north", "12345");
    assert!(!computed(&pull(&evaluator, &graph)), "nobody reads that one");
    write("east", "12");
    let found = pull(&evaluator, &graph);
    assert_eq!(found, (Some(3.0), true, "east came beside its file".into()));
    write("east", "123");
    let found = pull(&evaluator, &graph);
    assert_eq!(found, (Some(4.0), true, "the content of east changed".into()));
    // The same content under another name is another thing.
    fs::rename(folder.path().join("east"), folder.path().join("west")).unwrap();
    let found = pull(&evaluator, &graph);
    assert_eq!(found, (Some(4.0), true, "west came beside its file; east is gone".into()));
    fs::remove_file(folder.path().join("west")).unwrap();
    assert_eq!((sum(&pull(&evaluator, &graph)), computed(&pull(&evaluator, &graph))), (Some(1.0), false));
    // A folder is no file.
    fs::create_dir(folder.path().join("west")).unwrap();
    assert!(!computed(&pull(&evaluator, &graph)));
}

#[test]
fn a_node_is_given_no_file_that_it_did_not_declare() {
    let folder = folder();
    fs::write(folder.path().join("north"), "12").unwrap();
    let (number, _, told) = pull(&in_memory(1), &graph(folder.path(), "east", "north"));
    assert_eq!(number, None);
    assert!(told.contains("does not declare that it reads `north`"), "{told}");
}

#[test]
fn companions_lie_beside_their_file() {
    let folder = folder();
    for name in ["../other", "/etc/passwd", "a/b", "..", "."] {
        let (number, _, told) = pull(&in_memory(1), &graph(folder.path(), name, ""));
        assert_eq!(number, None);
        assert!(told.contains("as a file beside `middle`"), "{name}: {told}");
    }
}
