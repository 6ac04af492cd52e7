//! Files of settings for a graph: a map from `node.param`, or exposed names, to values.

use std::{fs, io::Read, path::Path};

use indexmap::IndexMap;
use orograph_engine::document::MAX_BYTES;
use ron::value::RawValue;

use crate::Error;

/// The settings in a file, as `compile` takes them: names with values as RON.
///
/// # Errors
/// [`Error::Refused`] when it cannot be read, or is no map.
pub fn load(file: &Path) -> Result<Vec<(String, String)>, Error> {
    let mut bytes = Vec::new();
    let read = fs::File::open(file).and_then(|opened| {
        // No more than a graph may have, and one.
        opened.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes)
    });
    read.map_err(|error| Error::refused(format!("reading {}: {error}", file.display()), "check the path"))?;
    if bytes.len() > MAX_BYTES {
        let message = format!("{} has more than {MAX_BYTES} bytes", file.display());
        return Err(Error::refused(message, "are these settings? Data belong in files of their own"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        Error::refused(format!("reading {}: {error}", file.display()), "save the file as UTF-8")
    })?;
    parse(&text, &file.display().to_string())
}

/// The settings in the text of a file; `name` names it in messages.
///
/// # Errors
/// [`Error::Refused`] when it is no map.
pub fn parse(text: &str, name: &str) -> Result<Vec<(String, String)>, Error> {
    let values: IndexMap<String, Box<RawValue>> = ron::from_str(text).map_err(|error| {
        // The error begins with its line and column.
        Error::refused(format!("{name}:{error}"), "write a map such as {\"keep\": 0.05}")
    })?;
    Ok(values.into_iter().map(|(name, value)| (name, value.get_ron().trim().to_owned())).collect())
}
