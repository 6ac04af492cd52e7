//! The fields that format 1 knows, and those of a document that it does not.

use indexmap::IndexMap;

use super::{Document, Literal};

pub(super) const DOCUMENT: [&str; 7] = ["format", "doc", "expose", "inputs", "outputs", "nodes", "layout"];
pub(super) const EXPOSED: [&str; 3] = ["param", "doc", "range"];
pub(super) const INPUT: [&str; 2] = ["type", "doc"];
pub(super) const LAYOUT: [&str; 4] = ["nodes", "frames", "comments", "bends"];
pub(super) const FRAME: [&str; 2] = ["title", "rect"];
pub(super) const COMMENT: [&str; 2] = ["text", "at"];
pub(super) const BEND: [&str; 3] = ["from", "to", "through"];
pub(crate) const NODE_FIELDS: [&str; 8] =
    ["node", "version", "graph", "params", "inputs", "bypass", "comment", "plugin"];

/// Where a field stands that format 1 does not know, and the fields that it knows there.
type UnknownField = (Vec<String>, &'static [&'static str]);

/// The fields of all but nodes that format 1 does not know.
pub(crate) fn unknown_fields(document: &Document) -> Vec<UnknownField> {
    let mut unknown = Vec::new();
    let mut add = |place: &[&str], extra: &IndexMap<String, Literal>, known: &'static [&'static str]| {
        for field in extra.keys() {
            let path = place.iter().map(|step| (*step).to_owned()).chain([field.clone()]).collect();
            unknown.push((path, known));
        }
    };
    add(&[], &document.extra, &DOCUMENT);
    for (name, exposed) in &document.expose {
        add(&["expose", name], &exposed.extra, &EXPOSED);
    }
    for (name, input) in &document.inputs {
        add(&["inputs", name], &input.extra, &INPUT);
    }
    let layout = &document.layout;
    add(&["layout"], &layout.extra, &LAYOUT);
    for (index, frame) in layout.frames.iter().enumerate() {
        add(&["layout", "frames", &index.to_string()], &frame.extra, &FRAME);
    }
    for (index, comment) in layout.comments.iter().enumerate() {
        add(&["layout", "comments", &index.to_string()], &comment.extra, &COMMENT);
    }
    for (index, bend) in layout.bends.iter().enumerate() {
        add(&["layout", "bends", &index.to_string()], &bend.extra, &BEND);
    }
    unknown
}
