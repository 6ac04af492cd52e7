//! What an edit changed, so that it can be taken back.
//!
//! A delta is found by comparing the documents before and after an edit. An edit is then any function on a
//! document, and what undoes it cannot be forgotten.

use std::hash::Hash;

use indexmap::IndexMap;
use orograph_engine::{
    Document,
    document::{Bend, Comment, Exposed, Frame, GraphInput, Link, Literal, Node},
};

/// What stood at a place before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap<T> {
    /// Before.
    pub before: T,
    /// After.
    pub after: T,
}

/// One thing that changed; what is absent is `None`.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// What the graph shows.
    Doc(Swap<String>),
    /// An exposed parameter.
    Exposed(String, Swap<Option<Exposed>>),
    /// An input of the graph.
    Input(String, Swap<Option<GraphInput>>),
    /// A named output.
    Output(String, Swap<Option<Link>>),
    /// A node, whole.
    Node(String, Swap<Option<Box<Node>>>),
    /// One setting of a node that otherwise stayed as it was.
    Param(Link, Swap<Option<Literal>>),
    /// The wires of one input.
    Wires(Link, Swap<Option<Vec<Link>>>),
    /// Where a node stands.
    Position(String, Swap<Option<(f64, f64)>>),
    /// The frames.
    Frames(Swap<Vec<Frame>>),
    /// The comments on the canvas.
    Comments(Swap<Vec<Comment>>),
    /// The bends of wires.
    Bends(Swap<Vec<Bend>>),
    /// A field of the graph that format 1 does not know.
    Field(String, Swap<Option<Literal>>),
    /// Such a field of the layout.
    LayoutField(String, Swap<Option<Literal>>),
}

/// Everything that one edit changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Delta {
    changes: Vec<Change>,
}

/// A delta does not fit the document: it was made on another one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this change was made on another document")]
pub struct Foreign;

impl Delta {
    /// What turns `before` into `after`.
    #[must_use]
    pub fn between(before: &Document, after: &Document) -> Self {
        let mut changes = Vec::new();
        if before.doc != after.doc {
            changes.push(Change::Doc(swap(&before.doc, &after.doc)));
        }
        differences(&before.expose, &after.expose, |name, swap| changes.push(Change::Exposed(name, swap)));
        differences(&before.inputs, &after.inputs, |name, swap| changes.push(Change::Input(name, swap)));
        differences(&before.outputs, &after.outputs, |name, swap| changes.push(Change::Output(name, swap)));
        nodes(before, after, &mut changes);
        let (old, new) = (&before.layout, &after.layout);
        differences(&old.nodes, &new.nodes, |name, swap| changes.push(Change::Position(name, swap)));
        if old.frames != new.frames {
            changes.push(Change::Frames(swap(&old.frames, &new.frames)));
        }
        if old.comments != new.comments {
            changes.push(Change::Comments(swap(&old.comments, &new.comments)));
        }
        if old.bends != new.bends {
            changes.push(Change::Bends(swap(&old.bends, &new.bends)));
        }
        differences(&old.extra, &new.extra, |name, swap| changes.push(Change::LayoutField(name, swap)));
        differences(&before.extra, &after.extra, |name, swap| changes.push(Change::Field(name, swap)));
        Self { changes }
    }

    /// Whether nothing changed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// What changed.
    #[must_use]
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Whether a result can have changed, and not the picture of the graph alone.
    #[must_use]
    pub fn changes_results(&self) -> bool {
        self.changes.iter().any(|change| match change {
            Change::Doc(_)
            | Change::Position(..)
            | Change::Frames(_)
            | Change::Comments(_)
            | Change::Bends(_)
            | Change::LayoutField(..) => false,
            Change::Node(_, Swap { before: Some(before), after: Some(after) }) => {
                let said = |node: &Node| Node { comment: String::new(), ..node.clone() };
                said(before) != said(after)
            }
            _ => true,
        })
    }

    /// What takes this back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let changes = self.changes.iter().rev().map(Change::inverse).collect();
        Self { changes }
    }

    /// Makes the changes.
    ///
    /// # Errors
    /// [`Foreign`] when something is not as it was before the edit; the document is then as before.
    pub fn apply(&self, document: &mut Document) -> Result<(), Foreign> {
        for (done, change) in self.changes.iter().enumerate() {
            if change.apply(document).is_err() {
                for change in self.changes[..done].iter().rev() {
                    change.inverse().apply(document)?;
                }
                return Err(Foreign);
            }
        }
        Ok(())
    }
}

fn nodes(before: &Document, after: &Document, changes: &mut Vec<Change>) {
    for (name, old) in &before.nodes {
        let Some(new) = after.nodes.get(name) else { continue };
        if old == new {
            continue;
        }
        let alike = Node { params: old.params.clone(), inputs: old.inputs.clone(), ..new.clone() };
        if alike != *old {
            changes.push(whole(name, Some(old), Some(new)));
            continue;
        }
        let at = |port: String| Link::new(name.clone(), port);
        differences(&old.params, &new.params, |param, swap| changes.push(Change::Param(at(param), swap)));
        differences(&old.inputs, &new.inputs, |port, swap| changes.push(Change::Wires(at(port), swap)));
    }
    for (name, old) in before.nodes.iter().filter(|(name, _)| !after.nodes.contains_key(*name)) {
        changes.push(whole(name, Some(old), None));
    }
    for (name, new) in after.nodes.iter().filter(|(name, _)| !before.nodes.contains_key(*name)) {
        changes.push(whole(name, None, Some(new)));
    }
}

