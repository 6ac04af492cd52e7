//! What a file tells of itself without any of its code being run.

use std::path::Path;

use object::{Architecture, BinaryFormat, File, Object, read::NameOrOrdinal};
use orograph_abi::ENTRY;

/// Whether the file can be a plugin here.
///
/// # Errors
/// A line that says why not.
pub(crate) fn examine(bytes: &[u8]) -> Result<(), String> {
    let file = File::parse(bytes).map_err(|_| "it is no dynamic library".to_owned())?;
    let here = (format_here(), architecture_here());
    if let Some(format) = here.0.filter(|format| *format != file.format()) {
        return Err(format!(
            "it is a library of another system: {:?}, and this one has {format:?}",
            file.format()
        ));
    }
    if let Some(architecture) = here.1.filter(|architecture| *architecture != file.architecture()) {
        return Err(format!(
            "it is built for another machine: {:?}, and this is {architecture:?}",
            file.architecture()
        ));
    }
    let mut exports = file.exports().map_err(|error| format!("its symbols cannot be read: {error}"))?;
    // Some systems put an underscore before every name.
    let is_entry =
        |name: &[u8]| name == ENTRY.to_bytes() || name.strip_prefix(b"_") == Some(ENTRY.to_bytes());
    if exports.any(|export| {
        export.is_ok_and(|export| matches!(export.name(), NameOrOrdinal::Name(name) if is_entry(name)))
    }) {
        return Ok(());
    }
    Err(format!("it exports no `{}`: it is a library, but no plugin", ENTRY.to_string_lossy()))
}

/// Whether a file's name is that of a library on this system.
pub(super) fn is_library(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == std::env::consts::DLL_EXTENSION)
}

fn format_here() -> Option<BinaryFormat> {
    if cfg!(windows) {
        Some(BinaryFormat::Pe)
    } else if cfg!(target_vendor = "apple") {
        Some(BinaryFormat::MachO)
    } else if cfg!(unix) {
        Some(BinaryFormat::Elf)
    } else {
        None
    }
}

fn architecture_here() -> Option<Architecture> {
    if cfg!(target_arch = "x86_64") {
        Some(Architecture::X86_64)
    } else if cfg!(target_arch = "aarch64") {
        Some(Architecture::Aarch64)
    } else {
        None
    }
}
