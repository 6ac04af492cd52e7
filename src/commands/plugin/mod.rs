//! `orograph plugin`: plugins listed, checked and begun.

mod list;

use crate::{arguments::PluginAction, failure::Failure};

pub(crate) fn run(action: &PluginAction) -> Result<(), Failure> {
    match action {
        PluginAction::List { plugins, rescan, json } => list::run(plugins, *rescan, *json),
        PluginAction::Check { .. } | PluginAction::New { .. } => Ok(()),
    }
}
