//! `orograph plugin`: plugins listed, checked and begun.

mod check;
mod list;
mod new;

use crate::{arguments::PluginAction, failure::Failure};

pub(crate) fn run(action: &PluginAction) -> Result<(), Failure> {
    match action {
        PluginAction::List { plugins, rescan, json } => list::run(plugins, *rescan, *json),
        PluginAction::Check { library } => check::run(library),
        PluginAction::New { name, lang, sdk } => new::run(name, *lang, sdk.as_deref()),
    }
}
