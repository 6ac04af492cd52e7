//! What a node is, as data. Registry, graph files, command line, manual, editor and C ABI read only this.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{ParamValue, Unit, ValueType};

/// Text that a built-in node holds as a literal and a plugin's spec owns.
pub(crate) type Text = Cow<'static, str>;

/// A node type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeSpec {
    /// Permanent name, `family.algorithm`.
    pub id: Text,
    /// Raised whenever equal inputs may give other outputs.
    pub version: u32,
    /// What it does; the first sentence stands alone as a tooltip.
    pub doc: Text,
    /// Input ports.
    #[serde(default)]
    pub inputs: Vec<PortSpec>,
    /// Output ports; none for a node that writes a file.
    #[serde(default)]
    pub outputs: Vec<PortSpec>,
    /// Parameters.
    #[serde(default)]
    pub params: Vec<ParamSpec>,
    /// How far its outputs look.
    pub extent: Extent,
    /// What it reads of the run's context.
    #[serde(default)]
    pub reads: Vec<ContextItem>,
    /// Writes files: it runs for its effect and is never cached.
    #[serde(default)]
    pub writes: bool,
    /// The writer chosen when a bare output of its first input's type is asked for.
    #[serde(default)]
    pub default_writer: bool,
}

impl NodeSpec {
    /// The part of the id before the dot.
    #[must_use]
    pub fn family(&self) -> &str {
        self.id.split('.').next().unwrap_or(&self.id)
    }

    /// First sentence of the docs, on one line.
    #[must_use]
    pub fn summary(&self) -> String {
        first_sentence(&self.doc)
    }

    /// The parameters that name files to read, by index, with the names that `values`, in the spec's order, give.
    pub fn input_files<'a>(&self, values: &'a [ParamValue]) -> impl Iterator<Item = (usize, &'a str)> {
        self.params.iter().zip(values).enumerate().filter_map(|(index, pair)| match pair {
            (ParamSpec { kind: ParamKind::InputPath, .. }, ParamValue::Text(name)) => {
                Some((index, name.as_str()))
            }
            _ => None,
        })
    }
}

/// First sentence of a doc text, on one line.
pub(crate) fn first_sentence(doc: &str) -> String {
    let paragraph = doc.split("\n\n").next().unwrap_or(doc).replace('\n', " ");
    match paragraph.find(". ") {
        Some(end) => paragraph[..=end].to_owned(),
        None => paragraph,
    }
}

/// An input or output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PortSpec {
    /// Its name, in snake case.
    pub name: Text,
    /// What it carries.
    pub doc: Text,
    /// The type of its wires.
    pub value_type: ValueType,
    /// How many wires it takes.
    #[serde(default)]
    pub arity: Arity,
}

/// How many wires an input takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arity {
    /// Exactly one.
    #[default]
    One,
    /// One or none.
    Optional,
    /// Any number, in order.
    Many,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParamSpec {
    /// Its name, in snake case.
    pub name: Text,
    /// What it does; the first sentence is its tooltip.
    pub doc: Text,
    /// Unit of its numbers.
    #[serde(default)]
    pub unit: Unit,
    /// Its type and limits.
    pub kind: ParamKind,
    /// Its value when a graph says nothing.
    pub default: ParamValue,
}

impl ParamSpec {
    /// First sentence of the docs, on one line.
    #[must_use]
    pub fn summary(&self) -> String {
        first_sentence(&self.doc)
    }
}

/// The type and limits of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ParamKind {
    /// A number.
    Number {
        /// Hard limits, enforced before a node runs.
        range: (f64, f64),
        /// What an inspector's slider offers.
        slider: (f64, f64),
    },
    /// An integer.
    Integer {
        /// Hard limits.
        range: (i64, i64),
        /// What an inspector's slider offers.
        slider: (i64, i64),
    },
    /// True or false.
    Boolean,
    /// Free text.
    Text,
    /// One of several.
    Choice {
        /// The options, in the order in which they are offered.
        options: Vec<ChoiceOption>,
    },
    /// A file to read, relative to the graph; its content counts in the key.
    InputPath,
    /// A file to write, relative to the output folder and never outside it.
    OutputPath,
    /// A colour, as [`Colour`](crate::Colour) is written.
    Colour,
    /// Colours from 0 to 1, as [`Gradient`](crate::Gradient) is written.
    Gradient,
    /// A curve through (x, y), x ascending.
    Curve {
        /// Hard limits of x.
        x: (f64, f64),
        /// Hard limits of y.
        y: (f64, f64),
    },
    /// Polylines of (x, y, height).
    Lines {
        /// Hard limits of every coordinate.
        range: (f64, f64),
    },
}

/// One option of a choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChoiceOption {
    /// As written in a graph, in snake case.
    pub name: Text,
    /// What it means.
    pub doc: Text,
}

/// How far a node's outputs look into its inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Extent {
    /// Each output cell depends on input cells within a halo alone, so it may run tile by tile.
    Local,
    /// It works on a pyramid: coarse levels everywhere, fine levels near by.
    MultiResolution,
    /// Any cell may depend on any other.
    Global,
}

/// A part of the run's context that a node may read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContextItem {
    /// The run's seed.
    Seed,
    /// The run's resolution.
    Resolution,
}
