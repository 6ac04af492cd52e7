//! The pages of the gallery, from what the papers print, what the graphs say and what their runs gave.

use std::{fmt::Write, path::Path};

use orograph_engine::{
    Document,
    document::{Body, Literal},
};

use crate::{
    Result,
    figures::{Figure, Paper},
    made::Made,
};

const INDEX: &str = "\
# Gallery

The figures of three papers, each from a run of ours: its picture, what it shows, the command that makes it, and the \
paper's numbers beside ours. The pictures are made from sketches and invented ground of our own and from elevation data in \
the public domain: NASA and NGA SRTM, and models of the U.S. Geological Survey and the U.S. Forest Service; the notices \
of those in the repository stand in [graphs/data](../../graphs/data/NOTICES.md).

| Paper | Figures |
|---|---|
";

const COMMAND: &str = "
All of it is made by one command, and a test tells when a picture is older than its graph:

```sh
cargo run --release --example gallery
```

Times are properties of machines; ours stand in [performance](../performance.md). What each node does is in the \
[manual](../manual/index.md).
";

/// All pages by name.
pub(crate) fn all(papers: &[Paper], made: &Made, root: &Path) -> Result<Vec<(String, String)>> {
    let mut index = INDEX.to_owned();
    let mut pages = Vec::new();
    for paper in papers {
        let _ = writeln!(index, "| [{}]({}.md) | {} |", paper.source, paper.page, paper.figures.len());
        pages.push((format!("{}.md", paper.page), page(paper, made, root)?));
    }
    index.push_str(COMMAND);
    pages.push(("index.md".into(), index));
    Ok(pages)
}

fn page(paper: &Paper, made: &Made, root: &Path) -> Result<String> {
    let mut page = format!("# {}\n\n{}\n", paper.source, paper.about.trim());
    for figure in &paper.figures {
        page.push_str(&section(figure, made, root)?);
    }
    let _ =
        write!(page, "\n## Figures that are not here\n\n{}\n\n[Gallery](index.md)\n", paper.missing.trim());
    Ok(page)
}

fn section(figure: &Figure, made: &Made, root: &Path) -> Result<String> {
    let document = Document::load(&figure.file(root)).map_err(|errors| errors.to_string())?;
    let graph = &figure.graph;
    let mut text = format!("\n## {}\n\n{}", figure.title, document.doc.trim());
    if !figure.note.is_empty() {
        let _ = write!(text, " {}", figure.note.trim());
    }
    text.push_str("\n\n");
    for paragraph in remarks(&document.header) {
        let _ = write!(text, "{paragraph}\n\n");
    }
    for picture in &figure.pictures {
        let (alt, name) = (document.doc.trim_end_matches('.'), figure.shown_as(picture));
        let _ = write!(text, "![{alt}]({name})\n\n");
        if let Some(labels) = labels(&document, picture) {
            let _ = write!(text, "Row by row: {labels}.\n\n");
        }
    }
    let mut command = format!("orograph run graphs/{graph}.ron");
    for (name, value) in &figure.set {
        // A shell would read the variable itself.
        let quote = if value.contains('$') { "'" } else { "" };
        let _ = write!(command, " --set {quote}{name}={value}{quote}");
    }
    let _ = write!(text, "[`graphs/{graph}.ron`](../../graphs/{graph}.ron)\n\n```sh\n{command}\n```\n");
    if !figure.numbers.is_empty() {
        text.push_str("\n| | Paper | Ours |\n|---|---|---|\n");
    }
    for number in &figure.numbers {
        let ours = made.number(figure, &number.ours).unwrap_or("not run yet");
        let paper = if number.paper.is_empty() { "–" } else { &number.paper };
        let _ = writeln!(text, "| {} | {paper} | {ours} |", number.what);
    }
    Ok(text)
}

/// What stands under the parts of a picture, which is hard to read when it is small.
fn labels(document: &Document, picture: &str) -> Option<String> {
    let writes = |value: &Literal| matches!(value, Literal::Text(file) if file == picture);
    let writer = document.nodes.values().find(|node| node.params.get("file").is_some_and(writes))?;
    let sheet = document.nodes.get(&writer.inputs.get("texture")?.first()?.node)?;
    match (&sheet.body, sheet.params.get("labels")?) {
        (Body::Type { id, .. }, Literal::Text(labels)) if id == "look.contact_sheet" => Some(labels.clone()),
        _ => None,
    }
}

/// What the comment at the head of a graph says after its first paragraph, which is a title.
fn remarks(header: &str) -> Vec<String> {
    let lines: Vec<_> = header.lines().map(|line| line.trim_start_matches('/').trim()).collect();
    lines
        .split(|line| line.is_empty())
        .skip(1)
        .map(|lines| lines.join(" "))
        .filter(|text| !text.is_empty())
        .collect()
}
