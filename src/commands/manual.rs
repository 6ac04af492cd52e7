//! `orograph manual`: the pages of all node types, written or compared.

use std::{fs, path::Path};

use orograph_engine::{manual, write_whole};

use crate::{arguments::ManualOptions, console, failure::Failure};

pub(crate) fn run(options: &ManualOptions) -> Result<(), Failure> {
    let pages = manual::book(&orograph_session::built_in()?);
    if options.check {
        return check(&options.out, &pages);
    }
    for (name, text) in &pages {
        write_whole(&options.out, &options.out.join(name), &[text.as_bytes()]).map_err(|error| {
            Failure::Other(format!("writing {}: {error}", options.out.join(name).display()))
        })?;
    }
    console::result(&format!("{} pages in {}", pages.len(), options.out.display()));
    Ok(())
}

fn check(folder: &Path, pages: &[(String, String)]) -> Result<(), Failure> {
    let mut stale: Vec<String> = pages
        .iter()
        .filter(|(name, text)| fs::read_to_string(folder.join(name)).ok().as_ref() != Some(text))
        .map(|(name, _)| name.clone())
        .collect();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") && !pages.iter().any(|(page, _)| *page == name) {
            stale.push(name);
        }
    }
    if stale.is_empty() {
        console::result(&format!("{} pages in {} are up to date", pages.len(), folder.display()));
        return Ok(());
    }
    Err(Failure::Other(format!(
        "the manual in {} is stale ({}); write it again with `orograph manual --out {}`",
        folder.display(),
        stale.join(", "),
        folder.display()
    )))
}
