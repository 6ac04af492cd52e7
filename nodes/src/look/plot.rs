//! Plot: columns of a table against one another.

use glam::DVec2;
use orograph_core::{Unit, prelude::*};

use super::chart::{Axis, Chart, Series, Style};
use crate::measure::append::split_list;

/// How the points of a plot are drawn.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// A line with its points marked.
    MarkedLine,
    /// A line alone.
    Line,
    /// Points alone.
    Dots,
}

/// Plots columns of a table over another column.
///
/// Rows are taken in their order. A cell that is NaN, or not positive on a logarithmic axis, interrupts its
/// line. The plot has no place in the world.
#[derive(Params, Clone, Debug)]
pub struct Plot {
    /// Name of the column along the horizontal axis; the first column when empty.
    #[param(default = "")]
    pub x: String,
    /// Names of the columns to draw, separated by `;` or line ends; every other column of numbers when empty.
    #[param(default = "")]
    pub y: String,
    /// Names of the drawn columns in the legend, in order, separated by `;` or line ends; their own when left out.
    #[param(default = "")]
    pub labels: String,
    /// How points are drawn.
    #[param(default = Marks::MarkedLine)]
    pub marks: Marks,
    /// Text along the horizontal axis; the column's name and unit when empty.
    #[param(default = "")]
    pub x_label: String,
    /// Text along the vertical axis; the column's name and unit when empty.
    #[param(default = "")]
    pub y_label: String,
    /// Logarithmic horizontal axis.
    #[param(default = false)]
    pub log_x: bool,
    /// Logarithmic vertical axis.
    #[param(default = false)]
    pub log_y: bool,
    /// The vertical axis reaches down to zero, unless it is logarithmic.
    #[param(default = true)]
    pub from_zero: bool,
    /// Heading of the plot; none when empty.
    #[param(default = "")]
    pub title: String,
    /// Width of the plot.
    #[param(default = 720u32, range = 64..=8192, slider = 320..=1920, unit = "px")]
    pub width: u32,
    /// Height of the plot.
    #[param(default = 480u32, range = 64..=8192, slider = 240..=1080, unit = "px")]
    pub height: u32,
}

/// Inputs of [`Plot`].
#[derive(Inputs)]
pub struct PlotIn<'a> {
    /// Table to plot.
    pub table: &'a Table,
}

/// Outputs of [`Plot`].
#[derive(Outputs)]
pub struct PlotOut {
    /// The plot.
    pub picture: Texture,
}

impl Node for Plot {
    const ID: &'static str = "look.plot";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PlotIn<'a>;
    type Outputs = PlotOut;

    fn run(&self, inputs: PlotIn<'_>, job: &Job) -> Result<PlotOut> {
        let table = inputs.table;
        let first = table.columns().first().ok_or_else(|| Error::EmptyInput { what: "table".into() })?;
        let x_name = if self.x.trim().is_empty() { &first.name } else { self.x.trim() };
        let x = numbers(table, x_name)?;
        let mut y_names = split_list(&self.y);
        if y_names.is_empty() {
            let others = table.columns().iter().filter(|column| column.name != *x_name);
            let numeric = others.filter(|column| matches!(column.cells, Cells::Numbers(_)));
            y_names = numeric.map(|column| column.name.as_str()).collect();
        }
        let labels = split_list(&self.labels);
        let mut series = Vec::new();
        let mut units = Vec::new();
        for (i, name) in y_names.iter().enumerate() {
            let y = numbers(table, name)?;
            units.push(y.0);
            let points = x.1.iter().zip(y.1).map(|(&x, &y)| DVec2::new(x, y)).collect();
            let style = match self.marks {
                Marks::MarkedLine => Style::Marked,
                Marks::Line => Style::Line,
                Marks::Dots => Style::Dots,
            };
            series.push(Series { name: labels.get(i).unwrap_or(name).to_string(), style, points });
        }
        let y_label = match (self.y_label.as_str(), &series[..], &units[..]) {
            ("", [only], [unit]) => titled(&only.name, *unit),
            // Several columns share an axis only under a common unit.
            ("", _, [unit, rest @ ..]) if rest.iter().all(|other| other == unit) => unit_text(*unit).into(),
            (given, _, _) => given.into(),
        };
        if let [only] = &mut series[..] {
            // The axis says it already.
            only.name.clear();
        }
        let x_label = if self.x_label.is_empty() { titled(x_name, x.0) } else { self.x_label.clone() };
        let chart = Chart {
            title: self.title.clone(),
            x: Axis { label: x_label, log: self.log_x, ..Axis::default() },
            y: Axis { label: y_label, log: self.log_y, from_zero: self.from_zero, ..Axis::default() },
            series,
            width: self.width,
            height: self.height,
        };
        Ok(PlotOut { picture: chart.draw(job)? })
    }
}

/// The unit and the numbers of a column.
fn numbers<'a>(table: &'a Table, name: &str) -> Result<(Unit, &'a [f64])> {
    match table.column(name) {
        Some(Column { unit, cells: Cells::Numbers(cells), .. }) => Ok((*unit, cells)),
        Some(_) => Err(Error::invalid(
            format!("column `{name}` holds texts, which have no place on an axis"),
            "choose a column of numbers",
        )),
        None => {
            let names: Vec<_> = table.columns().iter().map(|column| column.name.as_str()).collect();
            let hint = format!("choose one of {}", names.join(", "));
            Err(Error::invalid(format!("the table has no column `{name}`"), hint))
        }
    }
}

fn unit_text(unit: Unit) -> &'static str {
    if matches!(unit, Unit::One | Unit::Seed) { "" } else { unit.symbol() }
}

/// A column's name and unit as an axis shows them.
fn titled(name: &str, unit: Unit) -> String {
    let words = name.replace('_', " ");
    match unit_text(unit) {
        "" => words,
        unit => format!("{words} ({unit})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let column = |name: &str, unit, cells| Column { name: name.into(), unit, cells };
        Table::new(vec![
            column("keep_rate", Unit::Percent, Cells::Numbers(vec![1.0, 2.0, f64::NAN])),
            column("name", Unit::One, Cells::Texts(vec![String::new(); 3])),
            column("rmse", Unit::Metre, Cells::Numbers(vec![9.0, 4.0, 1.0])),
        ])
        .unwrap()
    }

    #[test]
    fn columns_are_chosen_by_name() {
        let run = |x: &str, y: &str| {
            let node = Plot { x: x.into(), y: y.into(), ..Plot::default() };
            node.run(PlotIn { table: &table() }, &Job::detached()).map(|out| out.picture.into_cells())
        };
        assert_eq!(run("", "").unwrap(), run("keep_rate", "rmse").unwrap());
        assert_ne!(run("rmse", "keep_rate").unwrap(), run("keep_rate", "rmse").unwrap());
        for (x, y) in [("nothing", "rmse"), ("keep_rate", "rmse;nothing"), ("name", "rmse")] {
            assert!(run(x, y).is_err());
        }
        assert_eq!(titled("keep_rate", Unit::Percent), "keep rate (%)");
        let nothing = Plot::default().run(PlotIn { table: &Table::default() }, &Job::detached());
        assert!(matches!(nothing, Err(Error::EmptyInput { .. })));
    }
}
