//! What `docs/gallery/figures.ron` says: which graph shows which figure, and what the papers print.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use serde::Deserialize;

/// A paper and its figures.
#[derive(Debug, Deserialize)]
pub(crate) struct Paper {
    /// The name of its page.
    pub(crate) page: String,
    /// Authors, title and place of publication.
    pub(crate) source: String,
    /// What the page says first.
    pub(crate) about: String,
    /// Its figures that we have.
    pub(crate) figures: Vec<Figure>,
    /// Its figures that we have not, and why.
    pub(crate) missing: String,
}

/// A figure, or a table.
#[derive(Debug, Deserialize)]
pub(crate) struct Figure {
    /// Such as `Figure 9 (a, b)`.
    pub(crate) title: String,
    /// The name of the graph.
    pub(crate) graph: String,
    /// Settings of this picture.
    #[serde(default)]
    pub(crate) set: BTreeMap<String, String>,
    /// What is different from the paper's figure, and what to look at.
    #[serde(default)]
    pub(crate) note: String,
    /// The pictures that the graph writes and that are shown.
    pub(crate) pictures: Vec<String>,
    /// What the paper says and what we have.
    #[serde(default)]
    pub(crate) numbers: Vec<Number>,
}

/// One number of the paper beside ours.
#[derive(Debug, Deserialize)]
pub(crate) struct Number {
    /// What is measured.
    pub(crate) what: String,
    /// The paper's figure as printed; empty where it gives none.
    #[serde(default)]
    pub(crate) paper: String,
    /// Where ours stands: `table.column`, or `table[row].column` with what the row's first column holds.
    pub(crate) ours: String,
}

impl Figure {
    /// The graph's file.
    pub(crate) fn file(&self, root: &Path) -> PathBuf {
        root.join("graphs").join(format!("{}.ron", self.graph))
    }

    /// What a picture that the graph writes is called in the gallery.
    pub(crate) fn shown_as(&self, picture: &str) -> String {
        if picture.starts_with(&self.graph) {
            picture.to_owned()
        } else {
            format!("{}-{picture}", self.graph)
        }
    }
}

/// The papers.
pub(crate) fn load(gallery: &Path) -> Result<Vec<Paper>, String> {
    let file = gallery.join("figures.ron");
    let text = fs::read_to_string(&file).map_err(|error| format!("reading {}: {error}", file.display()))?;
    ron::from_str(&text).map_err(|error| format!("{}:{error}", file.display()))
}
