//! What a sweep writes: a contact sheet for each output that is a picture, and the table as CSV and JSON.

use std::path::Path;

use orograph_core::{Context, Job, Node, OutputPath, Result, Table, Texture, Value};
use orograph_nodes::{
    io::{
        write_table::{WriteTable, WriteTableIn},
        write_texture::{WriteTexture, WriteTextureIn},
    },
    look::contact_sheet::{ContactSheet, ContactSheetIn},
};
use orograph_session::FolderHost;

use super::Cell;

/// The pictures of a sweep.
pub(crate) struct Sheets<'a> {
    /// A label for each combination.
    pub(crate) labels: &'a [String],
    /// Pictures in a row; 0 chooses.
    pub(crate) columns: usize,
    /// For each combination, its outputs.
    pub(crate) cells: &'a [Vec<Cell>],
    /// The values of all outputs, combination by combination.
    pub(crate) values: &'a [Option<Value>],
}

impl Sheets<'_> {
    /// Writes `sweep.csv`, `sweep.json` and the sheets into the folder, and names them.
    pub(crate) fn write(&self, folder: &Path, thumbnail: u32, table: &Table) -> Result<Vec<String>> {
        let host = FolderHost::new(folder);
        self.write_into(&host, thumbnail, table).map_err(|error| host.located(error))
    }

    fn write_into(&self, host: &FolderHost, thumbnail: u32, table: &Table) -> Result<Vec<String>> {
        let job = Job::new(host, Context::default());
        let mut files = Vec::new();
        for file in ["sweep.csv", "sweep.json"] {
            let writer = WriteTable { file: OutputPath(file.into()), ..WriteTable::default() };
            writer.run(WriteTableIn { table }, &job)?;
            files.push(file.to_owned());
        }
        let n_outputs = self.cells.first().map_or(0, Vec::len);
        for output in (0..n_outputs).filter(|&output| self.cells[0][output].picture) {
            if let Some(sheet) = self.sheet(output, n_outputs, thumbnail, &job)? {
                let name = self.cells[0][output].name.replace(['/', '.'], "-");
                let file = format!("sweep-{name}.png");
                let writer = WriteTexture { file: OutputPath(file.clone()), ..WriteTexture::default() };
                writer.run(WriteTextureIn { texture: &sheet }, &job)?;
                files.push(file);
            }
        }
        Ok(files)
    }

    /// The sheet of one output; none when every combination failed.
    fn sheet(&self, output: usize, n_outputs: usize, thumbnail: u32, job: &Job) -> Result<Option<Texture>> {
        let of_output = self.values.iter().skip(output).step_by(n_outputs);
        let made = of_output.zip(self.labels).filter_map(|(value, label)| match value {
            Some(Value::Texture(picture)) => Some((picture.as_ref(), label.as_str())),
            _ => None,
        });
        let (pictures, labels): (Vec<_>, Vec<_>) = made.unzip();
        if pictures.is_empty() {
            return Ok(None);
        }
        let sheet = ContactSheet {
            labels: labels.join("\n"),
            title: self.cells[0][output].name.clone(),
            // With a picture missing, a row would no longer be one value.
            columns: if pictures.len() == self.cells.len() { self.columns.min(64) as u32 } else { 0 },
            size: thumbnail,
            ..ContactSheet::default()
        };
        Ok(Some(sheet.run(ContactSheetIn { pictures }, job)?.picture))
    }
}
