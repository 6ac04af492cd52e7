//! Write table: metrics as JSON or CSV.

use orograph_core::{Unit, prelude::*};
use serde_json::{Map, Number, Value as Json};

use super::file;

/// The format of a table.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// As the file's extension says.
    ByExtension,
    /// `{"units": {column: unit}, "rows": [{column: cell}]}`.
    Json,
    /// A line of `column [unit]`, then a line for each row.
    Csv,
}

/// Writes a table as JSON or CSV. A number that there is not becomes `null` or an empty cell.
#[derive(Params, Clone, Debug)]
pub struct WriteTable {
    /// The file to write.
    #[param(default = "table.json")]
    pub file: OutputPath,
    /// The format.
    #[param(default = TableFormat::ByExtension)]
    pub format: TableFormat,
}

/// Inputs of [`WriteTable`].
#[derive(Inputs)]
pub struct WriteTableIn<'a> {
    /// Table to write.
    pub table: &'a Table,
}

impl Node for WriteTable {
    const ID: &'static str = "io.write_table";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    const DEFAULT_WRITER: bool = true;
    type Inputs<'a> = WriteTableIn<'a>;
    type Outputs = ();

    fn check(&self) -> Result<()> {
        match self.format {
            TableFormat::ByExtension => file::check_extension(&self.file, &["json", "csv"]),
            TableFormat::Json | TableFormat::Csv => Ok(()),
        }
    }

    fn run(&self, inputs: WriteTableIn<'_>, job: &Job) -> Result<()> {
        let csv = match self.format {
            TableFormat::ByExtension => file::has_extension(&self.file.0, "csv"),
            format => format == TableFormat::Csv,
        };
        let bytes = if csv {
            to_csv(inputs.table).map_err(|reason| Error::writing(&self.file.0, reason))?
        } else {
            to_json(inputs.table).map_err(|reason| Error::writing(&self.file.0, reason))?
        };
        file::save_bytes(&self.file, &bytes, job)
    }
}

fn to_json(table: &Table) -> std::result::Result<Vec<u8>, serde_json::Error> {
    let cell = |cells: &Cells, row: usize| match cells {
        Cells::Numbers(cells) => cells.get(row).and_then(|&x| number(x)).map_or(Json::Null, Json::Number),
        Cells::Texts(cells) => cells.get(row).map_or(Json::Null, |text| Json::String(text.clone())),
    };
    let units = table.columns().iter().map(|column| (column.name.clone(), column.unit.symbol().into()));
    let row = |row: usize| {
        let cells = table.columns().iter().map(|column| (column.name.clone(), cell(&column.cells, row)));
        Json::Object(cells.collect())
    };
    let mut root = Map::new();
    root.insert("units".into(), Json::Object(units.collect()));
    root.insert("rows".into(), Json::Array((0..table.rows()).map(row).collect()));
    let mut bytes = serde_json::to_vec_pretty(&root)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A JSON number, whole where it can be: counts read better as `3` than as `3.0`.
fn number(x: f64) -> Option<Number> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if x.fract() == 0.0 && x.abs() < EXACT { Some((x as i64).into()) } else { Number::from_f64(x) }
}

fn to_csv(table: &Table) -> std::result::Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let heading = |column: &Column| match column.unit {
        Unit::One => column.name.clone(),
        unit => format!("{} [{}]", column.name, unit.symbol()),
    };
    if !table.columns().is_empty() {
        writer.write_record(table.columns().iter().map(heading))?;
    }
    for row in 0..table.rows() {
        writer.write_record(table.columns().iter().map(|column| match &column.cells {
            Cells::Numbers(cells) => {
                cells.get(row).filter(|x| x.is_finite()).map(ToString::to_string).unwrap_or_default()
            }
            Cells::Texts(cells) => cells.get(row).cloned().unwrap_or_default(),
        }))?;
    }
    writer.into_inner().map_err(|failed| csv::Error::from(failed.into_error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let column = |name: &str, unit, cells| Column { name: name.into(), unit, cells };
        Table::new(vec![
            column("name", Unit::One, Cells::Texts(vec!["a, \"b\"".into(), String::new()])),
            column("rmse", Unit::Metre, Cells::Numbers(vec![1.5, f64::NAN])),
            column("count", Unit::One, Cells::Numbers(vec![3.0, f64::INFINITY])),
        ])
        .unwrap()
    }

    #[test]
    fn json_names_units_and_turns_what_is_no_number_into_null() {
        let json: Json = serde_json::from_slice(&to_json(&table()).unwrap()).unwrap();
        assert_eq!(json["units"]["rmse"], "m");
        assert_eq!(json["rows"][0], serde_json::json!({"name": "a, \"b\"", "rmse": 1.5, "count": 3}));
        assert_eq!(json["rows"][1], serde_json::json!({"name": "", "rmse": null, "count": null}));
    }

    #[test]
    fn csv_quotes_texts_and_leaves_cells_without_number_empty() {
        let text = String::from_utf8(to_csv(&table()).unwrap()).unwrap();
        assert_eq!(text, "name,rmse [m],count\n\"a, \"\"b\"\"\",1.5,3\n,,\n");
    }

    #[test]
    fn a_table_without_columns_is_still_a_file() {
        assert_eq!(to_csv(&Table::default()).unwrap(), b"");
        assert!(to_json(&Table::default()).is_ok());
    }
}
