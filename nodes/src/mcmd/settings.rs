//! What the nodes of this family have in common: schemes, presets, what is known, falloff.

use orograph_core::prelude::*;

use crate::mcmd::axis::{Axis, MAX_LEVELS};

/// How the plane is subdivided.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Edge midpoints from the edge's two ends, centres from the four corners.
    TriangleEdge,
    /// Edge midpoints also from the centres beside them; slightly smoother, slightly dearer.
    DiamondSquare,
}

/// Named settings from the literature and from practice.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The parameters below.
    Custom,
    /// Plain interpolation, for measured samples: l 0, l_bu 0, rs 0.
    Reconstruct,
    /// Mountains around ridges and rivers: l 1, l_bu 6, H 0.49, rt 0, rs 0.5.
    Mountains,
    /// Figure 3(a) of the paper: l 0.4, no displacement; figure 3(d) with the sign flipped.
    Figure3a,
    /// Figure 3(b): l 0.4, H 0.5, rt 0, rs 0.25.
    Figure3b,
    /// Figure 3(c): l 0.4, H 0.5, rt 1, rs 0.25.
    Figure3c,
    /// Figure 3(g): l 2, H 0.5, rt -0.97, rs 0.55; figure 3(h) with the sign flipped.
    Figure3g,
    /// Figures 8(b) and 8(c): l 1, l_bu 6, no displacement.
    Figure8b,
    /// Figure 8(d): l 0.7, l_bu 5, H 0.4, rt 1, rs 0.2.
    Figure8d,
    /// Figure 11(a): l 1, l_bu 6, H 0.49, rt 0, rs 0.5.
    Figure11a,
    /// Figure 11(b): l 1.1, l_bu 10, H 0.48, rt 0, rs 0.5.
    Figure11b,
    /// Figure 12(a): l 1.1, l_bu 20, H 0.45, rt 0.2, rs 1.
    Figure12a,
    /// Figure 12(b): l 1.1, l_bu 4, H 0.45, rt 0, rs 1.1.
    Figure12b,
    /// Figure 13: l 3, l_bu 7.5, H 0.5, rt 0.1, rs 1.3; a median filter follows it.
    Figure13,
}

/// The level about which heights are scaled.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Datum {
    /// The lowest constraint; 0 m when there is none.
    Lowest,
    /// 0 m, as the paper has it: results then depend on the height above the sea.
    Zero,
    /// The parameter `datum_level`.
    Level,
}

/// What holds computed heights back.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clamp {
    /// Nothing.
    Off,
    /// The range of the constraints.
    Constraints,
    /// The parameters `lowest` and `highest`.
    Levels,
}

/// The numbers that shape a surface: l, l_bu, H, rt and rs of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) l: f64,
    pub(crate) l_bu: f64,
    pub(crate) hurst: f64,
    pub(crate) rt: f64,
    pub(crate) rs: f64,
}

impl Preset {
    /// The preset's shape, or `custom`; `flip` turns the sign of l.
    pub(crate) fn shape(self, custom: Shape, flip: bool) -> Shape {
        let of = |l, l_bu, hurst, rt, rs| Shape { l, l_bu, hurst, rt, rs };
        let mut shape = match self {
            Self::Custom => custom,
            Self::Reconstruct => of(0.0, 0.0, 0.45, 0.0, 0.0),
            Self::Mountains | Self::Figure11a => of(1.0, 6.0, 0.49, 0.0, 0.5),
            Self::Figure3a => of(0.4, 0.0, 0.5, 0.0, 0.0),
            Self::Figure3b => of(0.4, 0.0, 0.5, 0.0, 0.25),
            Self::Figure3c => of(0.4, 0.0, 0.5, 1.0, 0.25),
            Self::Figure3g => of(2.0, 0.0, 0.5, -0.97, 0.55),
            Self::Figure8b => of(1.0, 6.0, 0.45, 0.0, 0.0),
            Self::Figure8d => of(0.7, 5.0, 0.4, 1.0, 0.2),
            Self::Figure11b => of(1.1, 10.0, 0.48, 0.0, 0.5),
            Self::Figure12a => of(1.1, 20.0, 0.45, 0.2, 1.0),
            Self::Figure12b => of(1.1, 4.0, 0.45, 0.0, 1.1),
            Self::Figure13 => of(3.0, 7.5, 0.5, 0.1, 1.3),
        };
        if flip {
            shape.l = -shape.l;
        }
        shape
    }
}

/// Everything that the two passes need, resolved against the constraints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    pub(crate) scheme: Scheme,
    pub(crate) shape: Shape,
    /// Height unit A of the displacement, in metres.
    pub(crate) relief: f64,
    /// Level about which heights are scaled, in metres.
    pub(crate) datum: f64,
    /// Factor on the displacement of centres.
    pub(crate) center_gain: f64,
    /// Limits of computed heights, in metres.
    pub(crate) limits: Option<(f64, f64)>,
    /// m of the paper: 2 in the plane, 1 for curves.
    pub(crate) dimensions: f64,
    pub(crate) seed: u64,
}

impl Settings {
    /// The computed height within its limits.
    #[inline]
    pub(crate) fn limit(&self, height: f64) -> f64 {
        match self.limits {
            Some((low, high)) => height.clamp(low, high),
            None => height,
        }
    }

