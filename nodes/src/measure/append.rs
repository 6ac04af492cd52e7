//! Append: rows of several tables under one head.

use orograph_core::{Unit, prelude::*};

/// Puts the rows of several tables under one another, each with its table's label.
///
/// Columns are matched by name, in the order in which they first come. Where a table lacks a column, its
/// rows hold NaN or an empty text.
#[derive(Params, Clone, Debug)]
pub struct Append {
    /// Labels of the tables, in order, separated by `;` or line ends. A table without one is labelled with its place, from 1.
    #[param(default = "")]
    pub labels: String,
    /// Name of the column of labels, which comes first; no such column when empty. Labels that are all numbers make a column of numbers.
    #[param(default = "label")]
    pub label_column: String,
}

/// Inputs of [`Append`].
#[derive(Inputs)]
pub struct AppendIn<'a> {
    /// Tables, from top to bottom.
    pub tables: Vec<&'a Table>,
}

/// Outputs of [`Append`].
#[derive(Outputs)]
pub struct AppendOut {
    /// All rows.
    pub table: Table,
}

impl Node for Append {
    const ID: &'static str = "measure.append";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = AppendIn<'a>;
    type Outputs = AppendOut;

    fn run(&self, inputs: AppendIn<'_>, _job: &Job) -> Result<AppendOut> {
        let tables = inputs.tables;
        let mut columns = Vec::new();
        if !self.label_column.is_empty() {
            columns.push(self.label_cells(&tables));
        }
        let mut heads: Vec<&Column> = Vec::new();
        for column in tables.iter().flat_map(|table| table.columns()) {
            match heads.iter().find(|head| head.name == column.name) {
                Some(head) => same_kind(head, column)?,
                None => heads.push(column),
            }
        }
        columns.extend(heads.into_iter().map(|head| gather(head, &tables)));
        Ok(AppendOut { table: Table::new(columns)? })
    }
}

impl Append {
    fn label_cells(&self, tables: &[&Table]) -> Column {
        let labels = split_list(&self.labels);
        let label = |i: usize| labels.get(i).copied().map_or_else(|| (i + 1).to_string(), str::to_owned);
        let rows = tables.iter().enumerate().flat_map(|(i, table)| (0..table.rows()).map(move |_| i));
        let texts: Vec<String> = rows.map(label).collect();
        let numbers: Option<Vec<f64>> =
            texts.iter().map(|text| text.parse().ok().filter(|number: &f64| number.is_finite())).collect();
        let cells = numbers.map_or(Cells::Texts(texts), Cells::Numbers);
        Column { name: self.label_column.clone(), unit: Unit::One, cells }
    }
}

/// The items of a list written with `;` or line ends between them, trimmed; an empty text has none.
#[must_use]
pub fn split_list(text: &str) -> Vec<&str> {
    if text.trim().is_empty() {
        return Vec::new();
    }
    text.trim().split([';', '\n']).map(str::trim).collect()
}

fn same_kind(head: &Column, column: &Column) -> Result<()> {
    let numbers = |column: &Column| matches!(column.cells, Cells::Numbers(_));
    if head.unit == column.unit && numbers(head) == numbers(column) {
        return Ok(());
    }
    Err(Error::invalid(
        format!("the tables' columns `{}` differ in unit or type", head.name),
        "append tables that came from the same kind of node",
    ))
}

fn gather(head: &Column, tables: &[&Table]) -> Column {
    let mut cells = match head.cells {
        Cells::Numbers(_) => Cells::Numbers(Vec::new()),
        Cells::Texts(_) => Cells::Texts(Vec::new()),
    };
    for table in tables {
        match (&mut cells, table.column(&head.name).map(|column| &column.cells)) {
            (Cells::Numbers(all), Some(Cells::Numbers(own))) => all.extend(own),
            (Cells::Texts(all), Some(Cells::Texts(own))) => all.extend(own.iter().cloned()),
            (Cells::Numbers(all), _) => all.resize(all.len() + table.rows(), f64::NAN),
            (Cells::Texts(all), _) => all.resize(all.len() + table.rows(), String::new()),
        }
    }
    Column { name: head.name.clone(), unit: head.unit, cells }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn append(labels: &str, tables: Vec<&Table>) -> Result<Table> {
        let node = Append { labels: labels.into(), ..Append::default() };
        node.run(AppendIn { tables }, &Job::detached()).map(|out| out.table)
    }

    #[test]
    fn rows_follow_one_another_under_their_labels() {
        let a = Table::metrics([("rmse", Unit::Metre, 1.0), ("bias", Unit::Metre, 2.0)]).unwrap();
        let b = Table::metrics([("share", Unit::Percent, 5.0), ("rmse", Unit::Metre, 3.0)]).unwrap();
        let table = append("0.5; 2", vec![&a, &b]).unwrap();
        let names: Vec<_> = table.columns().iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["label", "rmse", "bias", "share"]);
        assert_eq!(table.columns()[0].cells, Cells::Numbers(vec![0.5, 2.0]));
        assert_eq!(table.columns()[1].cells, Cells::Numbers(vec![1.0, 3.0]));
        assert!(matches!(&table.columns()[2].cells, Cells::Numbers(cells) if cells[1].is_nan()));
        let named = append("a\nb", vec![&a, &b]).unwrap();
        assert_eq!(named.columns()[0].cells, Cells::Texts(vec!["a".into(), "b".into()]));
    }

    #[test]
    fn tables_that_do_not_fit_are_refused() {
        let a = Table::metrics([("rmse", Unit::Metre, 1.0)]).unwrap();
        let b = Table::metrics([("rmse", Unit::Percent, 1.0)]).unwrap();
        assert!(append("", vec![&a, &b]).is_err());
        let label = Table::metrics([("label", Unit::One, 1.0)]).unwrap();
        assert!(append("", vec![&label]).is_err());
        assert_eq!(append("", Vec::new()).unwrap().rows(), 0);
    }
}
