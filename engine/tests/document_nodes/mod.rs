//! A small registry: a reader, a writer, a filter whose second version renamed and rescaled a setting, a
//! converter, and a sheet that takes any number of wires.

use orograph_core::NodeType;
use orograph_core::prelude::*;
use orograph_engine::Registry;

/// Which way.
#[derive(Choice, Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// Up.
    Up,
    /// Straight down.
    StraightDown,
}

/// Reads terrain.
#[derive(Params, Clone, Debug)]
pub(crate) struct Read {
    /// The file.
    #[param(default = "x.tif")]
    pub(crate) file: InputPath,
}

/// Terrain.
#[derive(Outputs)]
pub(crate) struct TerrainOut {
    /// The terrain.
    pub(crate) terrain: Heightfield,
}

impl Node for Read {
    const ID: &'static str = "io.read";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = TerrainOut;
    fn run(&self, (): (), _: &Job) -> Result<TerrainOut> {
        Err(Error::invalid("never run", ""))
    }
}

/// Smooths terrain.
#[derive(Params, Clone, Debug)]
pub(crate) struct Smooth {
    /// How far.
    #[param(default = 10.0, range = 0.5..=1000.0, slider = 1.0..=100.0, unit = "m")]
    pub(crate) radius: f64,
    /// How often.
    #[param(default = 1u32, range = 1..=9, unit = "1")]
    pub(crate) rounds: u32,
    /// Which way.
    #[param(default = Way::Up)]
    pub(crate) way: Way,
    /// Whether rims count.
    #[param(default = false)]
    pub(crate) rims: bool,
    /// A note.
    #[param(default = "")]
    pub(crate) note: String,
    /// How much, by distance.
    #[param(default = [[0.0, 1.0], [1.0, 0.0]])]
    pub(crate) falloff: Curve,
    /// Where not.
    #[param(default = Vec::new())]
    pub(crate) barriers: Lines,
}

/// Terrain and where it counts.
#[derive(Inputs)]
pub(crate) struct SmoothIn<'a> {
    /// The terrain.
    pub(crate) terrain: &'a Heightfield,
    /// Where.
    pub(crate) mask: Option<&'a Mask>,
}

impl Node for Smooth {
    const ID: &'static str = "filter.smooth";
    const VERSION: u32 = 3;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = SmoothIn<'a>;
    type Outputs = TerrainOut;
    fn run(&self, inputs: SmoothIn<'_>, _: &Job) -> Result<TerrainOut> {
        match inputs.mask {
            None => Ok(TerrainOut { terrain: inputs.terrain.clone() }),
            Some(_) => Err(Error::invalid("never run with a mask", "")),
        }
    }
    fn check(&self) -> Result<()> {
        if self.rounds > 5 && self.radius > 500.0 {
            return Err(Error::invalid("so many rounds of so wide a filter", "use fewer rounds"));
        }
        Ok(())
    }
    /// Version 1 had `size_km`; version 2 could invert.
    fn upgrade(params: &mut RawParams, from: u32) -> Result<()> {
        if from < 2 {
            params.scale("size_km", 1000.0);
            params.rename("size_km", "radius");
        }
        if from < 3 && params.remove("invert") == Some(orograph_core::ParamValue::Boolean(true)) {
            return Err(Error::invalid("smoothing no longer inverts", "subtract it from its input instead"));
        }
        Ok(())
    }
}

/// Shades terrain.
#[derive(Params, Clone, Debug)]
pub(crate) struct Shade {}

/// Terrain alone.
#[derive(Inputs)]
pub(crate) struct ShadeIn<'a> {
    /// The terrain.
    pub(crate) terrain: &'a Heightfield,
}

/// A picture.
#[derive(Outputs)]
pub(crate) struct ShadeOut {
    /// The picture.
    pub(crate) texture: Texture,
}

impl Node for Shade {
    const ID: &'static str = "look.shade";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ShadeIn<'a>;
    type Outputs = ShadeOut;
    fn run(&self, inputs: ShadeIn<'_>, job: &Job) -> Result<ShadeOut> {
        Ok(ShadeOut { texture: inputs.terrain.map(job, |_| [0; 4])? })
    }
}

/// Puts pictures side by side into a file.
#[derive(Params, Clone, Debug)]
pub(crate) struct Sheet {
    /// The file.
    #[param(default = "sheet.png")]
    pub(crate) file: OutputPath,
}

/// Pictures.
#[derive(Inputs)]
pub(crate) struct SheetIn<'a> {
    /// The pictures.
    pub(crate) pictures: Vec<&'a Texture>,
}

impl Node for Sheet {
    const ID: &'static str = "io.sheet";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = SheetIn<'a>;
    type Outputs = ();
    fn run(&self, inputs: SheetIn<'_>, _: &Job) -> Result<()> {
        if inputs.pictures.is_empty() { Err(Error::EmptyInput { what: "pictures".into() }) } else { Ok(()) }
    }
}

/// All of them.
pub(crate) fn registry() -> Registry {
    Registry::new([
        NodeType::of::<Read>(),
        NodeType::of::<Smooth>(),
        NodeType::of::<Shade>(),
        NodeType::of::<Sheet>(),
    ])
    .expect("ids differ")
}
