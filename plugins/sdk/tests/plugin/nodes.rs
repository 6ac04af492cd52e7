//! Nodes as an author writes them, each odd in its own way.

use std::sync::{Arc, Mutex};

use orograph_plugin::{
    Features, InputField, Mesh, Placement, Slot, Value,
    prelude::*,
    rayon::prelude::{IntoParallelIterator, ParallelIterator},
};

/// Where to fail.
#[derive(Choice, Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Nowhere.
    Nowhere,
    /// On the thread that the host called on.
    Here,
    /// On a thread of the pool.
    InThePool,
}

/// A setting of each kind.
#[derive(Params, Clone, Debug)]
pub struct Everything {
    /// A number.
    #[param(default = 0.5, range = 0.0..=1.0, unit = "m")]
    pub number: f64,
    /// An integer.
    #[param(default = 3, range = 0..=9, unit = "1")]
    pub integer: i64,
    /// A switch.
    #[param(default = true)]
    pub boolean: bool,
    /// A text.
    #[param(default = "a")]
    pub text: String,
    /// A curve.
    #[param(default = [[0.0, 0.0], [1.0, 1.0]])]
    pub curve: Curve,
}

/// Every type of value.
#[derive(Inputs)]
pub struct EverythingIn<'a> {
    /// Heights.
    pub terrain: &'a Heightfield,
    /// Shares.
    pub mask: Option<&'a Mask>,
    /// Pictures.
    pub textures: Vec<&'a Texture>,
    /// Lines.
    pub features: Option<&'a Features>,
    /// Points.
    pub points: Option<&'a Points>,
    /// Provenance.
    pub placement: Option<&'a Placement>,
    /// Metrics.
    pub table: Option<&'a Table>,
    /// Triangles.
    pub mesh: Option<&'a Mesh>,
    /// A number.
    pub number: Option<&'a f64>,
    /// An integer.
    pub integer: Option<&'a i64>,
    /// A switch.
    pub boolean: Option<&'a bool>,
    /// A text.
    pub text: Option<&'a Arc<str>>,
}

/// Every type of value, as it came or of its own.
#[derive(Outputs)]
pub struct EverythingOut {
    /// Heights.
    pub terrain: Heightfield,
    /// Shares.
    pub mask: Mask,
    /// Pictures.
    pub texture: Texture,
    /// Lines.
    pub features: Features,
    /// Points.
    pub points: Points,
    /// Provenance.
    pub placement: Placement,
    /// Metrics.
    pub table: Table,
    /// Triangles.
    pub mesh: Mesh,
    /// A number.
    pub number: f64,
    /// An integer.
    pub integer: i64,
    /// A switch.
    pub boolean: bool,
    /// A text.
    pub text: Arc<str>,
}

impl Node for Everything {
    const ID: &'static str = "test.everything";
    const VERSION: u32 = 2;
    const EXTENT: Extent = Extent::Local;
    const READS: &'static [ContextItem] = &[ContextItem::Seed, ContextItem::Resolution];
    type Inputs<'a> = EverythingIn<'a>;
    type Outputs = EverythingOut;

    fn check(&self) -> Result<()> {
        if self.text == "refuse" {
            Err(Error::invalid("it says `refuse`", "say something else"))
        } else {
            Ok(())
        }
    }

    fn halo(&self, cell: CellSize) -> usize {
        (self.number / cell.x * 100.0) as usize
    }

    fn cost(&self) -> f64 {
        self.number * 10.0
    }

    fn upgrade(params: &mut RawParams, from: u32) -> Result<()> {
        if from == 0 {
            return Err(Error::invalid("version 0 never was", "start from 1"));
        }
        params.rename("share", "number");
        Ok(())
    }

    fn run(&self, inputs: EverythingIn<'_>, job: &Job) -> Result<EverythingOut> {
        let grid = inputs.terrain.grid().clone();
        job.progress(0.5);
        job.warn(format!("seed {} resolution {:?}", job.seed(), job.resolution()));
        let missing = |what: &str| Error::EmptyInput { what: what.into() };
        Ok(EverythingOut {
            terrain: inputs.terrain.clone(),
            mask: match inputs.mask {
                Some(mask) => mask.clone(),
                None => Mask::filled(grid.clone(), self.number as f32, job)?,
            },
            texture: match inputs.textures.last() {
                Some(texture) => (*texture).clone(),
                None => Texture::filled(grid, [1, 2, 3, 4], job)?,
            },
            features: inputs.features.cloned().ok_or_else(|| missing("features"))?,
            points: inputs.points.cloned().ok_or_else(|| missing("points"))?,
            placement: inputs.placement.cloned().ok_or_else(|| missing("placement"))?,
            table: inputs.table.cloned().ok_or_else(|| missing("table"))?,
            mesh: inputs.mesh.cloned().ok_or_else(|| missing("mesh"))?,
            number: inputs.number.copied().unwrap_or(self.curve.at(self.number)),
            integer: inputs.integer.copied().unwrap_or(self.integer),
            boolean: inputs.boolean.copied().unwrap_or(self.boolean),
            text: inputs.text.cloned().unwrap_or_else(|| self.text.as_str().into()),
        })
    }
}

