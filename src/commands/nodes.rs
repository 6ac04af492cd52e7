//! `orograph nodes`: the node types, from their specs.

use orograph_engine::manual;
use serde_json::json;

use crate::{arguments::NodesOptions, console, failure::Failure, session};

pub(crate) fn run(options: &NodesOptions) -> Result<(), Failure> {
    let registry = session::registry(&options.plugins, None)?;
    let Some(id) = &options.id else {
        let specs: Vec<_> = registry.iter().map(|node_type| node_type.spec()).collect();
        if options.json {
            console::result(&json!(specs).to_string());
        } else {
            let rows: Vec<_> = specs.iter().map(|spec| vec![spec.id.to_string(), spec.summary()]).collect();
            console::result(&console::columns(&rows));
        }
        return Ok(());
    };
    let Some(node_type) = registry.get(id) else {
        let hint = match registry.nearest(id) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`orograph nodes` lists them all".into(),
        };
        return Err(Failure::usage(format!("there is no node type `{id}`"), hint));
    };
    if options.json {
        console::result(&json!(node_type.spec()).to_string());
    } else {
        console::result(manual::terminal_page(node_type.spec()).trim_end());
    }
    Ok(())
}
