//! A table as a plot: lines over its first column, or bars where rows are few.

use std::sync::Arc;

use eframe::egui;
use egui_plot::{Bar, BarChart, Corner, GridInput, GridMark, HoverPosition, Legend, Line, PlotPoint, Points};
use orograph_core::{Cells, Table};
use orograph_nodes::look::ticks;

use super::{
    numbers::readable,
    series::{self, Choice, Series},
};
use crate::inspector::named;

/// Rows that are drawn as bars, at most.
const FEW: usize = 8;

/// How a table is plotted.
pub(super) struct Plot {
    choice: Choice,
    /// The columns that the choice was made of.
    columns: Vec<String>,
    /// What was drawn last, and of which choice it was.
    drawn: Option<(Choice, Vec<Drawn>)>,
    /// Whether all of it is to be seen again.
    fresh: bool,
    /// Names of the rows, where the table has such.
    names: Option<Arc<[String]>>,
    /// Where the names of the columns hide the least.
    corner: Corner,
}

impl Default for Plot {
    fn default() -> Self {
        Self {
            choice: Choice::default(),
            columns: Vec::new(),
            drawn: None,
            fresh: false,
            names: None,
            corner: Corner::RightTop,
        }
    }
}

struct Drawn {
    series: Series,
    /// The same as the plot takes them.
    runs: Vec<Vec<PlotPoint>>,
}

/// Whether there is anything to plot.
pub(super) fn can_be_plotted(table: &Table) -> bool {
    table.rows() > 1 && series::number_columns(table).next().is_some()
}

impl Plot {
    /// Another table is to be plotted.
    pub(super) fn renew(&mut self, table: &Table) {
        self.drawn = None;
        self.names = row_names(table);
        let columns: Vec<_> = table.columns().iter().map(|column| column.name.clone()).collect();
        if self.columns != columns {
            self.columns = columns;
            let all = Choice { over_rows: true, ..Choice::default() };
            self.choice = Choice { hidden: series::strangers(table, &all), ..Choice::default() };
        }
    }

    pub(super) fn ui(&mut self, ui: &mut egui::Ui, name: &str, table: &Table) {
        if !can_be_plotted(table) {
            ui.label("A plot needs two rows and a column of numbers at least: look at the table");
            return;
        }
        self.choices(ui, name, table);
        if self.drawn.as_ref().is_none_or(|(choice, _)| *choice != self.choice) {
            let drawn = series::series(table, &self.choice).into_iter().map(|series| Drawn {
                runs: series
                    .runs
                    .iter()
                    .map(|run| run.iter().map(|place| (*place).into()).collect())
                    .collect(),
                series,
            });
            let drawn: Vec<_> = drawn.collect();
            self.corner = match series::emptiest(&drawn.iter().map(|drawn| &drawn.series).collect::<Vec<_>>())
            {
                (true, true) => Corner::RightTop,
                (false, true) => Corner::LeftTop,
                (true, false) => Corner::RightBottom,
                (false, false) => Corner::LeftBottom,
            };
            self.drawn = Some((self.choice.clone(), drawn));
            self.fresh = true;
        }
        let Some((_, drawn)) = &self.drawn else { return };
        if drawn.iter().all(|drawn| drawn.runs.is_empty()) {
            ui.label("Nothing of it can be drawn: choose a column, or take the mark off a logarithmic axis");
            return;
        }
        let all: Vec<&Series> = drawn.iter().map(|drawn| &drawn.series).collect();
        let below = match series::base(table, &self.choice) {
            Some((column, _)) => series::title(&column.name, column.unit.symbol()),
            None => "row".to_owned(),
        };
        let beside = series::vertical_title(all.iter().copied());
        let [log_x, log_y] = self.choice.log;
        let labels = self.names.clone().filter(|_| self.over_rows(table));
        let names = labels.clone();
        let hover = move |at: &HoverPosition<'_>| match at {
            HoverPosition::NearDataPoint { plot_name, position, .. } => {
                let x = match &names {
                    Some(names) => name_at(names, position.x),
                    None => readable(power(position.x, log_x)),
                };
                Some(format!("{plot_name}\n{x}: {}", readable(power(position.y, log_y))))
            }
            HoverPosition::Elsewhere { .. } => None,
        };
        let mut plot = egui_plot::Plot::new((name, "plot"))
            .x_axis_label(below.clone())
            .y_axis_label(beside.clone())
            .label_formatter(hover)
            .x_axis_formatter(move |mark, _| match &labels {
                Some(names) => name_at(names, mark.value),
                None => short(power(mark.value, log_x)),
            })
            .y_axis_formatter(move |mark, _| short(power(mark.value, log_y)));
        // Names that would hide what they name are left to the menu of columns.
        if all.len() > 1 && (all.len() as f32) * 22.0 < ui.available_height() * 0.7 {
            plot = plot.legend(Legend::default().position(self.corner));
        }
        if log_x {
            plot = plot.x_grid_spacer(decades);
        }
        if log_y {
            plot = plot.y_grid_spacer(decades);
        }
        if std::mem::take(&mut self.fresh) {
            plot = plot.reset();
        }
        let bars = self.bars(table);
        let shown = plot.show(ui, |plot| {
            for (nth, drawn) in drawn.iter().enumerate() {
                let name = series::title(&drawn.series.name, drawn.series.unit);
                if bars {
                    plot.bar_chart(bar_chart(&name, drawn, nth, all.len()));
                    continue;
                }
                let color = colour_of(nth);
                for run in &drawn.runs {
                    match run.as_slice() {
                        [_] => {
                            plot.points(Points::new(name.clone(), run.as_slice()).radius(3.0).color(color))
                        }
                        run => plot.line(Line::new(name.clone(), run).color(color).width(1.5)),
                    }
                }
            }
        });
        let columns = all.iter().map(|series| series::title(&series.name, series.unit));
        let words = format!("plot {name}: {} over {below}", columns.collect::<Vec<_>>().join(", "));
        shown
            .response
            .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Image, true, words.clone()));
    }

    fn choices(&mut self, ui: &mut egui::Ui, name: &str, table: &Table) {
        ui.horizontal_wrapped(|ui| {
            ui.menu_button("columns", |ui| {
                for column in series::offered(table, &self.choice) {
                    let mut shown = !self.choice.hidden.iter().any(|hidden| hidden == column);
                    if ui.checkbox(&mut shown, column.replace('_', " ")).changed() {
                        match shown {
                            true => self.choice.hidden.retain(|hidden| hidden != column),
                            false => self.choice.hidden.push(column.to_owned()),
                        }
                    }
                }
            });
            for (axis, log) in ["x", "y"].into_iter().zip(&mut self.choice.log) {
                ui.checkbox(log, format!("log {axis}"))
                    .on_hover_text("A logarithmic axis; what is not above zero is left out");
            }
            if series::number_columns(table).nth(1).is_some() {
                ui.checkbox(&mut self.choice.over_rows, "over rows")
                    .on_hover_text("Over the number of the row and not over the first column");
            }
            let fit = ui.small_button("fit").on_hover_text("See all of it again");
            if named(fit, &format!("fit plot {name}")).clicked() {
                self.fresh = true;
            }
        });
    }

    fn over_rows(&self, table: &Table) -> bool {
        series::base(table, &self.choice).is_none()
    }

    /// Few rows over their numbers are bars; a logarithm has no foot to stand on.
    fn bars(&self, table: &Table) -> bool {
        table.rows() <= FEW && self.over_rows(table) && !self.choice.log[1]
    }
}

