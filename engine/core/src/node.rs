//! The node contract.

use crate::{
    BandSink, BandSource, CellSize, ChoiceOption, ContextItem, Error, Extent, Grid, Job, ParamKind,
    ParamSpec, ParamValue, PortSpec, RawParams, Result, Slot, Value,
};

/// An algorithm: its settings are the value itself, its contract the trait's constants and types.
///
/// Implementers promise that equal settings, inputs, files and declared context give equal outputs to the
/// bit, on any number of threads; that they call [`Job::check`] at least every few milliseconds of work; and
/// that no input makes them panic.
pub trait Node: Params + Send + Sync + 'static {
    /// Permanent name, `family.algorithm`; the file is `nodes/src/family/algorithm.rs`.
    const ID: &'static str;
    /// Raise it whenever equal inputs may give other outputs.
    const VERSION: u32;
    /// How far outputs look; a [`Extent::Local`] node also tells its [`halo`](Self::halo).
    const EXTENT: Extent;
    /// What the node reads of the run's context. Anything not named here reads as its default.
    const READS: &'static [ContextItem] = &[];
    /// Set for a node that writes files: it has no outputs, runs for its effect, and is never cached.
    const WRITES: bool = false;
    /// The writer chosen when a bare output of its first input's type is asked for.
    const DEFAULT_WRITER: bool = false;
    /// Input ports.
    type Inputs<'a>: Inputs<'a>;
    /// Output ports.
    type Outputs: Outputs;

    /// Computes the outputs.
    ///
    /// # Errors
    /// Any [`Error`]; it reaches every output that needs this node and is never cached.
    fn run(&self, inputs: Self::Inputs<'_>, job: &Job) -> Result<Self::Outputs>;

    /// For a local node: how many cells beyond its own position an output cell looks, on a grid of such cells.
    fn halo(&self, _cell: CellSize) -> usize {
        0
    }

    /// Opens the node's only output, a raster, to be made band by band while no input is wired; `None` where it can only
    /// be made as a whole.
    ///
    /// # Errors
    /// What [`run`](Self::run) would return.
    fn source(&self, _job: &Job) -> Result<Option<Box<dyn BandSource>>> {
        Ok(None)
    }

    /// For a node that writes files: whether its only input, a raster, may come band by band, to a [`sink`](Self::sink).
    fn takes_bands(&self) -> bool {
        false
    }

    /// Begins the file of a node that [`takes_bands`](Self::takes_bands), for a raster on `grid`.
    ///
    /// # Errors
    /// What [`run`](Self::run) would return before it looks at cells.
    fn sink(&self, _grid: &Grid, _job: &Job) -> Result<Box<dyn BandSink>> {
        Err(Error::invalid("the node takes no bands", "report it to the node's author"))
    }

    /// Rough work per cell relative to copying it; weighs the progress display, nothing else.
    fn cost(&self) -> f64 {
        1.0
    }

    /// Names of files beside the input file named `file` that the node reads, too, where they are there.
    ///
    /// A pure function of the settings and that name: the engine looks which of the files exist, counts their content as it
    /// counts the file's own, and lets [`Job::companion`] find them.
    fn companions(&self, _file: &str) -> Vec<String> {
        Vec::new()
    }

    /// Checks settings against each other, after each was checked against its range.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming what does not go together.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Lifts the parameters of version `from` to this version. Parameters that kept name and meaning stay.
    ///
    /// # Errors
    /// [`Error::Invalid`] when an old setting has no equivalent.
    fn upgrade(_params: &mut RawParams, _from: u32) -> Result<()> {
        Ok(())
    }
}

/// Settings of a node; `#[derive(Params)]` writes this.
pub trait Params: Sized + Default {
    /// The doc comment of the settings struct: the node's docs.
    const DOC: &'static str;
    /// How many parameters there are.
    const COUNT: usize;
    /// The parameters, in declaration order.
    fn specs() -> Vec<ParamSpec>;
    /// Settings from values in that order.
    ///
    /// # Errors
    /// [`Error::ParamType`] or [`Error::ParamCount`].
    fn from_values(values: &[ParamValue]) -> Result<Self>;
    /// The values in that order.
    fn to_values(&self) -> Vec<ParamValue>;
}

/// A type that a settings field may have.
pub trait ParamField: Sized {
    /// The parameter's kind under the attribute's `range` and `slider`.
    fn kind(range: Option<(f64, f64)>, slider: Option<(f64, f64)>) -> ParamKind;
    /// The field as a value.
    fn to_value(&self) -> ParamValue;
    /// The field from a value of its kind.
    fn from_value(value: &ParamValue) -> Option<Self>;
}

/// An enum of options; `#[derive(Choice)]` writes this.
pub trait Choice: Sized {
    /// The options in order.
    fn options() -> Vec<ChoiceOption>;
    /// The option's name in graphs.
    fn name(&self) -> &'static str;
    /// The option of that name.
    fn parse(name: &str) -> Option<Self>;
}

/// Input ports; `#[derive(Inputs)]` writes this, `()` has none.
pub trait Inputs<'a>: Sized {
    /// The ports, in declaration order.
    fn specs() -> Vec<PortSpec>;
    /// The inputs from what is connected, in that order.
    ///
    /// # Errors
    /// [`Error::InputType`] or [`Error::PortCount`].
    fn read(slots: &'a [Slot]) -> Result<Self>;
}

impl Inputs<'_> for () {
    fn specs() -> Vec<PortSpec> {
        Vec::new()
    }
    fn read(slots: &[Slot]) -> Result<Self> {
        if slots.is_empty() { Ok(()) } else { Err(Error::PortCount { expected: 0, found: slots.len() }) }
    }
}

/// Output ports; `#[derive(Outputs)]` writes this, `()` has none.
pub trait Outputs: Sized {
    /// The ports, in declaration order.
    fn specs() -> Vec<PortSpec>;
    /// The values in that order.
    fn into_values(self) -> Vec<Value>;
}

impl Outputs for () {
    fn specs() -> Vec<PortSpec> {
        Vec::new()
    }
    fn into_values(self) -> Vec<Value> {
        Vec::new()
    }
}
