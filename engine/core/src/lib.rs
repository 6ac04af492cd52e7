//! What Orograph's nodes speak: the data that travels along wires, the specs that describe nodes, the
//! [`Node`] trait, content digests and errors.
//!
//! This crate reads no file, knows no graph and no clock, and holds no `unsafe`. A node depends on it and
//! on nothing else of Orograph.

#[cfg(target_endian = "big")]
compile_error!("digests and stored values are defined on little-endian memory");

// Lets the derives' absolute paths (`::orograph_core::…`) resolve inside this crate's own tests too.
extern crate self as orograph_core;

mod bands;
mod buffer;
mod codec;
mod colour;
mod digest;
mod error;
mod features;
mod grid;
mod job;
mod mesh;
mod node;
mod node_type;
mod param;
mod placement;
mod points;
mod pointwise;
mod port;
mod random;
mod raster;
mod spec;
mod spec_check;
mod table;
mod unit;
mod value;

pub use bands::{Band, BandSink, BandSource, Collected, rows_of};
pub use codec::{CodecError, Encoded};
pub use colour::{Colour, Gradient};
pub use digest::{Digest, Hasher};
pub use error::{Error, Result};
pub use features::{FeatureKind, FeaturePoint, Features, PointKind, Polyline};
pub use grid::{CellSize, Georef, Grid, MAX_CELLS};
pub use job::{Context, DetachedHost, Host, Job, OutputStream, Stage};
pub use mesh::Mesh;
pub use node::{Choice, Inputs, Node, Outputs, ParamField, Params};
pub use node_type::{Instance, NodeType};
pub use orograph_derive::{Choice, Inputs, Outputs, Params};
pub use param::{Curve, InputPath, Lines, OutputPath, ParamValue, RawParams};
pub use placement::{Patch, Placement};
pub use points::Points;
pub use port::{InputField, Slot, Wire};
pub use random::{gaussian, key, mix64, signed_unit, unit};
pub use raster::{Heightfield, Kind, Mask, Metres, Raster, Rgba, Share, Texture};
pub use spec::{Arity, ChoiceOption, ContextItem, Extent, NodeSpec, ParamKind, ParamSpec, PortSpec};
pub use table::{Cells, Column, Table};
pub use unit::Unit;
pub use value::{Value, ValueType};

/// Everything that a node's file needs: `use orograph_core::prelude::*;`.
pub mod prelude {
    pub use crate::{
        BandSink, BandSource, CellSize, Cells, Choice, Colour, Column, ContextItem, Curve, Error, Extent,
        FeatureKind, Features, Georef, Gradient, Grid, Heightfield, InputPath, Inputs, Job, Lines, Mask,
        Node, OutputPath, Outputs, Params, Points, Raster, RawParams, Result, Table, Texture, Value,
    };
}
