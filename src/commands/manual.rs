//! `orograph manual`: the pages of all node types, written or compared.

use std::{fs, io::Write, path::Path};

use orograph_engine::manual;

use crate::{arguments::ManualOptions, console, failure::Failure, session};

pub(crate) fn run(options: &ManualOptions) -> Result<(), Failure> {
    let pages = manual::book(&session::built_in()?);
    if options.check {
        return check(&options.out, &pages);
    }
    for (name, text) in &pages {
        write(&options.out.join(name), text).map_err(|error| {
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

fn write(path: &Path, text: &str) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.persist(path)?;
    Ok(())
}
