//! A plugin's nodes as node types like any other.

use std::{
    path::PathBuf,
    sync::{Arc, OnceLock},
};

use orograph_core::{
    CellSize, Digest, Instance, Job, NodeSpec, NodeType, ParamValue, RawParams, Result, Slot, Value,
};

use super::{host::defect, isolate::Workers, library::Library, scan::Description, store::Store};

/// A plugin whose nodes are registered.
pub(super) struct Plugin {
    description: Description,
    calls: Calls,
    /// Where the copy of its library lies.
    _store: Arc<Store>,
}

/// Where its code runs.
pub(super) enum Calls {
    /// In this process, from the moment that the first node needs it.
    Here { copy: PathBuf, library: OnceLock<Result<Library, String>> },
    /// In processes of its own.
    Apart(Workers),
}

impl Plugin {
    pub(super) fn new(description: Description, calls: Calls, store: Arc<Store>) -> Arc<Self> {
        Arc::new(Self { description, calls, _store: store })
    }

    /// The plugin's node types.
    pub(super) fn node_types(self: &Arc<Self>, code: &Digest) -> Vec<NodeType> {
        let types = (0u32..).zip(&self.description.spec.nodes).map(|(node, spec)| {
            let (maker, lifter) = (Arc::clone(self), Arc::clone(self));
            let make = move |values: &[ParamValue]| {
                maker.check(node, values)?;
                let instance = PluginNode { plugin: Arc::clone(&maker), node, values: values.to_vec() };
                Ok(Arc::new(instance) as Arc<dyn Instance>)
            };
            let upgrade = move |params: &mut RawParams, from| lifter.upgrade(node, from, params);
            NodeType::new(spec.clone(), make, upgrade).with_code(*code)
        });
        types.collect()
    }

    /// The library, loaded when it is first needed.
    fn library(&self) -> Result<Option<&Library>> {
        let Calls::Here { copy, library } = &self.calls else { return Ok(None) };
        let loaded = library.get_or_init(|| {
            let library = Library::load(copy)?;
            if library.spec != self.description.spec {
                return Err("it describes itself otherwise than when it was scanned".into());
            }
            Ok(library)
        });
        loaded.as_ref().map(Some).map_err(|reason| defect(format!("the plugin: {reason}")))
    }

    fn spec(&self, node: u32) -> Option<&NodeSpec> {
        self.description.spec.nodes.get(node as usize)
    }

    fn check(&self, node: u32, values: &[ParamValue]) -> Result<()> {
        if !self.description.checks {
            return Ok(());
        }
        match (&self.calls, self.library()?) {
            (_, Some(library)) => library.check(node, values),
            (Calls::Apart(workers), None) => workers.check(node, values),
            (Calls::Here { .. }, None) => Ok(()),
        }
    }

    fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()> {
        if !self.description.upgrades {
            return Ok(());
        }
        match (&self.calls, self.library()?) {
            (_, Some(library)) => library.upgrade(node, from, params),
            (Calls::Apart(workers), None) => workers.upgrade(node, from, params),
            (Calls::Here { .. }, None) => Ok(()),
        }
    }
}

/// A plugin's node with its settings.
struct PluginNode {
    plugin: Arc<Plugin>,
    node: u32,
    values: Vec<ParamValue>,
}

impl Instance for PluginNode {
    fn run(&self, slots: &[Slot], job: &Job) -> Result<Vec<Value>> {
        let Some(spec) = self.plugin.spec(self.node) else {
            return Err(defect("the plugin has no such node"));
        };
        match (&self.plugin.calls, self.plugin.library()?) {
            (Calls::Apart(workers), _) => workers.run((self.node, spec), &self.values, slots, job),
            (_, Some(library)) => library.run(self.node, &self.values, slots, job),
            (Calls::Here { .. }, None) => Err(defect("the plugin is not loaded")),
        }
    }

    fn halo(&self, cell: CellSize) -> usize {
        if !self.plugin.description.tells_halo {
            return 0;
        }
        match (&self.plugin.calls, self.plugin.library()) {
            (Calls::Apart(workers), _) => workers.halo(self.node, &self.values, cell).unwrap_or(usize::MAX),
            (_, Ok(Some(library))) => library.halo(self.node, &self.values, cell),
            // Nothing is local to a node that cannot tell how far it looks.
            _ => usize::MAX,
        }
    }

    fn cost(&self) -> f64 {
        if !self.plugin.description.tells_cost {
            return 1.0;
        }
        match (&self.plugin.calls, self.plugin.library()) {
            (Calls::Apart(workers), _) => workers.cost(self.node, &self.values).unwrap_or(1.0),
            (_, Ok(Some(library))) => library.cost(self.node, &self.values),
            _ => 1.0,
        }
    }
}
