//! `orograph nodes`: the node types, from their specs.

use orograph_core::NodeSpec;
use orograph_engine::{Registry, manual, registry::nearest};
use serde_json::json;

use crate::{arguments::NodesOptions, console, failure::Failure, session};

pub(crate) fn run(options: &NodesOptions) -> Result<(), Failure> {
    let registry = session::registry(&options.plugins, None)?;
    let Some(id) = &options.id else {
        list(&registry.iter().map(|node_type| node_type.spec()).collect::<Vec<_>>(), options.json);
        return Ok(());
    };
    let Some(node_type) = registry.get(id) else {
        let found = about(&registry, id);
        if !found.is_empty() {
            list(&found, options.json);
            return Ok(());
        }
        let hint = match near(&registry, id) {
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

fn list(specs: &[&NodeSpec], json: bool) {
    if json {
        console::result(&json!(specs).to_string());
        return;
    }
    let rows: Vec<_> = specs.iter().map(|spec| vec![spec.id.to_string(), spec.summary()]).collect();
    console::result(&console::columns(&rows));
}

/// The types whose id holds the word, such as a family; where there are none, those whose first sentence does.
fn about<'r>(registry: &'r Registry, word: &str) -> Vec<&'r NodeSpec> {
    let word = word.to_lowercase();
    let all = || registry.iter().map(|node_type| node_type.spec());
    let named: Vec<_> = all().filter(|spec| spec.id.contains(&word)).collect();
    if !named.is_empty() {
        return named;
    }
    all().filter(|spec| spec.summary().to_lowercase().contains(&word)).collect()
}

/// The id most like what was asked for, also where the family was left out.
fn near<'r>(registry: &'r Registry, word: &str) -> Option<&'r str> {
    let last = |id: &'r str| id.rsplit('.').next().unwrap_or(id);
    let ids = || registry.iter().map(|node_type| node_type.spec().id.as_ref());
    registry.nearest(word).or_else(|| {
        let algorithm = nearest(word, ids().map(last))?;
        ids().find(|id| last(id) == algorithm)
    })
}
