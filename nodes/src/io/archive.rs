//! The one elevation file in a zip.

use std::io::{Cursor, Read};

use orograph_core::prelude::*;

use super::file::has_extension;

/// The first entry that is an elevation file by its extension: its bytes and its name.
///
/// # Errors
/// [`Error::Format`] for a broken zip, or one without such an entry; [`Error::TooLarge`] before an entry that
/// the run may not hold is unpacked; [`Error::Cancelled`].
pub(crate) fn only_entry(bytes: &[u8], name: &str, job: &Job) -> Result<(Vec<u8>, String)> {
    let broken = |reason: String| Error::format(name, format!("broken zip: {reason}"));
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| broken(error.to_string()))?;
    let known = ["hgt", "tif", "tiff", "asc"];
    let wanted = |entry: &str| {
        !entry.starts_with("__MACOSX/") && known.iter().any(|extension| has_extension(entry, extension))
    };
    let entry_name = zip.file_names().flatten().find(|entry| wanted(entry)).map(|entry| entry.into_owned());
    let Some(entry_name) = entry_name else {
        return Err(Error::format(name, "the zip holds no .hgt, .tif or .asc file"));
    };
    let mut entry = zip.by_name(&entry_name).map_err(|error| broken(error.to_string()))?;
    let size = entry.size();
    // Deflate never does better than 1032 to 1, so a larger promise is a lie.
    if size > (bytes.len() as u64).saturating_mul(1032) {
        return Err(broken(format!("`{entry_name}` promises {size} bytes")));
    }
    job.admit(size, || format!("`{entry_name}` in {name}"))?;
    let mut unpacked = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    const PIECE: u64 = 16 << 20;
    loop {
        job.check()?;
        let room = (size + 1 - unpacked.len() as u64).min(PIECE);
        let read = Read::by_ref(&mut entry)
            .take(room)
            .read_to_end(&mut unpacked)
            .map_err(|error| broken(error.to_string()))?;
        if unpacked.len() as u64 > size {
            return Err(broken(format!("`{entry_name}` is larger than it says")));
        }
        if read == 0 {
            return Ok((unpacked, entry_name));
        }
    }
}
