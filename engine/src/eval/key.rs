//! Keys: the name of a computation before its value exists.

use std::path::Path;

use orograph_core::{Context, ContextItem, Digest, Error, Hasher};

use crate::{
    cache::{Cache, files::is_there},
    graph::{Action, Graph, GraphNode, NodeId},
};

/// The keys of one node in one run.
#[derive(Clone, Debug)]
pub(crate) struct NodeKey {
    /// Of type, version, settings, files and context: everything but the inputs.
    pub(crate) settings: Digest,
    /// Of the settings and the recipes of the inputs; none when a file above cannot be read.
    pub(crate) recipe: Option<Digest>,
    /// Why the node itself cannot run.
    pub(crate) error: Option<Error>,
}

/// What of the context the node declared that it reads.
pub(crate) fn visible_context(node: &GraphNode, context: Context) -> Context {
    let reads = node.spec().map_or(&[][..], |spec| &spec.reads);
    Context {
        seed: if reads.contains(&ContextItem::Seed) { context.seed } else { 0 },
        resolution: context.resolution.filter(|_| reads.contains(&ContextItem::Resolution)),
    }
}

/// The keys of `wanted` nodes, which are in topological order, by node; none for the others.
pub(crate) fn keys_of(
    graph: &Graph,
    wanted: &[NodeId],
    context: Context,
    cache: &Cache,
) -> Vec<Option<NodeKey>> {
    let mut keys: Vec<Option<NodeKey>> = vec![None; graph.nodes().len()];
    for &id in wanted {
        let node = graph.node(id);
        let (settings, error) = settings_key(node, visible_context(node, context), cache);
        let mut hasher = Hasher::new("orograph recipe 1");
        hasher.digest(&settings);
        let mut complete = error.is_none();
        for wires in &node.inputs {
            hasher.number(wires.len() as u64);
            for wire in wires {
                hasher.number(u64::from(wire.output));
                match keys[wire.node.index()].as_ref().and_then(|key| key.recipe.as_ref()) {
                    Some(recipe) => {
                        hasher.digest(recipe);
                    }
                    None => complete = false,
                }
            }
        }
        let recipe = complete.then(|| hasher.finish());
        keys[id.index()] = Some(NodeKey { settings, recipe, error });
    }
    keys
}

/// The key of a node whose inputs have these digests, port by port.
pub(crate) fn action_key(settings: &Digest, inputs: &[Vec<Digest>]) -> Digest {
    let mut hasher = Hasher::new("orograph action 1");
    hasher.digest(settings);
    for wires in inputs {
        hasher.number(wires.len() as u64);
        for digest in wires {
            hasher.digest(digest);
        }
    }
    hasher.finish()
}

/// The node's own part of its keys: what the graph fixed, and the content of files and the context of this run.
fn settings_key(node: &GraphNode, context: Context, cache: &Cache) -> (Digest, Option<Error>) {
    let (spec, fixed) = match &node.action {
        Action::Run { node_type, fixed, .. } => (node_type.spec(), *fixed),
        Action::Missing(missing) => {
            let message = format!("no node type `{}` is known here", missing.id);
            return (Digest([0; 32]), Some(Error::invalid(message, missing.reason.clone())));
        }
    };
    let mut hasher = None;
    let mut error = None;
    for (param, text) in node.input_files() {
        // A file counts by its content and its name, which some formats read meaning from; not by its folder.
        match file_key(node, &param.name, text, cache) {
            Ok(files) => {
                let hasher = hasher.get_or_insert_with(|| run_hasher(&fixed));
                if files.len() > 1 {
                    hasher.text("with companions").number(files.len() as u64);
                }
                files.iter().for_each(|(name, digest)| {
                    hasher.text(name).digest(digest);
                });
            }
            Err(reason) => error = error.or(Some(reason)),
        }
    }
    if !spec.reads.is_empty() {
        let resolution = context.resolution.map_or(0, |cells| u64::from(cells) + 1);
        hasher.get_or_insert_with(|| run_hasher(&fixed)).number(context.seed).number(resolution);
    }
    (hasher.map_or(fixed, |hasher| hasher.finish()), error)
}

fn run_hasher(fixed: &Digest) -> Hasher {
    let mut hasher = Hasher::new("orograph run settings 1");
    hasher.digest(fixed);
    hasher
}

/// The error of a file that is not there, with what would mend that: where it is looked for depends on how it is named.
fn not_there(error: Error, text: &str, path: &Path) -> Error {
    if !matches!(error, Error::Io { .. }) || path.exists() {
        return error;
    }
    let variable = text.split_once("${").and_then(|(_, rest)| rest.split(['}', ':']).next());
    let hint = match variable {
        Some(name) => format!("set {name} to the folder that holds it, or give the node another file"),
        None if Path::new(text).is_absolute() => return error,
        None => "check the path: one that is not absolute counts from the graph's folder".to_owned(),
    };
    Error::invalid(error.to_string(), hint)
}

/// Name and digest of the file, and of those of its companions that are there.
fn file_key(
    node: &GraphNode,
    param: &str,
    text: &str,
    cache: &Cache,
) -> Result<Vec<(String, Digest)>, Error> {
    if text.is_empty() {
        return Err(Error::invalid(
            format!("`{param}` names no file"),
            format!("set it in the graph, or with --set {}.{param}=PATH", node.name),
        ));
    }
    let path = node.input_path(text)?;
    let digest = cache.file_digest(&path).map_err(|error| not_there(error, text, &path))?;
    let name = path.file_name().map_or_else(String::new, |name| Path::new(name).display().to_string());
    let mut files = vec![(name, digest)];
    files.extend(companions(node, &path, cache)?);
    Ok(files)
}

/// Names and digests of the files beside the input file `path` that the node reads, too.
pub(crate) fn companions(
    node: &GraphNode,
    path: &Path,
    cache: &Cache,
) -> Result<Vec<(String, Digest)>, Error> {
    let mut found = Vec::new();
    for (name, path) in node.companions(path)? {
        if is_there(&path)? {
            found.push((name, cache.file_digest(&path)?));
        }
    }
    Ok(found)
}
