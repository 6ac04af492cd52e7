//! What travels along a wire.

use std::{fmt, sync::Arc};

use serde::{Deserialize, Serialize};

use crate::{Features, Heightfield, Mask, Mesh, Placement, Points, Table, Texture};

/// The type of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub enum ValueType {
    /// Heights in metres on a grid.
    Heightfield,
    /// Shares in 0..=1 on a grid.
    Mask,
    /// Colours on a grid.
    Texture,
    /// Ridges or valleys.
    Features,
    /// Scattered constraints.
    Points,
    /// Provenance of a synthesis.
    Placement,
    /// Named metrics.
    Table,
    /// Triangles.
    Mesh,
    /// A number.
    Number,
    /// An integer.
    Integer,
    /// True or false.
    Boolean,
    /// Text; also how a choice travels.
    Text,
}

impl fmt::Display for ValueType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// A value on a wire: immutable and cheap to share.
#[derive(Clone, Debug)]
pub enum Value {
    /// See [`ValueType::Heightfield`].
    Heightfield(Arc<Heightfield>),
    /// See [`ValueType::Mask`].
    Mask(Arc<Mask>),
    /// See [`ValueType::Texture`].
    Texture(Arc<Texture>),
    /// See [`ValueType::Features`].
    Features(Arc<Features>),
    /// See [`ValueType::Points`].
    Points(Arc<Points>),
    /// See [`ValueType::Placement`].
    Placement(Arc<Placement>),
    /// See [`ValueType::Table`].
    Table(Arc<Table>),
    /// See [`ValueType::Mesh`].
    Mesh(Arc<Mesh>),
    /// See [`ValueType::Number`].
    Number(f64),
    /// See [`ValueType::Integer`].
    Integer(i64),
    /// See [`ValueType::Boolean`].
    Boolean(bool),
    /// See [`ValueType::Text`].
    Text(Arc<str>),
}

impl Value {
    /// The type of the wire that carries this.
    #[must_use]
    pub fn value_type(&self) -> ValueType {
        match self {
            Self::Heightfield(_) => ValueType::Heightfield,
            Self::Mask(_) => ValueType::Mask,
            Self::Texture(_) => ValueType::Texture,
            Self::Features(_) => ValueType::Features,
            Self::Points(_) => ValueType::Points,
            Self::Placement(_) => ValueType::Placement,
            Self::Table(_) => ValueType::Table,
            Self::Mesh(_) => ValueType::Mesh,
            Self::Number(_) => ValueType::Number,
            Self::Integer(_) => ValueType::Integer,
            Self::Boolean(_) => ValueType::Boolean,
            Self::Text(_) => ValueType::Text,
        }
    }
}
