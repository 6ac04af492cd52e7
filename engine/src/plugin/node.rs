//! A plugin's nodes as node types like any other.

use std::{
    path::PathBuf,
    sync::{Arc, OnceLock},
};

use orograph_abi::PluginSpec;
use orograph_core::{
    CellSize, Digest, Instance, Job, NodeSpec, NodeType, ParamValue, RawParams, Result, Slot, Value,
};

use super::{host::defect, library::Library, scan::Description, store::Store};

/// A plugin whose nodes are registered.
pub(super) struct Plugin {
    description: Description,
    calls: Box<dyn Calls>,
    /// Where the copy of its library lies.
    _store: Arc<Store>,
}

/// The calls into a plugin, wherever its code runs. A node goes by its index.
pub(super) trait Calls: Send + Sync {
    /// Runs a node.
    fn run(
        &self,
        node: (u32, &NodeSpec),
        params: &[ParamValue],
        slots: &[Slot],
        job: &Job,
    ) -> Result<Vec<Value>>;
    /// Whether settings go together.
    fn check(&self, node: u32, params: &[ParamValue]) -> Result<()>;
    /// The halo of a local node, in cells.
    fn halo(&self, node: u32, params: &[ParamValue], cell: CellSize) -> Result<usize>;
    /// Rough work per cell.
    fn cost(&self, node: u32, params: &[ParamValue]) -> Result<f64>;
    /// Lifts parameters of an older version.
    fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()>;
}

impl Plugin {
    pub(super) fn new(description: Description, calls: Box<dyn Calls>, store: Arc<Store>) -> Arc<Self> {
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

    fn check(&self, node: u32, values: &[ParamValue]) -> Result<()> {
        if self.description.checks { self.calls.check(node, values) } else { Ok(()) }
    }

    fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()> {
        if self.description.upgrades { self.calls.upgrade(node, from, params) } else { Ok(()) }
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
        let Some(spec) = self.plugin.description.spec.nodes.get(self.node as usize) else {
            return Err(defect("the plugin has no such node"));
        };
        self.plugin.calls.run((self.node, spec), &self.values, slots, job)
    }

    fn halo(&self, cell: CellSize) -> usize {
        if !self.plugin.description.tells_halo {
            return 0;
        }
        // Nothing is local to a node that cannot tell how far it looks.
        self.plugin.calls.halo(self.node, &self.values, cell).unwrap_or(usize::MAX)
    }

    fn cost(&self) -> f64 {
        if !self.plugin.description.tells_cost {
            return 1.0;
        }
        self.plugin.calls.cost(self.node, &self.values).unwrap_or(1.0)
    }
}

/// Calls into a library in this process, which is loaded when it is first needed.
pub(super) struct Here {
    copy: PathBuf,
    scanned: PluginSpec,
    library: OnceLock<Result<Library, String>>,
}

impl Here {
    pub(super) fn new(copy: PathBuf, scanned: PluginSpec) -> Self {
        Self { copy, scanned, library: OnceLock::new() }
    }

    fn library(&self) -> Result<&Library> {
        let loaded = self.library.get_or_init(|| {
            let library = Library::load(&self.copy)?;
            if library.spec != self.scanned {
                return Err("it describes itself otherwise than when it was scanned".into());
            }
            Ok(library)
        });
        loaded.as_ref().map_err(|reason| defect(format!("the plugin: {reason}")))
    }
}

impl Calls for Here {
    fn run(
        &self,
        (node, _): (u32, &NodeSpec),
        params: &[ParamValue],
        slots: &[Slot],
        job: &Job,
    ) -> Result<Vec<Value>> {
        self.library()?.run(node, params, slots, job)
    }
    fn check(&self, node: u32, params: &[ParamValue]) -> Result<()> {
        self.library()?.check(node, params)
    }
    fn halo(&self, node: u32, params: &[ParamValue], cell: CellSize) -> Result<usize> {
        Ok(self.library()?.halo(node, params, cell))
    }
    fn cost(&self, node: u32, params: &[ParamValue]) -> Result<f64> {
        Ok(self.library()?.cost(node, params))
    }
    fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()> {
        self.library()?.upgrade(node, from, params)
    }
}
