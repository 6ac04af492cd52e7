//! `orograph manual`: the pages of all node types with their pictures, written or compared.

mod illustrate;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use orograph_core::Texture;
use orograph_engine::{manual, write_whole};
use orograph_session::pictures;

use crate::{arguments::ManualOptions, console, failure::Failure};
use illustrate::Illustrated;

/// Names of stale files that are told.
const TOLD: usize = 8;

pub(crate) fn run(options: &ManualOptions) -> Result<(), Failure> {
    let registry = orograph_session::built_in()?;
    let Illustrated { texts, pictures } = illustrate::all(&registry, &options.graphs, &options.out)?;
    let pages = manual::book(&registry, &texts);
    if options.check {
        return check(&options.out, &pages, &pictures);
    }
    for (name, text) in &pages {
        let file = options.out.join(name);
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)
                .map_err(|error| Failure::Other(format!("writing {}: {error}", folder.display())))?;
        }
        write_whole(&options.out, &file, &[text.as_bytes()])
            .map_err(|error| Failure::Other(format!("writing {}: {error}", file.display())))?;
    }
    for (name, picture) in &pictures {
        // A picture that shows the same stays as it is: another packer may have written it.
        if !is_same(&options.out.join(name), picture) {
            pictures::write(picture, &options.out, name)
                .map_err(|error| Failure::Other(error.to_string()))?;
        }
    }
    let (pages, pictures, out) = (pages.len(), pictures.len(), options.out.display());
    console::result(&format!("{pages} pages and {pictures} pictures in {out}"));
    Ok(())
}

fn check(
    folder: &Path,
    pages: &[(String, String)],
    pictures: &BTreeMap<String, Texture>,
) -> Result<(), Failure> {
    let mut stale: Vec<String> = pages
        .iter()
        .filter(|(name, text)| fs::read_to_string(folder.join(name)).ok().as_ref() != Some(text))
        .map(|(name, _)| name.clone())
        .collect();
    let other = pictures.iter().filter(|(name, picture)| !is_same(&folder.join(name), picture));
    stale.extend(other.map(|(name, _)| name.clone()));
    let is_known = |name: &str| pages.iter().any(|(page, _)| page == name) || pictures.contains_key(name);
    stale.extend(files_below(folder).into_iter().filter(|name| !is_known(name)));
    if stale.is_empty() {
        let (pages, pictures) = (pages.len(), pictures.len());
        console::result(&format!(
            "{pages} pages and {pictures} pictures in {} are up to date",
            folder.display()
        ));
        return Ok(());
    }
    let more = stale.len().saturating_sub(TOLD);
    stale.truncate(TOLD);
    if more > 0 {
        stale.push(format!("and {more} more"));
    }
    let (out, stale) = (folder.display(), stale.join(", "));
    Err(Failure::Other(format!(
        "the manual in {out} is stale ({stale}); write it again with `orograph manual --out {out}`"
    )))
}

/// Whether the file holds that picture, pixel for pixel.
fn is_same(file: &Path, picture: &Texture) -> bool {
    let same =
        |found: Texture| found.grid().size() == picture.grid().size() && found.cells() == picture.cells();
    file.is_file() && pictures::read(file).is_ok_and(same)
}

/// The pages and pictures in a folder and in those in it.
fn files_below(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut folders: Vec<PathBuf> = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in fs::read_dir(&next).into_iter().flatten().flatten().map(|entry| entry.path()) {
            let is_ours = path.extension().is_some_and(|ending| ending == "md" || ending == "png");
            if path.is_dir() {
                folders.push(path);
            } else if is_ours && let Ok(name) = path.strip_prefix(folder) {
                names.push(name.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    names.sort();
    names
}
