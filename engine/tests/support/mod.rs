//! A few node types for the engine's own tests.
// Each test binary uses its part; a benchmark is not a test to clippy.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used)]

mod rasters;

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};

use orograph_core::prelude::*;
use orograph_core::{NodeType, ParamValue};
use orograph_engine::{
    Cache, DiskTier, Evaluator, Graph, GraphBuilder, NodeId, Observer, Registry, eval::Event,
};

/// Counts the nodes that run.
#[derive(Default)]
pub struct Starts(AtomicUsize);

impl Starts {
    pub fn count(&self) -> usize {
        self.0.load(Ordering::SeqCst)
    }
}

impl Observer for Starts {
    fn event(&self, event: &Event<'_>) {
        if matches!(event, Event::Started { .. }) {
            self.0.fetch_add(1, Ordering::SeqCst);
        }
    }
}

/// Gives a number.
#[derive(Params)]
pub struct Number {
    /// The number.
    #[param(default = 0, range = -1e9..=1e9, unit = "1")]
    pub value: f64,
}

/// A number.
#[derive(Outputs)]
pub struct NumberOut {
    /// The number.
    pub number: f64,
}

impl Node for Number {
    const ID: &'static str = "test.number";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = NumberOut;
    fn run(&self, (): (), _: &Job) -> Result<NumberOut> {
        Ok(NumberOut { number: self.value })
    }
}

/// Adds numbers.
#[derive(Params)]
pub struct Add {
    /// Added to the sum.
    #[param(default = 0, range = -1e9..=1e9, unit = "1")]
    pub more: f64,
}

/// Numbers to add.
#[derive(Inputs)]
pub struct AddIn<'a> {
    /// The numbers.
    pub numbers: Vec<&'a f64>,
}

impl Node for Add {
    const ID: &'static str = "test.add";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = AddIn<'a>;
    type Outputs = NumberOut;
    fn run(&self, inputs: AddIn<'_>, _: &Job) -> Result<NumberOut> {
        Ok(NumberOut { number: inputs.numbers.iter().copied().sum::<f64>() + self.more })
    }
}

/// Rounds a number down.
#[derive(Params)]
pub struct Floor {}

/// A number to round.
#[derive(Inputs)]
pub struct FloorIn<'a> {
    /// The number.
    pub number: &'a f64,
}

impl Node for Floor {
    const ID: &'static str = "test.floor";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FloorIn<'a>;
    type Outputs = NumberOut;
    fn run(&self, inputs: FloorIn<'_>, _: &Job) -> Result<NumberOut> {
        Ok(NumberOut { number: inputs.number.floor() })
    }
}

/// Fails, panics, or waits until it is cancelled.
#[derive(Params)]
pub struct Trouble {
    /// Which trouble: `error`, `panic`, or `wait`.
    #[param(default = "error")]
    pub kind: String,
}

impl Node for Trouble {
    const ID: &'static str = "test.trouble";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = NumberOut;
    fn run(&self, (): (), job: &Job) -> Result<NumberOut> {
        match self.kind.as_str() {
            "panic" => panic!("as it was told to"),
            "wait" => loop {
                job.check()?;
                std::thread::sleep(Duration::from_millis(1));
            },
            _ => Err(Error::invalid("as it was told to", "tell it otherwise")),
        }
    }
}

/// Takes its time, and counts itself.
#[derive(Params)]
pub struct Slow {
    /// Which of the [`SLOW`] counts.
    #[param(default = 0, range = 0..=7, unit = "1")]
    pub count: u32,
    /// How long it takes, in thousandths of a second.
    #[param(default = 0, range = 0..=600000, unit = "1")]
    pub millis: u32,
    /// Its number.
    #[param(default = 0, range = -1e9..=1e9, unit = "1")]
    pub number: f64,
}

/// How many slow nodes began, and how many run.
pub static SLOW: [(AtomicUsize, AtomicUsize); 8] = [const { (AtomicUsize::new(0), AtomicUsize::new(0)) }; 8];

impl Node for Slow {
    const ID: &'static str = "test.slow";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = NumberOut;
    fn run(&self, (): (), job: &Job) -> Result<NumberOut> {
        let (started, running) = &SLOW[self.count as usize];
        started.fetch_add(1, Ordering::SeqCst);
        running.fetch_add(1, Ordering::SeqCst);
        let work = || {
            let begun = Instant::now();
            while begun.elapsed() < Duration::from_millis(self.millis.into()) {
                job.check()?;
                job.progress(begun.elapsed().as_secs_f64() * 1e3 / f64::from(self.millis));
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(NumberOut { number: self.number })
        };
        let result = work();
        running.fetch_sub(1, Ordering::SeqCst);
        result
    }
}

/// A field of one height; large on demand.
#[derive(Params)]
pub struct Field {
    /// Cells along each side.
    #[param(default = 16, range = 1..=4096, unit = "cells")]
    pub cells: u32,
    /// The height.
    #[param(default = 0, range = -1e5..=1e5, unit = "m")]
    pub height: f64,
}

/// A field.
#[derive(Outputs)]
pub struct FieldOut {
    /// The field.
    pub terrain: Heightfield,
}

impl Node for Field {
    const ID: &'static str = "test.field";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = ();
    type Outputs = FieldOut;
    fn run(&self, (): (), job: &Job) -> Result<FieldOut> {
        let grid = Grid::new(self.cells as usize, self.cells as usize, CellSize::square(1.0))?;
        let height = (self.height + job.seed() as f64) as f32;
        Ok(FieldOut { terrain: Heightfield::filled(grid, height, job)? })
    }
}

/// Raises a field.
#[derive(Params)]
pub struct Raise {
    /// By how much.
    #[param(default = 1, range = -1e5..=1e5, unit = "m")]
    pub by: f64,
}

/// A field to raise.
#[derive(Inputs)]
pub struct RaiseIn<'a> {
    /// The field.
    pub terrain: &'a Heightfield,
}

