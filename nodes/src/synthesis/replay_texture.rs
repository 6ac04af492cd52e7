//! Texture replay: pictures of the exemplar, carried to where a synthesis put its ground.

use orograph_core::Placement;
use orograph_core::prelude::*;

use super::replay::{Origins, nearest};

/// Carries a picture that lies over the exemplar, such as an aerial photograph, to where synthesis put its ground.
///
/// Each pixel is the nearest one of the source. Cells that came from no exemplar are transparent.
#[derive(Params, Clone, Debug)]
pub struct ReplayTexture {}

/// Inputs of [`ReplayTexture`].
#[derive(Inputs)]
pub struct ReplayTextureIn<'a> {
    /// Which patch went where.
    pub placement: &'a Placement,
    /// The picture over each exemplar, in the order in which synthesis had them.
    pub textures: Vec<&'a Texture>,
}

/// Outputs of [`ReplayTexture`].
#[derive(Outputs)]
pub struct ReplayTextureOut {
    /// The picture over the synthesised terrain.
    pub texture: Texture,
}

impl Node for ReplayTexture {
    const ID: &'static str = "synthesis.replay_texture";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ReplayTextureIn<'a>;
    type Outputs = ReplayTextureOut;

    fn run(&self, inputs: ReplayTextureIn<'_>, job: &Job) -> Result<ReplayTextureOut> {
        let origins = Origins::new(inputs.placement, inputs.textures.len())?;
        let texture = Texture::build(inputs.placement.grid.clone(), job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                if let Some((exemplar, at, _)) = origins.at(row, col) {
                    *out = nearest(inputs.textures[exemplar], at).unwrap_or_default();
                }
            }
            Ok(())
        })?;
        Ok(ReplayTextureOut { texture })
    }
}
