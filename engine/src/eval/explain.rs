//! Why a node ran: what differs from the last run of the same graph.

use std::collections::BTreeMap;

use orograph_core::{Context, Digest, Hasher, ParamValue};
use serde::{Deserialize, Serialize};

use super::key::{NodeKey, companions, visible_context};
use crate::{
    cache::Cache,
    graph::{Action, Graph, GraphNode},
};

/// What a node was in one run: everything that its key is made of, in words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Print {
    id: String,
    version: u32,
    params: Vec<(String, String)>,
    files: Vec<(String, Digest)>,
    inputs: Vec<(String, Option<Digest>)>,
    seed: u64,
    resolution: Option<u32>,
}

impl Print {
    pub(crate) fn of(node: &GraphNode, context: Context, keys: &[Option<NodeKey>], cache: &Cache) -> Self {
        let Action::Run { node_type, values, .. } = &node.action else { return Self::default() };
        let spec = node_type.spec();
        let context = visible_context(node, context);
        let mut print = Self {
            id: spec.id.to_string(),
            version: spec.version,
            seed: context.seed,
            resolution: context.resolution,
            ..Self::default()
        };
        for (_, text) in node.input_files() {
            if let Ok(path) = node.input_path(text)
                && let Ok(digest) = cache.file_digest(&path)
            {
                print.files.push((text.to_owned(), digest));
                print.files.extend(companions(node, &path, cache).unwrap_or_default());
            }
        }
        let params = spec.params.iter().zip(values);
        print.params = params.map(|(param, value)| (param.name.to_string(), brief(value))).collect();
        for (port, wires) in spec.inputs.iter().zip(&node.inputs) {
            let mut hasher = Hasher::new("orograph wires");
            let mut known = true;
            for wire in wires {
                match keys[wire.node.index()].as_ref().and_then(|key| key.recipe) {
                    Some(recipe) => {
                        hasher.digest(&recipe).number(u64::from(wire.output));
                    }
                    None => known = false,
                }
            }
            print.inputs.push((port.name.to_string(), known.then(|| hasher.finish())));
        }
        print
    }
}

/// Which files came, went or changed.
fn changed_files(before: &[(String, Digest)], now: &[(String, Digest)]) -> String {
    let find = |files: &[(String, Digest)], name: &str| {
        files.iter().find(|(other, _)| other == name).map(|(_, digest)| *digest)
    };
    let names = |of: &[(String, Digest)], changed: &dyn Fn(&str, Digest) -> bool| {
        let names = of.iter().filter(|(name, digest)| changed(name, *digest));
        names.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
    };
    let other = names(now, &|name, digest| find(before, name).is_some_and(|old| old != digest));
    let new = names(now, &|name, _| find(before, name).is_none());
    let gone = names(before, &|name, _| find(now, name).is_none());
    let told =
        [("the content of ", other, " changed"), ("", new, " came beside its file"), ("", gone, " is gone")];
    let told = told.iter().filter(|(_, names, _)| !names.is_empty());
    told.map(|(head, names, tail)| format!("{head}{names}{tail}")).collect::<Vec<_>>().join("; ")
}

/// A value in few words; what is long is told by its digest.
fn brief(value: &ParamValue) -> String {
    const LONG: usize = 60;
    let text = match value {
        ParamValue::Number(x) => x.to_string(),
        ParamValue::Integer(i) => i.to_string(),
        ParamValue::Boolean(b) => b.to_string(),
        ParamValue::Text(text) => text.clone(),
        ParamValue::Curve(points) => format!("{points:?}"),
        ParamValue::Lines(lines) => format!("{lines:?}"),
    };
    if text.len() <= LONG {
        return text;
    }
    format!("{:?}", Digest::of(text.as_bytes()))
}

/// The last run of a graph.
pub(crate) struct History(Option<BTreeMap<String, Print>>);

impl History {
    pub(crate) fn load(name: Option<&str>, cache: &Cache) -> Self {
        Self(name.and_then(|name| cache.journal(&Digest::of(name.as_bytes()))))
    }

    /// Keeps this run's prints; nodes that it did not touch keep their earlier ones.
    pub(crate) fn save(&self, name: Option<&str>, prints: Vec<(String, Print)>, cache: &Cache) {
        if let Some(name) = name {
            let mut all = self.0.clone().unwrap_or_default();
            all.extend(prints);
            cache.put_journal(&Digest::of(name.as_bytes()), &all);
        }
    }

    /// Why `node`, now `print`, had to run.
    pub(crate) fn reason(&self, node: &GraphNode, now: &Print, graph: &Graph) -> String {
        let Some(runs) = &self.0 else { return "the first run of this graph with this cache".into() };
        let Some(before) = runs.get(&node.name) else { return "a new node".into() };
        if before.id != now.id {
            return format!("its type changed from {} to {}", before.id, now.id);
        }
        if before.version != now.version {
            return format!("the node type went from version {} to {}", before.version, now.version);
        }
        let changed = |(old, new): (&(String, String), &(String, String))| {
            (old != new).then(|| format!("`{}` changed from {} to {}", new.0, old.1, new.1))
        };
        if let Some(reason) = before.params.iter().zip(&now.params).find_map(changed) {
            return reason;
        }
        if before.files != now.files {
            return changed_files(&before.files, &now.files);
        }
        if before.seed != now.seed {
            return format!("the run's seed changed from {} to {}", before.seed, now.seed);
        }
        if before.resolution != now.resolution {
            let text = |resolution: Option<u32>| resolution.map_or_else(|| "none".into(), |n| n.to_string());
            return format!(
                "the run's resolution changed from {} to {}",
                text(before.resolution),
                text(now.resolution)
            );
        }
        for (port, ((name, old), (_, new))) in before.inputs.iter().zip(&now.inputs).enumerate() {
            if old != new {
                let wires = node.inputs.get(port).map(Vec::as_slice).unwrap_or_default();
                let sources: Vec<_> = wires.iter().map(|wire| graph.output_name(*wire)).collect();
                return format!("its input `{name}` changed ({})", sources.join(", "));
            }
        }
        "nothing changed, but its cached result is gone".into()
    }
}
