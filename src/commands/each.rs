//! `run --each`: one graph for every file that a pattern matches, such as a folder of tiles.
//!
//! `{stem}` in the values of `--set` stands for the file's name up to its first dot.

use std::path::{Path, PathBuf};

use indexmap::IndexMap;

use crate::{arguments::RunOptions, failure::Failure};

/// One file's run.
pub(crate) struct Item {
    /// The file; none where the graph is run once.
    pub(crate) file: Option<PathBuf>,
    /// How the graph is run for it.
    pub(crate) options: RunOptions,
}

/// The runs that the options ask for: one, or one for each file, in order of their names, with a folder of its own.
pub(crate) fn items(options: &RunOptions) -> Result<Vec<Item>, Failure> {
    let Some(each) = &options.each else {
        return Ok(vec![Item { file: None, options: options.clone() }]);
    };
    let wrong =
        |why: String| Failure::usage(format!("`--each {each}` {why}"), "write --each file='tiles/*.hgt'");
    let (name, pattern) = each.split_once('=').ok_or_else(|| wrong("has no `=`".into()))?;
    let matched = glob::glob(pattern.trim()).map_err(|error| wrong(format!("is no pattern: {error}")))?;
    let mut files = Vec::new();
    for file in matched {
        let file = file.map_err(|error| Failure::Other(error.to_string()))?;
        if file.is_file() {
            files.push(file);
        }
    }
    if files.is_empty() {
        return Err(Failure::usage(
            format!("`--each {each}` matches no file"),
            "patterns count from the folder that the command is run in; quote them",
        ));
    }
    let mut folders: IndexMap<String, PathBuf> = IndexMap::new();
    let mut items = Vec::new();
    for file in files {
        let folder = stem(&file);
        if let Some(other) = folders.insert(folder.clone(), file.clone()) {
            return Err(Failure::usage(
                format!("{} and {} would both write into {folder}", other.display(), file.display()),
                "narrow the pattern",
            ));
        }
        let absolute = std::path::absolute(&file).unwrap_or_else(|_| file.clone());
        let mut options = options.clone();
        for set in &mut options.settings.set {
            *set = set.replace("{stem}", &folder);
        }
        options.settings.set.push(format!("{}={}", name.trim(), absolute.display()));
        options.evaluation.out.push(folder);
        items.push(Item { file: Some(file), options });
    }
    Ok(items)
}

/// The file's name up to its first dot: of `N46E008.hgt.zip` the tile.
fn stem(file: &Path) -> String {
    let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match name.split_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.to_owned(),
        _ => name,
    }
}
