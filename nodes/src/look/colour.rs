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
    /// The colours from 0 to 1.
    #[must_use]
    pub const fn gradient(self) -> Gradient {
        Gradient::of(match self {
            Self::Atlas => {
                const {
                    &[
                        (0.0, Colour::rgb(0x3d_7d5e)),
                        (0.14, Colour::rgb(0x77_ab6f)),
                        (0.3, Colour::rgb(0xc3_d08a)),
                        (0.47, Colour::rgb(0xe9_d69c)),
                        (0.65, Colour::rgb(0xc9_9e6c)),
                        (0.82, Colour::rgb(0x98_7460)),
                        (0.93, Colour::rgb(0xd6_cfca)),
                        (1.0, Colour::rgb(0xff_ffff)),
                    ]
                }
            }
            Self::Alpine => {
                const {
                    &[
                        (0.0, Colour::rgb(0x46_6338)),
                        (0.25, Colour::rgb(0x78_905b)),
                        (0.45, Colour::rgb(0xa8_a57f)),
                        (0.62, Colour::rgb(0x97_8d83)),
                        (0.78, Colour::rgb(0xb7_b2ac)),
                        (0.9, Colour::rgb(0xe8_eaed)),
                        (1.0, Colour::rgb(0xff_ffff)),
                    ]
                }
            }
            Self::Desert => {
                const {
                    &[
                        (0.0, Colour::rgb(0x6a_3d29)),
                        (0.25, Colour::rgb(0xa1_5c39)),
                        (0.5, Colour::rgb(0xce_8d56)),
                        (0.75, Colour::rgb(0xe8_c389)),
                        (1.0, Colour::rgb(0xf9_eed3)),
                    ]
                }
            }
            Self::Grey => const { &[(0.0, Colour::rgb(0x00_0000)), (1.0, Colour::rgb(0xff_ffff))] },
            Self::Viridis => {
                const {
                    &[
                        (0.0, Colour::rgb(0x44_0154)),
                        (0.125, Colour::rgb(0x47_2d7b)),
                        (0.25, Colour::rgb(0x3b_528b)),
                        (0.375, Colour::rgb(0x2c_728e)),
                        (0.5, Colour::rgb(0x21_918c)),
                        (0.625, Colour::rgb(0x28_ae80)),
                        (0.75, Colour::rgb(0x5e_c962)),
                        (0.875, Colour::rgb(0xad_dc30)),
                        (1.0, Colour::rgb(0xfd_e725)),
                    ]
                }
            }
            Self::Heat => {
                const {
                    &[
                        (0.0, Colour::rgb(0xff_ffff)),
                        (0.2, Colour::rgb(0xfd_ecb3)),
                        (0.45, Colour::rgb(0xf5_aa5c)),
                        (0.7, Colour::rgb(0xcf_4a31)),
                        (1.0, Colour::rgb(0x4b_0d20)),
                    ]
                }
            }
            Self::Diverging => {
                const {
                    &[
                        (0.0, Colour::rgb(0x10_3a70)),
                        (0.22, Colour::rgb(0x3f_86c0)),
                        (0.38, Colour::rgb(0xa9_cfe6)),
                        (0.5, Colour::rgb(0xf7_f7f7)),
                        (0.62, Colour::rgb(0xf3_bda0)),
                        (0.78, Colour::rgb(0xd2_5f4d)),
                        (1.0, Colour::rgb(0x7d_1023)),
                    ]
                }
            }
        })
    }

    /// The colour at `share` of the ramp; held at its ends, and at the low end for NaN.
    #[must_use]
    pub fn at(self, share: f64) -> Tint {
        tint(&self.gradient(), share)
    }

    /// The user's own colours, or those of the palette where there are none.
    #[must_use]
    pub fn unless(self, own: &Gradient) -> Gradient {
        if own.stops().is_empty() { self.gradient() } else { own.clone() }
    }
}

/// The colour at `share` of a gradient; transparent where that has no stops.
#[must_use]
pub fn tint(gradient: &Gradient, share: f64) -> Tint {
    gradient.at(share).map_or([0; 4], |colour| colour.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_run_from_their_first_to_their_last_stop() {
        for option in Palette::options() {
            let palette = Palette::parse(&option.name).unwrap();
            let gradient = palette.gradient();
            let stops = gradient.stops();
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
