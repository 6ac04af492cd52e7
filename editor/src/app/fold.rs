//! Folding nodes into a graph file of their own. The file is written first, beside the window; then the nodes fold.

use std::{path::Path, sync::Arc};

use orograph_edit::{
    OpenFile,
    file::{Saved, Saving},
    subgraph,
};
use orograph_engine::Document;

use super::App;

/// A fold whose file is being written.
pub(super) struct Folding {
    saving: Saving,
    names: Vec<String>,
    /// The file, as the node names it.
    graph: String,
    written: Arc<Document>,
}

impl App {
    /// Folds nodes into the graph file `path`.
    pub(super) fn collapse(&mut self, names: &[String], path: &Path) {
        let folder = self.folder();
        let graph = match path.strip_prefix(&folder) {
            Ok(inside) if !folder.as_os_str().is_empty() => inside.to_string_lossy().replace('\\', "/"),
            _ => {
                self.complain("Save the graph first, and the subgraph into its folder: graphs name each other relative to themselves");
                return;
            }
        };
        if graph.contains('/') {
            self.complain(
                "Save the subgraph beside the graph: files that its nodes read are named relative to that",
            );
            return;
        }
        if self.folding.is_some() {
            self.complain("Another subgraph is still being written: try again when it is");
            return;
        }
        self.write_fold(names.to_vec(), graph, &OpenFile::new(path.to_owned()));
    }

    fn write_fold(&mut self, names: Vec<String>, graph: String, file: &OpenFile) {
        let Some(written) = self.folded(&names, &graph) else { return };
        let saving = file.save_beside(written.clone(), self.registry.clone(), true, self.wake.clone());
        self.folding = Some(Folding { saving, names, graph, written });
    }

    /// What would stand in the file if the nodes were folded now.
    fn folded(&mut self, names: &[String], graph: &str) -> Option<Arc<Document>> {
        let mut trial = (**self.editing.document()).clone();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        match subgraph::collapse(&mut trial, &mut self.interfaces, &names, graph) {
            Ok((inner, _)) => Some(Arc::new(inner)),
            Err(refused) => {
                self.complain(refused.to_string());
                None
            }
        }
    }

    /// Hears whether the file was written, and folds.
    pub(super) fn folding_answers(&mut self) {
        let Some(Saved { file, outcome }) = self.folding.as_mut().and_then(|folding| folding.saving.poll())
        else {
            return;
        };
        let Some(Folding { names, graph, written, .. }) = self.folding.take() else { return };
        if let Err(error) = outcome {
            self.complain(error.to_string());
            return;
        }
        // The nodes may have been edited meanwhile; what is in the file must be what they are.
        match self.folded(&names, &graph) {
            Some(now) if now == written => {}
            Some(_) => return self.write_fold(names, graph, &file),
            None => return,
        }
        self.interfaces.forget_graphs();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let node = self.edit("collapse", |document, interfaces| {
            subgraph::collapse(document, interfaces, &names, &graph).map(|(_, node)| node)
        });
        self.canvas.select(node);
    }
}
