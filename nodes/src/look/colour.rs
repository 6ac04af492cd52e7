//! The colours of pixels, and the colour ramps of pictures.

use orograph_core::prelude::*;

/// An opaque or translucent colour: red, green, blue, alpha.
pub type Tint = [u8; 4];

/// Ink for text, ticks and axes.
pub const INK: Tint = [38, 42, 48, 255];
/// Paper behind plots.
pub const PAPER: Tint = [255, 255, 255, 255];

/// `over` laid on `under`, covering it by `share` (0 to 1) of its own alpha.
#[must_use]
pub fn blend(under: Tint, over: Tint, share: f64) -> Tint {
    let alpha = f64::from(over[3]) / 255.0 * share.clamp(0.0, 1.0);
    let below = f64::from(under[3]) / 255.0 * (1.0 - alpha);
    let total = alpha + below;
    if total <= 0.0 {
        return under;
    }
    let mix = |i: usize| byte((f64::from(over[i]) * alpha + f64::from(under[i]) * below) / total);
    [mix(0), mix(1), mix(2), byte(total * 255.0)]
}

/// A colour darkened to `share` (0 to 1) of its brightness.
#[must_use]
pub fn shade(colour: Tint, share: f64) -> Tint {
    let [r, g, b, a] = colour;
    let dark = |part: u8| byte(f64::from(part) * share);
    [dark(r), dark(g), dark(b), a]
}

/// The nearest byte; saturates.
#[must_use]
pub fn byte(value: f64) -> u8 {
    (value + 0.5) as u8
}

/// A colour ramp from low to high.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// Green lowlands, yellow and brown uplands, white summits, as in a school atlas.
    Atlas,
    /// Forest, meadow, rock and snow.
    Alpine,
    /// Red rock to pale sand.
    Desert,
    /// Black to white.
    Grey,
    /// Violet over green to yellow: even steps to the eye, also for the colour-blind.
    Viridis,
    /// White over orange to dark red, for quantities that start at zero.
    Heat,
    /// Blue below, white at the middle, red above.
    Diverging,
}

impl Palette {
    const fn stops(self) -> &'static [(f64, u32)] {
        match self {
            Self::Atlas => &[
                (0.0, 0x3d_7d5e),
                (0.14, 0x77_ab6f),
                (0.3, 0xc3_d08a),
                (0.47, 0xe9_d69c),
                (0.65, 0xc9_9e6c),
                (0.82, 0x98_7460),
                (0.93, 0xd6_cfca),
                (1.0, 0xff_ffff),
            ],
            Self::Alpine => &[
                (0.0, 0x46_6338),
                (0.25, 0x78_905b),
                (0.45, 0xa8_a57f),
                (0.62, 0x97_8d83),
                (0.78, 0xb7_b2ac),
                (0.9, 0xe8_eaed),
                (1.0, 0xff_ffff),
            ],
            Self::Desert => {
                &[(0.0, 0x6a_3d29), (0.25, 0xa1_5c39), (0.5, 0xce_8d56), (0.75, 0xe8_c389), (1.0, 0xf9_eed3)]
            }
            Self::Grey => &[(0.0, 0x00_0000), (1.0, 0xff_ffff)],
            Self::Viridis => &[
                (0.0, 0x44_0154),
                (0.125, 0x47_2d7b),
                (0.25, 0x3b_528b),
                (0.375, 0x2c_728e),
                (0.5, 0x21_918c),
                (0.625, 0x28_ae80),
                (0.75, 0x5e_c962),
                (0.875, 0xad_dc30),
                (1.0, 0xfd_e725),
            ],
            Self::Heat => {
                &[(0.0, 0xff_ffff), (0.2, 0xfd_ecb3), (0.45, 0xf5_aa5c), (0.7, 0xcf_4a31), (1.0, 0x4b_0d20)]
            }
            Self::Diverging => &[
                (0.0, 0x10_3a70),
                (0.22, 0x3f_86c0),
                (0.38, 0xa9_cfe6),
                (0.5, 0xf7_f7f7),
                (0.62, 0xf3_bda0),
                (0.78, 0xd2_5f4d),
                (1.0, 0x7d_1023),
            ],
        }
    }

    /// The colour at `share` of the ramp; held at its ends, and at the low end for NaN.
    #[must_use]
    pub fn at(self, share: f64) -> Tint {
        let stops = self.stops();
        let after = stops.partition_point(|stop| stop.0 <= share);
        let rgb = |hex: u32| [hex >> 16, hex >> 8, hex].map(|part| f64::from(part & 0xff));
        let (low, high, t) = match (after.checked_sub(1).map(|i| stops[i]), stops.get(after)) {
            (Some(low), Some(&high)) => (low, high, (share - low.0) / (high.0 - low.0)),
            (Some(end), None) => (end, end, 0.0),
            (None, _) => (stops[0], stops[0], 0.0),
        };
        let (low, high) = (rgb(low.1), rgb(high.1));
        let mix = |i: usize| byte(low[i] + (high[i] - low[i]) * t);
        [mix(0), mix(1), mix(2), 255]
    }
}

/// The colours of a palette, or a user's own where there are any.
#[derive(Clone, Copy, Debug)]
pub struct Ramp<'a> {
    palette: Palette,
    own: Option<&'a Gradient>,
}

impl<'a> Ramp<'a> {
    /// The ramp of two settings: `own` when it has a stop.
    #[must_use]
    pub fn new(palette: Palette, own: &'a Gradient) -> Self {
        Self { palette, own: Some(own).filter(|own| !own.stops().is_empty()) }
    }

    /// The colour at `share`, as [`Palette::at`].
    #[must_use]
    pub fn at(self, share: f64) -> Tint {
        self.own.and_then(|own| own.at(share)).map_or_else(|| self.palette.at(share), |colour| colour.0)
    }
}

impl From<Palette> for Ramp<'_> {
    fn from(palette: Palette) -> Self {
        Self { palette, own: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_run_from_their_first_to_their_last_stop() {
        for option in Palette::options() {
            let palette = Palette::parse(&option.name).unwrap();
            let stops = palette.stops();
            assert!(stops.windows(2).all(|pair| pair[0].0 < pair[1].0), "{palette:?}");
            assert_eq!((stops[0].0, stops[stops.len() - 1].0), (0.0, 1.0));
            assert_eq!(palette.at(-1.0), palette.at(0.0));
            assert_eq!(palette.at(2.0), palette.at(1.0));
            assert_eq!(palette.at(f64::NAN), palette.at(0.0));
        }
        assert_eq!(Palette::Grey.at(0.5), [128, 128, 128, 255]);
    }

    #[test]
    fn blending_covers_by_alpha_and_share() {
        let (black, white) = ([0, 0, 0, 255], [255; 4]);
        assert_eq!(blend(black, white, 0.5), [128, 128, 128, 255]);
        assert_eq!(blend([0; 4], [10, 20, 30, 255], 1.0), [10, 20, 30, 255]);
        assert_eq!(blend([1, 2, 3, 0], [9, 9, 9, 0], 1.0), [1, 2, 3, 0]);
    }
}
