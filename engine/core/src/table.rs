//! Named metrics with units, and tables of them.

use serde::{Deserialize, Serialize};

use crate::{Error, Result, Unit};

/// The cells of a column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cells {
    /// Numbers; NaN means that there is none.
    Numbers(Vec<f64>),
    /// Texts.
    Texts(Vec<String>),
}

impl Cells {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(cells) => cells.len(),
            Self::Texts(cells) => cells.len(),
        }
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Its name, in snake case.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Unit,
    /// Its cells.
    pub cells: Cells,
}

/// Named columns of equal length. Metrics are a table of one row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    columns: Vec<Column>,
}

impl Table {
    /// A table of the given columns.
    ///
    /// # Errors
    /// [`Error::Invalid`] when lengths differ or a name comes twice.
    pub fn new(columns: Vec<Column>) -> Result<Self> {
        for (i, column) in columns.iter().enumerate() {
            if column.cells.len() != columns[0].cells.len() {
                return Err(Error::invalid(
                    format!("column `{}` has another number of rows", column.name),
                    "give each column one cell per row",
                ));
            }
            if columns[..i].iter().any(|earlier| earlier.name == column.name) {
                return Err(Error::invalid(
                    format!("two columns are named `{}`", column.name),
                    "give each column a name of its own",
                ));
            }
        }
        Ok(Self { columns })
    }

    /// A table of one row from (name, unit, value).
    ///
    /// # Errors
    /// [`Error::Invalid`] when a name comes twice.
    pub fn metrics<'a>(metrics: impl IntoIterator<Item = (&'a str, Unit, f64)>) -> Result<Self> {
        Self::new(
            metrics
                .into_iter()
                .map(|(name, unit, value)| Column {
                    name: name.into(),
                    unit,
                    cells: Cells::Numbers(vec![value]),
                })
                .collect(),
        )
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// The column of that name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The number in the first row of that column.
    #[must_use]
    pub fn metric(&self, name: &str) -> Option<f64> {
        match &self.column(name)?.cells {
            Cells::Numbers(cells) => cells.first().copied(),
            Cells::Texts(_) => None,
        }
    }
}
