//! Tables for people to read.

use std::fmt::Write;

use orograph_core::{Cells, Column, Table};

/// One cell, to six significant digits.
#[must_use]
pub fn cell_text(cells: &Cells, row: usize) -> String {
    match cells {
        Cells::Texts(cells) => cells.get(row).cloned().unwrap_or_default(),
        Cells::Numbers(cells) => cells.get(row).map_or_else(String::new, |&x| number_text(x, 6)),
    }
}

/// A number to so many significant digits, a dash for none.
#[must_use]
pub fn number_text(x: f64, significant: i32) -> String {
    if x.is_nan() {
        return "-".into();
    }
    if x == x.trunc() && x.abs() < 1e15 {
        return format!("{x}");
    }
    let scientific = format!("{x:e}");
    let exponent = scientific.rsplit_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    let digits = (significant - 1 - exponent.unwrap_or(0_i32)).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The name of a column, with its unit where it has one.
#[must_use]
pub fn head_text(column: &Column) -> String {
    match column.unit.symbol() {
        "1" | "seed" => column.name.clone(),
        unit => format!("{} [{unit}]", column.name),
    }
}

/// A table in Markdown: a line for each figure of a single row, otherwise a line for each of the first `most` rows.
#[must_use]
pub fn markdown(table: &Table, most: usize) -> String {
    let mut text = String::new();
    let cell = |cells, row| cell_text(cells, row).replace('|', "\\|");
    if table.rows() == 1 {
        text.push_str("| Figure | |\n|---|---|\n");
        for column in table.columns() {
            let _ = writeln!(text, "| `{}` | {} |", head_text(column), cell(&column.cells, 0));
        }
        return text;
    }
    for column in table.columns() {
        let _ = write!(text, "| `{}` ", head_text(column));
    }
    let _ = write!(text, "|\n{}|\n", "|---".repeat(table.columns().len()));
    for row in 0..table.rows().min(most) {
        for column in table.columns() {
            let _ = write!(text, "| {} ", cell(&column.cells, row));
        }
        text.push_str("|\n");
    }
    if let more @ 1.. = table.rows().saturating_sub(most) {
        let _ = write!(text, "\nand {more} more.\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use orograph_core::{Column, Unit};

    use super::*;

    #[test]
    fn numbers_have_so_many_digits() {
        for (x, text) in
            [(1.0, "1"), (-1234.56, "-1235"), (0.012_345, "0.01235"), (f64::NAN, "-"), (0.5, "0.5")]
        {
            assert_eq!(number_text(x, 4), text);
        }
    }

    #[test]
    fn a_row_stands_upright_and_many_lie() {
        let one = Table::metrics([("rmse", Unit::Metre, 1.5), ("share", Unit::One, 0.25)]).unwrap();
        assert_eq!(markdown(&one, 2), "| Figure | |\n|---|---|\n| `rmse [m]` | 1.5 |\n| `share` | 0.25 |\n");
        let cells = Cells::Numbers(vec![1.0, 2.0, 3.0]);
        let many = Table::new(vec![Column { name: "n".into(), unit: Unit::One, cells }]).unwrap();
        assert_eq!(markdown(&many, 2), "| `n` |\n|---|\n| 1 |\n| 2 |\n\nand 1 more.\n");
    }
}
