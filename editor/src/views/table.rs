//! A table of metrics.

use eframe::egui;
use orograph_core::{Cells, Table};

pub(super) fn show(ui: &mut egui::Ui, name: &str, table: &Table) {
    const MOST: usize = 1000;
    egui::ScrollArea::both().id_salt((name, "table")).show(ui, |ui| {
        if table.rows() == 1 {
            metrics(ui, name, table);
            return;
        }
        egui::Grid::new((name, "cells")).striped(true).show(ui, |ui| {
            for column in table.columns() {
                let unit = column.unit.symbol();
                let title =
                    if unit == "1" { column.name.clone() } else { format!("{} ({unit})", column.name) };
                ui.strong(title);
            }
            ui.end_row();
            for row in 0..table.rows().min(MOST) {
                for column in table.columns() {
                    ui.label(cell(&column.cells, row));
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
            ui.monospace(cell(&column.cells, 0));
            let unit = column.unit.symbol();
            ui.weak(if unit == "1" { "" } else { unit });
            ui.end_row();
        }
    });
}

fn cell(cells: &Cells, row: usize) -> String {
    match cells {
        Cells::Numbers(numbers) => numbers.get(row).map(|number| format!("{number:.6}")).unwrap_or_default(),
        Cells::Texts(texts) => texts.get(row).cloned().unwrap_or_default(),
    }
}
