//! The two streams: results on standard output, everything else on standard error.

use std::io::{self, Write};

use orograph_core::Error;
use orograph_engine::{DocumentError, DocumentErrors, Report};

/// Writes a result. A reader that went away, as `head` does, is no error.
pub(crate) fn result(text: &str) {
    let mut stdout = io::stdout().lock();
    // Nothing is left to tell it to.
    let _ = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
}

/// Tells something that is no result.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Tells an error.
pub(crate) fn error(text: &str) {
    note(&format!("error: {text}"));
}

/// Tells what would mend it.
pub(crate) fn hint(text: &str) {
    if !text.is_empty() {
        note(&format!("  hint: {text}"));
    }
}

/// Tells what is wrong with a graph: for each error its place, the line with the place marked, and the mend.
pub(crate) fn document_errors(errors: &DocumentErrors) {
    for each in errors.errors() {
        error(&each.to_string());
        if let Some(lines) = marked_line(each) {
            note(&lines);
        }
        hint(each.help_text().unwrap_or_default());
    }
}

/// The line of an error with its place underlined; of a long line the part around it.
fn marked_line(error: &DocumentError) -> Option<String> {
    const BEFORE: usize = 60;
    const MOST: usize = 100;
    let (number, column) = (error.line()?.to_string(), error.column()?);
    let line = error.line_text()?;
    let skipped = (column - 1).saturating_sub(BEFORE);
    // Tabs would shift the mark, and control characters the terminal.
    let printed = |c: char| if c.is_control() { ' ' } else { c };
    let shown: String = line.chars().skip(skipped).take(MOST).map(printed).collect();
    if shown.trim().is_empty() {
        return None;
    }
    let start = column - 1 - skipped;
    let width =
        error.span().map_or(1, |span| span.len()).clamp(1, shown.chars().count().max(start + 1) - start);
    let gutter = " ".repeat(number.len());
    Some(format!(
        "  {gutter} |\n  {number} | {shown}\n  {gutter} | {}{}",
        " ".repeat(start),
        "^".repeat(width)
    ))
}

/// Tells which nodes failed by themselves, why, and what would mend it. A cancelled node did not fail.
pub(crate) fn failures(report: &Report) {
    for (node, why) in report.failures().filter(|(_, why)| **why != Error::Cancelled) {
        error(&format!("node `{}` ({}): {why}", node.name, node.id));
        hint(&why.hint().unwrap_or_default());
    }
}

/// Columns set flush, the first row being their heads.
pub(crate) fn columns(rows: &[Vec<String>]) -> String {
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..n_columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells: Vec<_> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        cells.join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