impl Node for Raise {
    const ID: &'static str = "test.raise";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = RaiseIn<'a>;
    type Outputs = FieldOut;
    fn run(&self, inputs: RaiseIn<'_>, job: &Job) -> Result<FieldOut> {
        let by = self.by as f32;
        Ok(FieldOut { terrain: inputs.terrain.map(job, |height| height + by)? })
    }
}

/// Writes a field's cells.
#[derive(Params)]
pub struct Write {
    /// The file.
    #[param(default = "field.bin")]
    pub file: OutputPath,
    /// Fail half-way.
    #[param(default = false)]
    pub fail: bool,
}

impl Node for Write {
    const ID: &'static str = "test.write";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = RaiseIn<'a>;
    type Outputs = ();
    fn run(&self, inputs: RaiseIn<'_>, job: &Job) -> Result<()> {
        let mut file = job.create(&self.file)?;
        for height in inputs.terrain.cells() {
            file.write_all(&height.to_le_bytes()).map_err(|error| Error::writing(&self.file.0, error))?;
        }
        if self.fail {
            return Err(Error::invalid("as it was told to", "tell it otherwise"));
        }
        file.finish()
    }
}

/// The length of a file, as a number.
#[derive(Params)]
pub struct Length {
    /// The file.
    #[param(default = "")]
    pub file: InputPath,
}

impl Node for Length {
    const ID: &'static str = "test.length";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = NumberOut;
    fn run(&self, (): (), job: &Job) -> Result<NumberOut> {
        let path = job.input_path(&self.file)?;
        let length = std::fs::metadata(&path).map_err(|error| Error::reading(path.display(), error))?.len();
        Ok(NumberOut { number: length as f64 })
    }
}

/// All of them.
pub fn registry() -> Registry {
    Registry::new([
        NodeType::of::<Number>(),
        NodeType::of::<Add>(),
        NodeType::of::<Floor>(),
        NodeType::of::<Trouble>(),
        NodeType::of::<Slow>(),
        NodeType::of::<Field>(),
        NodeType::of::<Raise>(),
        NodeType::of::<Write>(),
        NodeType::of::<Length>(),
        NodeType::of::<rasters::Hills>(),
        NodeType::of::<rasters::Spread>(),
        NodeType::of::<rasters::Join>(),
        NodeType::of::<rasters::Top>(),
        NodeType::of::<rasters::WriteRows>(),
    ])
    .unwrap()
}

/// Builds graphs by name.
pub struct Bench {
    registry: Registry,
    builder: GraphBuilder,
}

impl Bench {
    pub fn new() -> Self {
        Self { registry: registry(), builder: GraphBuilder::new() }
    }

    pub fn add(
        &mut self,
        name: &str,
        id: &str,
        params: &[(&str, ParamValue)],
        inputs: &[(&str, NodeId, &str)],
    ) -> NodeId {
        let node_type = self.registry.get(id).unwrap();
        let spec = node_type.spec();
        let values = spec
            .params
            .iter()
            .map(|param| {
                params
                    .iter()
                    .find(|(name, _)| *name == param.name)
                    .map_or(param.default.clone(), |p| p.1.clone())
            })
            .collect();
        let node = self.builder.add(name, node_type, values).unwrap();
        for (port, from, output) in inputs {
            self.builder.connect(*from, output, node, port).unwrap();
        }
        node
    }

    pub fn number(&mut self, name: &str, value: f64) -> NodeId {
        self.add(name, "test.number", &[("value", ParamValue::Number(value))], &[])
    }

    pub fn build(self) -> Arc<Graph> {
        Arc::new(self.builder.build().unwrap())
    }
}

/// An evaluator over a memory of 1 GiB.
pub fn in_memory(jobs: usize) -> Evaluator {
    Evaluator::new(Cache::new(1 << 30, None), jobs).unwrap()
}

/// An evaluator over a folder.
pub fn on_disk(folder: &std::path::Path, memory: u64) -> Evaluator {
    Evaluator::new(Cache::new(memory, Some(DiskTier::open(folder).unwrap())), 2).unwrap()
}
