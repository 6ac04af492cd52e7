//! What a plugin for Orograph is written with.
//!
//! A node is declared as Orograph's own are: a settings struct with `#[derive(Params)]`, a struct of inputs, one of
//! outputs, and `impl Node`. One line makes a plugin of them:
//!
//! ```ignore
//! orograph_plugin::export!("Erosion tools", [Hydraulic, Thermal]);
//! ```
//!
//! The crate is built as a dynamic library (`crate-type = ["cdylib"]`) and depends on nothing else of Orograph. It
//! loads in every 1.x, whatever compiler either was built with: only the C ABI of `orograph_plugin.h` crosses.
//!
//! What a node gets here that a node in C has to see to by itself:
//! - inputs are read where they are, without a copy, and given back when `run` ends;
//! - a panic becomes the node's error, with its place;
//! - [`rayon`]'s pool has as many threads as the host lends.
//!
//! A plugin's node writes no files.

// The entries of the C ABI take pointers; they stand in `entry`, `host` and `settings`, and nowhere else.
#![allow(unsafe_code)]

// Lets the derives' absolute paths (`::orograph_plugin::…`) resolve inside this crate's own tests too.
extern crate self as orograph_plugin;

mod entry;
mod fence;
mod host;
mod pool;
mod settings;

pub use orograph_core::*;
pub use orograph_derive::{
    PluginChoice as Choice, PluginInputs as Inputs, PluginOutputs as Outputs, PluginParams as Params,
};
pub use {glam, libm, rayon};

/// The structs of the C ABI.
pub use orograph_abi as abi;

#[doc(hidden)]
pub use entry::{Export, Plugin, describe, plugin};

/// Everything that a node's file needs: `use orograph_plugin::prelude::*;`.
pub mod prelude {
    pub use crate::{Choice, Inputs, Outputs, Params};
    pub use orograph_core::prelude::*;
}

/// Makes a plugin of nodes: its name for people, and their types. Its version is that of the crate.
///
/// Write it once, in `lib.rs`.
#[macro_export]
macro_rules! export {
    ($name:expr, [$($node:ty),+ $(,)?]) => {
        #[cfg(panic = "abort")]
        compile_error!("a plugin needs `panic = \"unwind\"`: a panic in a node is to be its error, not the end");

        const _: () = {
            struct Exported;

            impl $crate::Export for Exported {
                fn plugin() -> &'static $crate::Plugin {
                    static PLUGIN: ::std::sync::OnceLock<$crate::Plugin> = ::std::sync::OnceLock::new();
                    $(const { assert!(!<$node as $crate::Node>::WRITES, "a plugin's node writes no files") };)+
                    PLUGIN.get_or_init(|| {
                        $crate::describe($name, env!("CARGO_PKG_VERSION"), vec![$($crate::NodeType::of::<$node>()),+])
                    })
                }
            }

            #[allow(non_upper_case_globals, unsafe_code)]
            #[unsafe(no_mangle)]
            pub static orograph_plugin: $crate::abi::OrographPlugin = $crate::plugin::<Exported>();
        };
    };
}