    /// Displacement per random number at a level: rs · A · 2^(-level · m · H), equation (1) of the paper.
    pub(crate) fn amplitude(&self, level: usize) -> f64 {
        let Shape { rs, hurst, .. } = self.shape;
        rs * self.relief * libm::pow(2.0, -(level as f64) * self.dimensions * hurst)
    }
}

/// Known cells of a field of constraints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Known {
    pub(crate) cells: usize,
    /// Lowest and highest known height.
    pub(crate) range: Option<(f32, f32)>,
}

impl Known {
    /// # Errors
    /// [`Error::NonFinite`] on an infinite constraint; [`Error::EmptyInput`] without cells.
    pub(crate) fn of(constraints: &Heightfield) -> Result<Self> {
        if constraints.grid().is_empty() {
            return Err(Error::EmptyInput { what: "the field of constraints".into() });
        }
        let range = constraints.range();
        if range.is_some_and(|(low, high)| low.is_infinite() || high.is_infinite()) {
            let cols = constraints.cols();
            let at = constraints.cells().iter().position(|height| height.is_infinite()).unwrap_or(0);
            return Err(Error::NonFinite { what: "constraints".into(), row: at / cols, col: at % cols });
        }
        Ok(Self { cells: constraints.grid().len() - constraints.void_count(), range })
    }

    /// The relief asked for, or that of the constraints when it is 0, or 1 m when they have none.
    pub(crate) fn relief(&self, asked: f64) -> f64 {
        let own = self.range.map_or(0.0, |(low, high)| f64::from(high) - f64::from(low));
        match (asked > 0.0, own > 0.0) {
            (true, _) => asked,
            (false, true) => own,
            (false, false) => 1.0,
        }
    }
}

/// The factor of equation (2) of the paper for a distance that is `share` of the diagonal.
pub(crate) fn falloff(share: f64, l: f64) -> f64 {
    let sign = if l >= 0.0 { 1.0 } else { -1.0 };
    1.0 - sign * (1.0 - libm::pow(1.0 - share, l.abs()))
}

/// [`falloff`] for every distance between a cell and its ascendants, level by level.
#[derive(Clone, Debug)]
pub(crate) struct Falloff {
    /// Indexed by level, then [`Axis::step`] along a row and along a column.
    factors: Vec<[[f64; 3]; 3]>,
    datum: f64,
    flat: bool,
}

impl Falloff {
    pub(crate) fn new(cols: &Axis, rows: &Axis, l: f64, datum: f64) -> Self {
        let side = |axis: &Axis| axis.len().saturating_sub(1) as f64;
        let diagonal = libm::hypot(side(cols), side(rows));
        let half = |axis: &Axis, level: usize, step: usize| match step {
            0 => 0.0,
            step => f64::from(axis.half[level]) + (step - 1) as f64,
        };
        let mut factors = vec![[[1.0; 3]; 3]; MAX_LEVELS];
        let depth = cols.depth.max(rows.depth);
        for (level, factors) in factors.iter_mut().enumerate().take(depth + 1).skip(1) {
            for (step_x, factors) in factors.iter_mut().enumerate() {
                for (step_y, factor) in factors.iter_mut().enumerate() {
                    let distance = libm::hypot(half(cols, level, step_x), half(rows, level, step_y));
                    // The larger half of a short axis may not exist and then exceed the diagonal.
                    *factor = falloff((distance / diagonal).min(1.0), l);
                }
            }
        }
        Self { factors, datum, flat: l == 0.0 }
    }

    /// Whether heights pass unchanged.
    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    pub(crate) fn level(&self, level: usize) -> &[[f64; 3]; 3] {
        &self.factors[level]
    }

    /// A height scaled about the datum.
    #[inline]
    pub(crate) fn apply(&self, height: f32, factor: f64) -> f64 {
        if self.flat { f64::from(height) } else { self.scale(height, factor) }
    }

    /// [`apply`](Self::apply) where the falloff is known not to be flat.
    #[inline(always)]
    pub(crate) fn scale(&self, height: f32, factor: f64) -> f64 {
        self.datum + (f64::from(height) - self.datum) * factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falloff_follows_the_papers_table() {
        let near = |a: f64, b: f64, tolerance: f64| assert!((a - b).abs() < tolerance, "{a} {b}");
        for (l, table) in [
            (0.4, [1.0, 0.758, 0.398]),
            (2.0, [1.0, 0.25, 0.01]),
            (-2.0, [1.0, 1.75, 1.99]),
            (0.0, [1.0, 1.0, 1.0]),
        ] {
            for (share, expected) in [0.0, 0.5, 0.9].into_iter().zip(table) {
                near(falloff(share, l), expected, 5e-4);
            }
        }
        near(falloff(1.0, 1.0), 0.0, 1e-15);
        near(falloff(1.0, -1.0), 2.0, 1e-15);
    }

    #[test]
    fn flipping_turns_the_sign_of_l_alone() {
        let custom = Shape { l: 0.0, l_bu: 0.0, hurst: 0.45, rt: 0.0, rs: 0.0 };
        let (plain, flipped) =
            (Preset::Figure11a.shape(custom, false), Preset::Figure11a.shape(custom, true));
        assert_eq!(plain.l, -flipped.l);
        assert_eq!(Shape { l: 1.0, ..flipped }, plain);
        assert_eq!(Preset::Custom.shape(custom, false), custom);
    }
}
