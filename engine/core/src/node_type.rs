//! A node erased to its spec and a few functions: what a registry holds and a plugin supplies.

use std::sync::Arc;

use crate::{
    BandSink, BandSource, CellSize, Digest, Error, Grid, Inputs, Job, Node, NodeSpec, Outputs, ParamValue,
    RawParams, Result, Slot, Value,
};

type Make = Box<dyn Fn(&[ParamValue]) -> Result<Arc<dyn Instance>> + Send + Sync>;
type Upgrade = Box<dyn Fn(&mut RawParams, u32) -> Result<()> + Send + Sync>;

/// A node type, whoever supplied it.
pub struct NodeType {
    spec: NodeSpec,
    make: Make,
    upgrade: Upgrade,
    code: Option<Digest>,
}

/// A node with its settings, ready to run any number of times.
pub trait Instance: Send + Sync {
    /// Computes the outputs, in the spec's order.
    ///
    /// # Errors
    /// What the node's `run` returns.
    fn run(&self, slots: &[Slot], job: &Job) -> Result<Vec<Value>>;
    /// The halo of a local node, in cells.
    fn halo(&self, cell: CellSize) -> usize;
    /// Rough work per cell.
    fn cost(&self) -> f64;
    /// Its output, band by band: see [`Node::source`].
    ///
    /// # Errors
    /// As there.
    fn source(&self, _job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        Ok(None)
    }
    /// Whether its input may come band by band: see [`Node::takes_bands`].
    fn takes_bands(&self) -> bool {
        false
    }
    /// Begins its file: see [`Node::sink`].
    ///
    /// # Errors
    /// As there.
    fn sink(&self, _grid: &Grid, _job: &Job) -> Result<Box<dyn BandSink>> {
        Err(Error::invalid("the node takes no bands", "report it to the node's author"))
    }
    /// Names of files beside the input file `file` that the node reads, too, where they are there.
    fn companions(&self, _file: &str) -> Vec<String> {
        Vec::new()
    }
}

impl NodeType {
    /// The erased form of a built-in node.
    #[must_use]
    pub fn of<N: Node>() -> Self {
        Self::new(
            spec_of::<N>(),
            |values| {
                let node = N::from_values(values)?;
                node.check()?;
                Ok(Arc::new(Erased(node)))
            },
            N::upgrade,
        )
    }

    /// A node type from its parts, for nodes that are not Rust types.
    #[must_use]
    pub fn new(
        spec: NodeSpec,
        make: impl Fn(&[ParamValue]) -> Result<Arc<dyn Instance>> + Send + Sync + 'static,
        upgrade: impl Fn(&mut RawParams, u32) -> Result<()> + Send + Sync + 'static,
    ) -> Self {
        Self { spec, make: Box::new(make), upgrade: Box::new(upgrade), code: None }
    }

    /// The same type, its code being of this content: other code then has other keys, whatever its version says.
    #[must_use]
    pub fn with_code(self, code: Digest) -> Self {
        Self { code: Some(code), ..self }
    }

    /// The content of the code that supplies it; none for what the version alone tells.
    #[must_use]
    pub fn code(&self) -> Option<&Digest> {
        self.code.as_ref()
    }

    /// What the node is.
    #[must_use]
    pub fn spec(&self) -> &NodeSpec {
        &self.spec
    }

    /// A node with these settings, given in the spec's order. Every hard range is enforced here, so that no
    /// node runs outside its own.
    ///
    /// # Errors
    /// As [`ParamSpec::check`](crate::ParamSpec::check) and [`Node::check`].
    pub fn instantiate(&self, values: &[ParamValue]) -> Result<Arc<dyn Instance>> {
        for (spec, value) in self.spec.params.iter().zip(values) {
            spec.check(value)?;
        }
        (self.make)(values)
    }

    /// Lifts parameters of an older version.
    ///
    /// # Errors
    /// As [`Node::upgrade`].
    pub fn upgrade(&self, params: &mut RawParams, from: u32) -> Result<()> {
        (self.upgrade)(params, from)
    }
}

fn spec_of<N: Node>() -> NodeSpec {
    NodeSpec {
        id: N::ID.into(),
        version: N::VERSION,
        doc: N::DOC.into(),
        inputs: <N::Inputs<'static> as Inputs<'static>>::specs(),
        outputs: N::Outputs::specs(),
        params: N::specs(),
        extent: N::EXTENT,
        reads: N::READS.to_vec(),
        writes: N::WRITES,
        default_writer: N::DEFAULT_WRITER,
    }
}

struct Erased<N>(N);

impl<N: Node> Instance for Erased<N> {
    fn run(&self, slots: &[Slot], job: &Job) -> Result<Vec<Value>> {
        let inputs = <N::Inputs<'_> as Inputs<'_>>::read(slots)?;
        Ok(self.0.run(inputs, job)?.into_values())
    }
    fn halo(&self, cell: CellSize) -> usize {
        self.0.halo(cell)
    }
    fn cost(&self) -> f64 {
        self.0.cost()
    }
    fn source(&self, job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        self.0.source(job)
    }
    fn takes_bands(&self) -> bool {
        self.0.takes_bands()
    }
    fn sink(&self, grid: &Grid, job: &Job) -> Result<Box<dyn BandSink>> {
        self.0.sink(grid, job)
    }
    fn companions(&self, file: &str) -> Vec<String> {
        self.0.companions(file)
    }
}
