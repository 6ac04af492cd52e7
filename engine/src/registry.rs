//! The node types that a program knows, by id.

use std::{collections::BTreeMap, sync::Arc};

use orograph_core::{Arity, NodeSpec, NodeType, ValueType};

/// Node types by id. Front ends fill it; the engine never names a node.
#[derive(Clone, Default)]
pub struct Registry {
    nodes: BTreeMap<String, Arc<NodeType>>,
}

/// Two node types claim one id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("two node types are named `{id}`")]
pub struct IdClash {
    /// The id.
    pub id: String,
}

impl Registry {
    /// A registry of the given types.
    ///
    /// # Errors
    /// [`IdClash`] when two share an id.
    pub fn new(types: impl IntoIterator<Item = NodeType>) -> Result<Self, IdClash> {
        let mut registry = Self::default();
        for node_type in types {
            registry.register(node_type)?;
        }
        Ok(registry)
    }

    /// Adds a type.
    ///
    /// # Errors
    /// [`IdClash`] when its id is taken; the registry stays as it was.
    pub fn register(&mut self, node_type: NodeType) -> Result<(), IdClash> {
        let id = node_type.spec().id.to_string();
        if self.nodes.contains_key(&id) {
            return Err(IdClash { id });
        }
        self.nodes.insert(id, Arc::new(node_type));
        Ok(())
    }

    /// The type of that id.
    #[must_use]
    pub fn get(&self, id: &str) -> Option<&Arc<NodeType>> {
        self.nodes.get(id)
    }

    /// All types, by id.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<NodeType>> {
        self.nodes.values()
    }

    /// The types that turn one type of value into another with that input alone, those with fewest settings first.
    #[must_use]
    pub fn converters(&self, from: ValueType, to: ValueType) -> Vec<&NodeSpec> {
        let converts = |spec: &&NodeSpec| {
            let mut needed = spec.inputs.iter().filter(|input| input.arity == Arity::One);
            needed.next().is_some_and(|input| input.value_type == from)
                && needed.next().is_none()
                && spec.outputs.iter().any(|output| output.value_type == to)
        };
        let mut specs: Vec<_> = self.iter().map(|node_type| node_type.spec()).filter(converts).collect();
        specs.sort_by_key(|spec| (spec.inputs.len() + spec.params.len(), spec.id.clone()));
        specs
    }

    /// The id most like `id`, when one is near enough to be a slip of the pen.
    #[must_use]
    pub fn nearest(&self, id: &str) -> Option<&str> {
        nearest(id, self.nodes.keys().map(String::as_str))
    }
}

/// The candidate most like `name`, when one is near enough to be a slip of the pen.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// In bytes. Comparing takes time and memory as the product of both lengths, and no slip of the pen is that long.
    const LONGEST: usize = 200;
    if name.len() > LONGEST {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().max(name.len()) / 4)
        // Of a name of one letter every other would be a slip.
        .filter(|(distance, candidate)| *distance < candidate.len().min(name.len()))
        .min()
        .map(|(_, candidate)| candidate)
}
