//! A table of metrics, to be read.

use eframe::egui;
use orograph_core::{Cells, Column, Table};

use super::{
    numbers::{decimals, readable, written},
    series::title,
};

/// How a table is written: for each column the decimals of its numbers, found once.
#[derive(Default)]
pub(super) struct Style {
    decimals: Vec<usize>,
}

impl Style {
    /// The style of a table.
    pub(super) fn of(table: &Table) -> Self {
        let of_column = |column: &Column| match &column.cells {
            Cells::Numbers(numbers) => decimals(numbers),
            Cells::Texts(_) => 0,
        };
        Self { decimals: table.columns().iter().map(of_column).collect() }
    }
}

pub(super) fn show(ui: &mut egui::Ui, name: &str, table: &Table, style: &Style) {
    const MOST: usize = 1000;
    egui::ScrollArea::both().id_salt((name, "table")).show(ui, |ui| {
        if table.rows() == 1 {
            metrics(ui, name, table);
            return;
        }
        egui::Grid::new((name, "cells")).striped(true).show(ui, |ui| {
            for column in table.columns() {
                ui.strong(title(&column.name, column.unit.symbol()));
            }
            ui.end_row();
            for row in 0..table.rows().min(MOST) {
                for (column, decimals) in table.columns().iter().zip(&style.decimals) {
                    match &column.cells {
                        Cells::Numbers(numbers) => {
                            let number = numbers.get(row).copied().unwrap_or(f64::NAN);
                            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                                ui.monospace(written(number, *decimals));
                            });
                        }
                        Cells::Texts(texts) => {
                            ui.label(texts.get(row).map_or("", String::as_str));
                        }
                    }
                }
                ui.end_row();
            }
        });
        if table.rows() > MOST {
            ui.weak(format!("and {} rows more", table.rows() - MOST));
        }
    });
}

/// One row of metrics, one a line.
fn metrics(ui: &mut egui::Ui, name: &str, table: &Table) {
    egui::Grid::new((name, "metrics")).striped(true).show(ui, |ui| {
        for column in table.columns() {
            ui.label(column.name.replace('_', " "));
            ui.monospace(match &column.cells {
                Cells::Numbers(numbers) => match numbers.first() {
                    Some(number) if !number.is_nan() => readable(*number),
                    _ => "—".to_owned(),
                },
                Cells::Texts(texts) => texts.first().cloned().unwrap_or_default(),
            });
            let unit = column.unit.symbol();
            ui.weak(if unit == "1" { "" } else { unit });
            ui.end_row();
        }
    });
}
