//! What every reader and writer of this family shares: whole files in, whole files out, and the checks that
//! no format spares us.

use std::{
    fs::File,
    io::{BufWriter, Read, Write},
    path::{Path, PathBuf},
};

use orograph_core::OutputStream;
use orograph_core::prelude::*;
use rayon::prelude::*;

/// Reads the whole file; also returns its name, which errors and formats go by.
pub(crate) fn load(path: &InputPath, job: &Job) -> Result<(Vec<u8>, String)> {
    let (full, name) = find(path, job)?;
    Ok((load_whole(&full, &path.0, &name, job)?, name))
}

/// Opens the file; also returns its name.
pub(crate) fn open(path: &InputPath, job: &Job) -> Result<(File, String)> {
    let (full, name) = find(path, job)?;
    Ok((File::open(full).map_err(|reason| Error::reading(&path.0, reason))?, name))
}

/// Where the file lies, and its name.
fn find(path: &InputPath, job: &Job) -> Result<(PathBuf, String)> {
    if path.0.is_empty() {
        return Err(Error::invalid("`file` names no file", "give the path of the file to read"));
    }
    let full = job.input_path(path)?;
    let name = full.file_name().map_or_else(|| path.0.clone(), |name| name.to_string_lossy().into_owned());
    Ok((full, name))
}

/// Reads the whole file at `full`, which the user knows as `shown`; `name` names its size.
pub(crate) fn load_whole(full: &Path, shown: &str, name: &str, job: &Job) -> Result<Vec<u8>> {
    let refused = |reason: std::io::Error| Error::reading(shown, reason);
    let mut file = File::open(full).map_err(refused)?;
    let len = file.metadata().map_err(refused)?.len();
    job.admit(len, || format!("the file {name}"))?;
    let mut bytes = Vec::new();
    let wanted = usize::try_from(len).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(wanted).map_err(|reason| Error::reading(shown, reason))?;
    // Reading in pieces keeps a long read cancellable.
    const PIECE: u64 = 16 << 20;
    loop {
        job.check()?;
        if Read::by_ref(&mut file).take(PIECE).read_to_end(&mut bytes).map_err(refused)? == 0 {
            return Ok(bytes);
        }
        job.admit(bytes.len() as u64, || format!("the file {name}"))?;
    }
}

/// Writes a file through `fill`, which gets a buffered stream; the file appears only when all went well.
pub(crate) fn save(
    path: &OutputPath,
    job: &Job,
    fill: impl FnOnce(&mut BufWriter<Box<dyn OutputStream>>) -> Result<()>,
) -> Result<()> {
    let mut out = begin(path, job)?;
    fill(&mut out)?;
    end(out, path, job)
}

/// Begins a file as a buffered stream; it appears when it is [ended](end).
pub(crate) fn begin(path: &OutputPath, job: &Job) -> Result<BufWriter<Box<dyn OutputStream>>> {
    Ok(BufWriter::with_capacity(1 << 18, job.create(path)?))
}

/// Puts a file in its place.
pub(crate) fn end(mut out: BufWriter<Box<dyn OutputStream>>, path: &OutputPath, job: &Job) -> Result<()> {
    job.check()?;
    out.flush().map_err(|reason| Error::writing(&path.0, reason))?;
    out.into_inner().map_err(|failed| Error::writing(&path.0, failed.error()))?.finish()
}

/// Writes bytes made in memory.
pub(crate) fn save_bytes(path: &OutputPath, bytes: &[u8], job: &Job) -> Result<()> {
    save(path, job, |out| {
        bytes.chunks(16 << 20).try_for_each(|piece| {
            job.check()?;
            out.write_all(piece).map_err(|reason| Error::writing(&path.0, reason))
        })
    })
}

/// Refuses a raster with an infinite height: no node downstream could make sense of it.
pub(crate) fn refuse_infinite(terrain: &Heightfield, name: &str) -> Result<()> {
    const PART: usize = 1 << 12;
    // Whether there is one is asked of many cells at once; where it is only matters then.
    let any = |cells: &&[f32]| cells.iter().fold(false, |any, height| any | height.is_infinite());
    let place =
        terrain.cells().par_chunks(PART).enumerate().with_min_len(16).find_first(|(_, cells)| any(cells));
    let place = place.and_then(|(part, cells)| {
        cells.iter().position(|height| height.is_infinite()).map(|at| part * PART + at)
    });
    let cols = terrain.cols().max(1);
    place.map_or(Ok(()), |at| Err(Error::NonFinite { what: name.into(), row: at / cols, col: at % cols }))
}

/// Refuses to write a raster that no format could hold, or that no reader would take back.
pub(crate) fn refuse_empty<K: orograph_core::Kind>(raster: &Raster<K>, what: &str) -> Result<()> {
    if raster.grid().is_empty() { Err(Error::EmptyInput { what: what.into() }) } else { Ok(()) }
}

/// Whether the name ends in `.extension`, in whatever case.
pub(crate) fn has_extension(name: &str, extension: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, found)| found.eq_ignore_ascii_case(extension))
}

/// Refuses an output name whose extension says another format than the one written.
pub(crate) fn check_extension(path: &OutputPath, allowed: &[&str]) -> Result<()> {
    if allowed.iter().any(|extension| has_extension(&path.0, extension)) {
        return Ok(());
    }
    Err(Error::invalid(
        format!("`{}` does not end in .{}", path.0, allowed.join(" or .")),
        format!("name the file `….{}`", allowed.first().unwrap_or(&"")),
    ))
}
