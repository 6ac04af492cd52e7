//! The gallery: the papers' figures from our own runs, in `docs/gallery`.
//!
//! `cargo run --release --example gallery` runs those graphs of `docs/gallery/figures.ron` that give something else than the
//! gallery shows, and writes their pictures, small, `made.json` with the numbers of the runs, and the pages. Names of
//! graphs as arguments run these alone, `--all` runs every one. Graphs that read real elevation models need their
//! folder (`OROGRAPH_DEM_DIR`, by default `../shared/dem`).
//!
//! The test beside it tells without any run when a page or a picture is older than what it shows.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command reports")]

mod figures;
mod made;
mod pages;

use std::{env, fs, path::Path, process::ExitCode};

use orograph_session::{headless, memory::default_memory, pictures};

use figures::Figure;
use made::Made;

/// The widest picture.
const WIDTH: u32 = 700;
/// Most bytes of all pictures.
#[cfg(test)]
const MOST: u64 = 12_000_000;

type Result<T, E = String> = std::result::Result<T, E>;

fn main() -> ExitCode {
    let asked: Vec<String> = env::args().skip(1).collect();
    match write(&asked) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn write(asked: &[String]) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let gallery = root.join("docs/gallery");
    let papers = figures::load(&gallery)?;
    let mut made = Made::load(&gallery)?;
    let figures = || papers.iter().flat_map(|paper| &paper.figures);
    let is_known = |name: &String| name == "--all" || figures().any(|figure| figure.graph == *name);
    if let Some(name) = asked.iter().find(|name| !is_known(name)) {
        return Err(format!("the gallery has no figure {name}; docs/gallery/figures.ron lists them"));
    }
    for figure in figures() {
        let is_wanted = match asked {
            [] => {
                !made.is_fresh(figure, root)?
                    || figure.pictures.iter().any(|name| !gallery.join(figure.shown_as(name)).is_file())
            }
            _ => asked.iter().any(|name| name == "--all" || figure.graph == *name),
        };
        if !is_wanted {
            continue;
        }
        println!("{}", figure.graph);
        make(figure, root, &gallery, &mut made)?;
        made.save(&gallery)?;
    }
    made.forget_all_but(&papers);
    made.save(&gallery)?;
    for (name, text) in pages::all(&papers, &made, root)? {
        fs::write(gallery.join(&name), text).map_err(|error| format!("writing {name}: {error}"))?;
    }
    println!("{} figures in {}", figures().count(), gallery.display());
    Ok(())
}

/// Runs the graph of a figure and keeps its pictures and numbers.
fn make(figure: &Figure, root: &Path, gallery: &Path, made: &mut Made) -> Result<()> {
    let registry = orograph_session::built_in().map_err(|error| error.in_words())?;
    // One for each: what a figure holds in memory is of no use to the next.
    let (evaluator, _) =
        orograph_session::evaluator(default_memory(), None, 0).map_err(|error| error.in_words())?;
    let scratch = tempfile::tempdir().map_err(|error| error.to_string())?;
    let overrides = figure.set.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
    let ran = headless::run(&figure.file(root), overrides, scratch.path(), &registry, &evaluator)
        .map_err(|error| error.in_words())?;
    for name in &figure.pictures {
        let picture = pictures::read(&scratch.path().join(name)).map_err(|error| error.to_string())?;
        let picture = pictures::fitted(picture, WIDTH).map_err(|error| error.to_string())?;
        pictures::write(&picture, gallery, &figure.shown_as(name)).map_err(|error| error.to_string())?;
    }
    made.remember(figure, &ran.tables, root)
}

#[cfg(test)]
mod tests {
    // A helper that fails is a test that fails.
    #![allow(clippy::unwrap_used)]

    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_gallery_is_fresh() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let gallery = root.join("docs/gallery");
        let papers = figures::load(&gallery).unwrap();
        let made = Made::load(&gallery).unwrap();
        let mend = "cargo run --release --example gallery";
        let mut expected: BTreeSet<String> = ["figures.ron", "made.json"].map(str::to_owned).into();
        let mut bytes = 0;
        for figure in papers.iter().flat_map(|paper| &paper.figures) {
            let graph = &figure.graph;
            assert!(made.is_fresh(figure, root).unwrap(), "{graph} gives something else now: {mend}");
            for name in &figure.pictures {
                let path = gallery.join(figure.shown_as(name));
                let picture = pictures::read(&path).unwrap_or_else(|error| panic!("{error}"));
                assert!(picture.grid().cols <= WIDTH as usize, "{name} is too wide");
                bytes += fs::metadata(&path).unwrap().len();
                expected.insert(figure.shown_as(name));
            }
        }
        assert!(bytes <= MOST, "the pictures have {bytes} bytes");
        for (name, text) in pages::all(&papers, &made, root).unwrap() {
            let found = fs::read_to_string(gallery.join(&name)).unwrap_or_default();
            assert!(found == text, "{name} is stale: {mend}");
            expected.insert(name);
        }
        let found = fs::read_dir(&gallery).unwrap().map(|entry| entry.unwrap().file_name());
        let strange: Vec<_> = found
            .map(|name| name.to_string_lossy().into_owned())
            .filter(|name| !expected.contains(name))
            .collect();
        assert!(strange.is_empty(), "nothing in the gallery shows {strange:?}");
    }

    #[test]
    fn every_figure_among_the_graphs_is_shown() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let papers = figures::load(&root.join("docs/gallery")).unwrap();
        let shown: BTreeSet<_> =
            papers.iter().flat_map(|paper| &paper.figures).map(|figure| &*figure.graph).collect();
        for entry in fs::read_dir(root.join("graphs")).unwrap() {
            let name = entry.unwrap().file_name().to_string_lossy().into_owned();
            if let Some(graph) = name.strip_suffix(".ron").filter(|graph| graph.contains("-fig")) {
                assert!(shown.contains(graph), "the gallery lacks {graph}");
            }
        }
    }
}
