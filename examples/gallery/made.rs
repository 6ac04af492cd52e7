//! `made.json`: what the pictures in the gallery were made from, and the numbers that their runs gave.

use std::{collections::BTreeMap, fs, path::Path, sync::Arc};

use orograph_core::{Cells, Digest, Table};
use orograph_session::tables::{cell_text, head_text, number_text};
use serde::{Deserialize, Serialize};

use crate::{
    Result,
    figures::{Figure, Paper},
};

/// What was made, by the name of the graph.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(crate) struct Made(BTreeMap<String, Figures>);

/// What one graph gave.
#[derive(Debug, Default, Deserialize, Serialize)]
struct Figures {
    /// Digest of the settings and of what `graphs/golden.json` remembers of the graph.
    from: String,
    /// The numbers that were asked for, in words.
    numbers: BTreeMap<String, String>,
}

const FILE: &str = "made.json";

impl Made {
    /// What was made so far.
    pub(crate) fn load(gallery: &Path) -> Result<Self> {
        match fs::read_to_string(gallery.join(FILE)) {
            Ok(text) => serde_json::from_str(&text).map_err(|error| format!("{FILE}: {error}")),
            Err(_) => Ok(Self::default()),
        }
    }

    /// Writes the file.
    pub(crate) fn save(&self, gallery: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(|error| error.to_string())? + "\n";
        fs::write(gallery.join(FILE), text).map_err(|error| format!("writing {FILE}: {error}"))
    }

    /// Keeps what a run gave.
    pub(crate) fn remember(
        &mut self,
        figure: &Figure,
        tables: &[(String, Arc<Table>)],
        root: &Path,
    ) -> Result<()> {
        let mut numbers = BTreeMap::new();
        for number in &figure.numbers {
            let text = look_up(&number.ours, tables)
                .ok_or_else(|| format!("{}: there is no number {}", figure.graph, number.ours))?;
            numbers.insert(number.ours.clone(), text);
        }
        self.0.insert(figure.graph.clone(), Figures { from: from(figure, root)?, numbers });
        Ok(())
    }

    /// Whether the pictures of a figure show what its graph gives.
    pub(crate) fn is_fresh(&self, figure: &Figure, root: &Path) -> Result<bool> {
        let from = from(figure, root)?;
        Ok(self.0.get(&figure.graph).is_some_and(|made| made.from == from))
    }

    /// A number of a figure.
    pub(crate) fn number(&self, figure: &Figure, ours: &str) -> Option<&str> {
        self.0.get(&figure.graph)?.numbers.get(ours).map(String::as_str)
    }

    /// Forgets graphs that are shown no more.
    pub(crate) fn forget_all_but(&mut self, papers: &[Paper]) {
        let shown = |graph: &String| {
            papers.iter().flat_map(|paper| &paper.figures).any(|figure| figure.graph == *graph)
        };
        self.0.retain(|graph, _| shown(graph));
    }
}

/// What a figure's pictures follow from. `golden.json` holds the digest of every output of the graph as it is shipped, which
/// tests keep true, so nothing need run to know whether a change of a node reached it.
fn from(figure: &Figure, root: &Path) -> Result<String> {
    let file = root.join("graphs/golden.json");
    let text = fs::read_to_string(&file).map_err(|error| format!("reading {}: {error}", file.display()))?;
    let golden: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| format!("golden.json: {error}"))?;
    let golden = golden.get(&figure.graph).ok_or_else(|| format!("golden.json lacks {}", figure.graph))?;
    let numbers: Vec<_> = figure.numbers.iter().map(|number| &number.ours).collect();
    let text = format!("{:?} {:?} {numbers:?} {golden}", figure.set, figure.pictures);
    // Enough to notice a change.
    Ok(Digest::of(text.as_bytes()).to_string()[..16].to_owned())
}

/// The number at `table.column` or `table[row].column`, with its unit.
fn look_up(place: &str, tables: &[(String, Arc<Table>)]) -> Option<String> {
    let (name, column) = place.split_once('.')?;
    let (name, row) = match name.split_once('[') {
        Some((name, row)) => (name, Some(row.trim_end_matches(']'))),
        None => (name, None),
    };
    let table = &tables.iter().find(|(known, _)| known == name)?.1;
    let row = match row {
        Some(row) => {
            let labels = &table.columns().first()?.cells;
            (0..table.rows()).find(|&i| cell_text(labels, i) == row)?
        }
        None => 0,
    };
    let column = table.column(column)?;
    let text = match &column.cells {
        Cells::Numbers(cells) => number_text(*cells.get(row)?, 4),
        cells => cell_text(cells, row),
    };
    let head = head_text(column);
    Some(match head.split_once('[') {
        Some((_, unit)) => format!("{text} {}", unit.trim_end_matches(']')),
        None => text,
    })
}