fn whole(name: &str, before: Option<&Node>, after: Option<&Node>) -> Change {
    let boxed = |node: Option<&Node>| node.cloned().map(Box::new);
    Change::Node(name.to_owned(), Swap { before: boxed(before), after: boxed(after) })
}

fn swap<T: Clone>(before: &T, after: &T) -> Swap<T> {
    Swap { before: before.clone(), after: after.clone() }
}

/// Tells of each entry that came, went or changed.
fn differences<T: Clone + PartialEq>(
    before: &IndexMap<String, T>,
    after: &IndexMap<String, T>,
    mut tell: impl FnMut(String, Swap<Option<T>>),
) {
    for (name, old) in before {
        let new = after.get(name);
        if new != Some(old) {
            tell(name.clone(), Swap { before: Some(old.clone()), after: new.cloned() });
        }
    }
    for (name, new) in after.iter().filter(|(name, _)| !before.contains_key(*name)) {
        tell(name.clone(), Swap { before: None, after: Some(new.clone()) });
    }
}

impl Change {
    fn inverse(&self) -> Self {
        fn turned<T: Clone>(swap: &Swap<T>) -> Swap<T> {
            Swap { before: swap.after.clone(), after: swap.before.clone() }
        }
        match self {
            Self::Doc(swap) => Self::Doc(turned(swap)),
            Self::Exposed(name, swap) => Self::Exposed(name.clone(), turned(swap)),
            Self::Input(name, swap) => Self::Input(name.clone(), turned(swap)),
            Self::Output(name, swap) => Self::Output(name.clone(), turned(swap)),
            Self::Node(name, swap) => Self::Node(name.clone(), turned(swap)),
            Self::Param(at, swap) => Self::Param(at.clone(), turned(swap)),
            Self::Wires(at, swap) => Self::Wires(at.clone(), turned(swap)),
            Self::Position(name, swap) => Self::Position(name.clone(), turned(swap)),
            Self::Frames(swap) => Self::Frames(turned(swap)),
            Self::Comments(swap) => Self::Comments(turned(swap)),
            Self::Bends(swap) => Self::Bends(turned(swap)),
            Self::Field(name, swap) => Self::Field(name.clone(), turned(swap)),
            Self::LayoutField(name, swap) => Self::LayoutField(name.clone(), turned(swap)),
        }
    }

    fn apply(&self, document: &mut Document) -> Result<(), Foreign> {
        match self {
            Self::Doc(swap) => set(&mut document.doc, swap),
            Self::Exposed(name, swap) => entry(&mut document.expose, name, swap),
            Self::Input(name, swap) => entry(&mut document.inputs, name, swap),
            Self::Output(name, swap) => entry(&mut document.outputs, name, swap),
            Self::Node(name, Swap { before, after }) => {
                let own = |node: &Option<Box<Node>>| node.as_deref().cloned();
                entry(&mut document.nodes, name, &Swap { before: own(before), after: own(after) })
            }
            Self::Param(Link { node, port }, swap) => {
                entry(&mut document.nodes.get_mut(node).ok_or(Foreign)?.params, port, swap)
            }
            Self::Wires(Link { node, port }, swap) => {
                entry(&mut document.nodes.get_mut(node).ok_or(Foreign)?.inputs, port, swap)
            }
            Self::Position(name, swap) => entry(&mut document.layout.nodes, name, swap),
            Self::Frames(swap) => set(&mut document.layout.frames, swap),
            Self::Comments(swap) => set(&mut document.layout.comments, swap),
            Self::Bends(swap) => set(&mut document.layout.bends, swap),
            Self::Field(name, swap) => entry(&mut document.extra, name, swap),
            Self::LayoutField(name, swap) => entry(&mut document.layout.extra, name, swap),
        }
    }
}

fn set<T: Clone + PartialEq>(place: &mut T, swap: &Swap<T>) -> Result<(), Foreign> {
    if *place != swap.before {
        return Err(Foreign);
    }
    *place = swap.after.clone();
    Ok(())
}

fn entry<K: Hash + Eq + Clone + indexmap::Equivalent<K>, T: Clone + PartialEq>(
    map: &mut IndexMap<K, T>,
    key: &K,
    swap: &Swap<Option<T>>,
) -> Result<(), Foreign> {
    if map.get(key) != swap.before.as_ref() {
        return Err(Foreign);
    }
    match &swap.after {
        Some(after) => {
            map.insert(key.clone(), after.clone());
        }
        None => {
            map.shift_remove(key);
        }
    }
    Ok(())
}
