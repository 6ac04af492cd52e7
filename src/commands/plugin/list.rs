//! `orograph plugin list`: every library in the plugin folders, and what became of it.

use orograph_engine::plugin::Found;
use orograph_session::{PluginOptions, Settings, plugins};
use serde_json::json;

use crate::{arguments, console, failure::Failure, session};

pub(crate) fn run(options: &arguments::PluginOptions, again: bool, as_json: bool) -> Result<(), Failure> {
    let options = PluginOptions { again, ..session::plugin_options(options, None) };
    let (_, found) = orograph_session::registry(&options, &Settings::load()?)?;
    if as_json {
        let list: Vec<_> = found.iter().map(as_value).collect();
        console::result(&json!(list).to_string());
        return Ok(());
    }
    if found.is_empty() {
        let own = plugins::own_folder()
            .map_or_else(String::new, |folder| format!(", or put plugins into {}", folder.display()));
        console::note(&format!("no plugins; name their folder with --plugins or OROGRAPH_PLUGINS{own}"));
        return Ok(());
    }
    for Found { path, outcome } in &found {
        match outcome {
            Ok(plugin) => {
                let apart = if plugin.apart { ", in processes of its own" } else { "" };
                console::result(&format!("{} {}{apart}: {}", plugin.name, plugin.version, path.display()));
                for node in &plugin.nodes {
                    console::result(&format!("  {node}"));
                }
            }
            Err(reason) => console::result(&format!("refused: {}: {reason}", path.display())),
        }
    }
    Ok(())
}

fn as_value(found: &Found) -> serde_json::Value {
    let path = found.path.display().to_string();
    match &found.outcome {
        Ok(plugin) => json!({
            "path": path,
            "name": plugin.name,
            "version": plugin.version,
            "digest": plugin.digest.to_string(),
            "nodes": plugin.nodes,
            "isolated": plugin.apart,
        }),
        Err(reason) => json!({ "path": path, "refused": reason }),
    }
}
