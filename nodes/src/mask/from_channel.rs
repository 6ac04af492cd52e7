//! A channel of a texture as a mask.
use orograph_core::prelude::*;

use super::splat_map::Channel;

/// Takes a channel of a texture as a mask, such as one material's weights out of a splat map.
///
/// A level of 0 is a share of 0, one of 255 a share of 1. Written with 8 bits, the mask has the channel's own levels.
#[derive(Params, Clone, Debug)]
pub struct FromChannel {
    /// The channel.
    #[param(default = Channel::Red)]
    pub channel: Channel,
}

/// Inputs of [`FromChannel`].
#[derive(Inputs)]
pub struct FromChannelIn<'a> {
    /// Texture to take the channel of.
    pub texture: &'a Texture,
}

/// Outputs of [`FromChannel`].
#[derive(Outputs)]
pub struct FromChannelOut {
    /// The channel's levels as shares.
    pub mask: Mask,
}

impl Node for FromChannel {
    const ID: &'static str = "mask.from_channel";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = FromChannelIn<'a>;
    type Outputs = FromChannelOut;

    fn run(&self, inputs: FromChannelIn<'_>, job: &Job) -> Result<FromChannelOut> {
        let channel = self.channel as usize;
        let mask = inputs.texture.map(job, |colour| f32::from(colour[channel]) / 255.0)?;
        Ok(FromChannelOut { mask })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::row;

    #[test]
    fn every_level_survives() {
        let grid = row(&[0.0; 256]).grid().clone();
        let cells = (0..=255).map(|level| [7, level, 9, 255 - level]).collect();
        let texture = Texture::new(grid, cells).unwrap();
        for (channel, flipped) in [(Channel::Green, false), (Channel::Alpha, true)] {
            let node = FromChannel { channel };
            let mask = node.run(FromChannelIn { texture: &texture }, &Job::detached()).unwrap().mask;
            for (level, &share) in mask.cells().iter().enumerate() {
                // As io.write_mask rounds.
                let back = (f64::from(share) * 255.0 + 0.5) as usize;
                assert_eq!(back, if flipped { 255 - level } else { level });
            }
        }
    }
}
