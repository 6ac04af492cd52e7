//! The report of a patched surrounding, told of the tile in its middle.

use orograph_core::{Cells, Column, prelude::*};

/// The rows of the voids whose boxes reach into the tile that begins at `first`, counted from there.
///
/// # Errors
/// Those of [`Table::new`].
pub(super) fn in_tile(report: &Table, first: [usize; 2], size: [usize; 2]) -> Result<Table> {
    let numbers = |name: &str| {
        report.columns().iter().find(|column| column.name == name).and_then(|column| match &column.cells {
            Cells::Numbers(numbers) => Some(numbers.as_slice()),
            Cells::Texts(_) => None,
        })
    };
    let (Some(row), Some(col), Some(rows), Some(cols)) =
        (numbers("row"), numbers("col"), numbers("rows"), numbers("cols"))
    else {
        return Ok(report.clone());
    };
    let reaches = |start: f64, n: f64, axis: usize| {
        let tile = first[axis] as f64;
        // Voids without a box have no place; they are kept.
        !(start + n <= tile || start >= tile + size[axis] as f64)
    };
    let keep: Vec<bool> =
        (0..row.len()).map(|i| reaches(row[i], rows[i], 0) && reaches(col[i], cols[i], 1)).collect();
    let moved = |column: &Column| {
        let by = match column.name.as_str() {
            "row" | "source_row" => first[0] as f64,
            "col" | "source_col" => first[1] as f64,
            _ => 0.0,
        };
        let cells = match &column.cells {
            Cells::Numbers(numbers) => {
                Cells::Numbers(kept(numbers, &keep).map(|number| number - by).collect())
            }
            Cells::Texts(texts) => Cells::Texts(kept(texts, &keep).cloned().collect()),
        };
        Column { cells, ..column.clone() }
    };
    Table::new(report.columns().iter().map(moved).collect())
}

fn kept<'a, T>(values: &'a [T], keep: &'a [bool]) -> impl Iterator<Item = &'a T> {
    values.iter().zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| value)
}
