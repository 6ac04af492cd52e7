//! The two streams: results on standard output, everything else on standard error.

use std::io::{self, IsTerminal, Write};

use miette::{GraphicalReportHandler, GraphicalTheme};
use orograph_engine::DocumentErrors;

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

/// Tells what is wrong with a graph, with the place in its file.
pub(crate) fn document_errors(errors: &DocumentErrors) {
    let theme = if io::stderr().is_terminal() { GraphicalTheme::unicode() } else { GraphicalTheme::none() };
    let handler = GraphicalReportHandler::new_themed(theme).with_width(110).with_links(false);
    for error in errors.errors() {
        note(&format!("error: {error}"));
        if error.span().is_some() {
            let mut text = String::new();
            if handler.render_report(&mut text, error).is_ok() {
                // The headline was told; the rest shows the place.
                let place: Vec<_> = text
                    .lines()
                    .filter(|line| {
                        line.contains('│')
                            || line.contains('|')
                            || line.contains('╰')
                            || line.contains('·')
                            || line.contains(':')
                    })
                    .collect();
                if place.len() > 1 {
                    note(&text);
                    continue;
                }
            }
        }
        if let Some(help) = error.help_text() {
            hint(help);
        }
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
