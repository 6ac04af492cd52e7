//! The pictures of the manual: each node's small graph, run whole.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use orograph_core::Texture;
use orograph_engine::{
    Registry,
    manual::{Illustration, page_name},
};
use orograph_session::{headless, memory::default_memory, pictures, tables};

use crate::failure::Failure;

/// Rows of a table that a page shows.
const ROWS: usize = 8;

/// What illustrates the manual.
#[derive(Default)]
pub(super) struct Illustrated {
    /// By the id of the node.
    pub(super) texts: BTreeMap<String, Illustration>,
    /// By the name of the file.
    pub(super) pictures: BTreeMap<String, Texture>,
}

/// Runs the graph of every node; nothing without the folder of graphs.
pub(super) fn all(registry: &Registry, graphs: &Path, out: &Path) -> Result<Illustrated, Failure> {
    if !graphs.is_dir() {
        return Ok(Illustrated::default());
    }
    let specs: Vec<_> = registry.iter().map(|node_type| node_type.spec()).collect();
    let file_of = |id: &str| graphs.join(format!("{id}.ron"));
    let lacking: Vec<_> = specs.iter().map(|spec| &*spec.id).filter(|id| !file_of(id).is_file()).collect();
    if !lacking.is_empty() {
        return Err(Failure::usage(
            format!("no graph in {} shows {}", graphs.display(), lacking.join(", ")),
            "write one that bears the node's id and writes a picture of that name",
        ));
    }
    // What many of them begin with is computed once.
    let (evaluator, _) = orograph_session::evaluator(default_memory(), None, 0)?;
    let scratch =
        tempfile::tempdir().map_err(|error| Failure::Other(format!("a folder for pictures: {error}")))?;
    let mut illustrated = Illustrated::default();
    for spec in specs {
        let (id, file) = (&*spec.id, file_of(&spec.id));
        let folder = scratch.path().join(id);
        let ran = headless::run(&file, Vec::new(), &folder, registry, &evaluator)?;
        let graph = fs::read_to_string(&file)
            .map_err(|error| Failure::Other(format!("reading {}: {error}", file.display())))?;
        let named = ran.tables.iter().map(|(name, table)| (name.clone(), tables::markdown(table, ROWS)));
        let illustration = Illustration {
            doc: ran.document.doc.clone(),
            graph,
            link: seen_from(&out.join(page_name(spec, "md")), &file),
            tables: named.collect(),
        };
        let picture = pictures::read(&folder.join(format!("{id}.png"))).map_err(|error| {
            Failure::usage(format!("{}: {error}", file.display()), format!("let it write {id}.png"))
        })?;
        illustrated.texts.insert(id.to_owned(), illustration);
        illustrated.pictures.insert(page_name(spec, "png"), picture);
    }
    Ok(illustrated)
}

/// The way from a page to a file, for a link.
fn seen_from(page: &Path, file: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (page, file) = (absolute(page.parent().unwrap_or(page)), absolute(file));
    let shared = page.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = page.components().skip(shared).map(|_| Path::new(".."));
    let way: PathBuf =
        up.chain(file.components().skip(shared).map(|part| Path::new(part.as_os_str()))).collect();
    way.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_goes_up_and_down_again() {
        let way = seen_from(Path::new("docs/manual/mask/voids.md"), Path::new("graphs/nodes/mask.voids.ron"));
        assert_eq!(way, "../../../graphs/nodes/mask.voids.ron");
        assert_eq!(seen_from(Path::new("a/b.md"), Path::new("a/c.ron")), "c.ron");
    }
}
