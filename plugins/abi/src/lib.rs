//! The C ABI between Orograph and its plugins, version 1.0.
//!
//! A plugin is a dynamic library that exports one constant, [`OrographPlugin`], under the name
//! `orograph_plugin`. The host reads its node specs once as RON text ([`PluginSpec`]) and runs its nodes by
//! handing them an [`OrographJob`]: parameters and inputs as borrowed views, and functions of the host.
//! No Rust type, allocator or panic crosses.
//!
//! What is here is frozen: structs grow at their end alone and say their size, everything else grows by named
//! extensions. `layout.rs` asserts every field's place. The types stand in [`types`] and [`calls`]; `lend` and
//! `take` turn values into views and back, and serve both sides.

// Views are raw pointers; this crate and its two users are where they are read.
#![allow(unsafe_code)]

pub mod calls;
mod lend;
mod spec;
mod take;
pub mod types;

#[cfg(test)]
mod layout;
#[cfg(test)]
mod tests;

pub use calls::*;
pub use lend::Lender;
pub use spec::PluginSpec;
pub use take::{Cells, Malformed, check_cells, read_param, read_text, read_value};
pub use types::*;