/// Bars of a column, beside those of the others.
fn bar_chart(name: &str, drawn: &Drawn, nth: usize, of: usize) -> BarChart {
    let width = 0.8 / of.max(1) as f64;
    let bars = drawn.series.runs.iter().flatten().map(|[x, y]| {
        let middle = x + width * (nth as f64 + 0.5) - 0.4;
        Bar::new(middle, *y).width(width)
    });
    BarChart::new(name, bars.collect()).color(colour_of(nth))
}

/// Colours that are told apart, also by the colour-blind, in the order of the columns.
fn colour_of(nth: usize) -> egui::Color32 {
    const COLOURS: [u32; 8] =
        [0x4e_9ad9, 0xe0_8a3c, 0x5f_b878, 0xd0_6fb0, 0xc9_b23e, 0x8f_7fe6, 0x5f_c0b8, 0xd9_5f5f];
    let [_, r, g, b] = COLOURS[nth % COLOURS.len()].to_be_bytes();
    egui::Color32::from_rgb(r, g, b)
}

/// The names of rows: the first column of texts.
fn row_names(table: &Table) -> Option<Arc<[String]>> {
    table.columns().iter().find_map(|column| match &column.cells {
        Cells::Texts(texts) => Some(texts.as_slice().into()),
        Cells::Numbers(_) => None,
    })
}

/// The name of the row that stands at a place of the axis; nothing between rows.
fn name_at(names: &[String], at: f64) -> String {
    let row = at.round();
    if row < 1.0 || (at - row).abs() > 0.45 {
        return String::new();
    }
    names.get(row as usize - 1).cloned().unwrap_or_default()
}

fn power(at: f64, log: bool) -> f64 {
    if log { libm::pow(10.0, at) } else { at }
}

/// A round number; what multiplication left over behind it does not tell.
fn short(number: f64) -> String {
    let text = readable(libm::round(number * 1e9) / 1e9);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Marks of a logarithmic axis: powers of ten, and between them 2 and 5 times those.
fn decades(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    // Beyond this numbers have no powers.
    let (low, high) = (low.clamp(-300.0, 300.0), high.clamp(-300.0, 300.0));
    let marks = ticks::logarithmic(power(low, true), power(high, true));
    let mark = |tick: &ticks::Tick| {
        let value = libm::log10(tick.value);
        let whole = (value - value.round()).abs() < 1e-9;
        let labelled = whole || !tick.label.is_empty();
        GridMark {
            value,
            step_size: if whole {
                1.0
            } else if labelled {
                0.3
            } else {
                0.05
            },
        }
    };
    marks.iter().map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_is_marked_at_powers_of_ten() {
        let marks = decades(GridInput { bounds: (-1.0, 3.0), base_step_size: 0.1 });
        let wholes: Vec<f64> =
            marks.iter().filter(|mark| mark.step_size == 1.0).map(|mark| mark.value).collect();
        assert_eq!(wholes, [-1.0, 0.0, 1.0, 2.0, 3.0]);
        assert!(marks.iter().any(|mark| (mark.value - libm::log10(20.0)).abs() < 1e-9));
        assert!(decades(GridInput { bounds: (-1e9, 1e9), base_step_size: 1.0 }).len() < 10_000);
    }

    #[test]
    fn numbers_of_an_axis_are_round() {
        assert_eq!(short(power(2.0, true)), "100");
        assert_eq!(short(0.1 + 0.2), "0.3");
        assert_eq!(short(power(libm::log10(0.002), true)), "0.002");
    }

    #[test]
    fn a_row_is_named_where_it_stands() {
        let names = ["a".to_owned(), "b".to_owned()];
        assert_eq!(name_at(&names, 1.2), "a");
        assert_eq!(name_at(&names, 2.0), "b");
        assert_eq!(name_at(&names, 1.5), "");
        assert_eq!(name_at(&names, 0.0), "");
        assert_eq!(name_at(&names, 7.0), "");
    }
}