/// Counts threads, reads a file's place, panics, fails and waits, as it is told.
#[derive(Params, Clone, Debug)]
pub struct Odd {
    /// Where to panic.
    #[param(default = Place::Nowhere)]
    pub panic: Place,
    /// Fail with an error.
    #[param(default = false)]
    pub fail: bool,
    /// Go on until cancelled.
    #[param(default = false)]
    pub wait: bool,
    /// Ask for more memory than there is.
    #[param(default = false)]
    pub large: bool,
    /// Ask for the place of this file.
    #[param(default = "")]
    pub file: InputPath,
}

/// Outputs of [`Odd`].
#[derive(Outputs)]
pub struct OddOut {
    /// Threads of the pool.
    pub threads: i64,
    /// Where the file is.
    pub file: Arc<str>,
}

impl Node for Odd {
    const ID: &'static str = "test.odd";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = OddOut;

    fn run(&self, (): (), job: &Job) -> Result<OddOut> {
        match self.panic {
            Place::Nowhere => {}
            Place::Here => panic!("here it ends"),
            Place::InThePool => (0..100).into_par_iter().for_each(|i| assert!(i != 57, "no {i}")),
        }
        if self.fail {
            return Err(Error::invalid("it must not be", "let it be"));
        }
        if self.large {
            Mask::filled(Grid::new(1000, 1000, CellSize::square(1.0))?, 0.0, job)?;
        }
        if self.wait {
            loop {
                job.check()?;
            }
        }
        let file = if self.file.0.is_empty() {
            String::new()
        } else {
            job.input_path(&self.file)?.display().to_string()
        };
        Ok(OddOut { threads: orograph_plugin::rayon::current_num_threads() as i64, file: file.into() })
    }
}

/// Keeps what it was only lent.
#[derive(Params, Clone, Debug)]
pub struct Keeps {}

/// Everything connected, owned: no derive writes such inputs.
pub struct All(Vec<Slot>);

impl orograph_plugin::Inputs<'_> for All {
    fn specs() -> Vec<orograph_plugin::PortSpec> {
        vec![<&Heightfield as InputField<'_>>::spec("terrain", "What is kept.")]
    }
    fn read(slots: &[Slot]) -> Result<Self> {
        Ok(Self(slots.to_vec()))
    }
}

static KEPT: Mutex<Vec<Slot>> = Mutex::new(Vec::new());

impl Node for Keeps {
    const ID: &'static str = "test.keeps";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = All;
    type Outputs = ();

    fn run(&self, All(slots): All, _: &Job) -> Result<()> {
        KEPT.lock().unwrap().extend(slots);
        Ok(())
    }
}

/// What a test gives to every port of [`Everything`].
pub fn one_of_each() -> Vec<Slot> {
    let grid = Grid::new(2, 3, CellSize { x: 5.0, y: 7.0 }).unwrap();
    let one = |value| Slot::One(value);
    let texture = |c: u8| Value::Texture(Arc::new(Texture::new(grid.clone(), vec![[c; 4]; 6]).unwrap()));
    vec![
        one(Value::Heightfield(Arc::new(
            Heightfield::new(grid.clone(), vec![1.0, f32::NAN, 3.0, 4.0, 5.0, 6.0]).unwrap(),
        ))),
        one(Value::Mask(Arc::new(Mask::new(grid.clone(), vec![0.25; 6]).unwrap()))),
        Slot::Many(vec![texture(1), texture(2)]),
        one(Value::Features(Arc::new(Features {
            grid: grid.clone(),
            kind: FeatureKind::Valley,
            points: Vec::new(),
            lines: Vec::new(),
            rings: Vec::new(),
            scale: 1.0,
            profile_len: 0,
            profile_step: 1.0,
        }))),
        one(Value::Points(Arc::new(Points::new(vec![1.0], vec![2.0], vec![3.0]).unwrap()))),
        one(Value::Placement(Arc::new(Placement {
            grid,
            scales: Vec::new(),
            patches: Vec::new(),
            labels: vec![0; 6],
            sources: vec![[0.0; 2]; 6],
            seams: Vec::new(),
        }))),
        one(Value::Table(Arc::new(Table::metrics([("rmse", orograph_plugin::Unit::Metre, 0.5)]).unwrap()))),
        one(Value::Mesh(Arc::new(Mesh::default()))),
        one(Value::Number(0.75)),
        one(Value::Integer(-4)),
        one(Value::Boolean(false)),
        one(Value::Text("Höhe".into())),
    ]
}
