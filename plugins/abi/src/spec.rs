//! What a plugin says of itself.

use orograph_core::NodeSpec;
use serde::{Deserialize, Serialize};

/// What [`describe`](crate::OrographPlugin::describe) gives, as RON. Fields that this version does not know are
/// passed over, so that a plugin made for a later minor version can still be read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PluginSpec {
    /// The plugin's name, for people.
    pub name: String,
    /// Its version, for people.
    pub version: String,
    /// Its nodes; a job names one by its index in this list.
    pub nodes: Vec<NodeSpec>,
}
