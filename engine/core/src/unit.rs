//! The closed list of units that parameters and metrics carry.

use serde::{Deserialize, Serialize};

/// A unit of measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Unit {
    /// A pure number: a ratio, an exponent, a count.
    #[default]
    One,
    /// Metres.
    Metre,
    /// Degrees of angle.
    Degree,
    /// Cells of the grid at hand.
    Cell,
    /// Pixels of a picture.
    Pixel,
    /// Percent.
    Percent,
    /// A seed: any integer, each giving another result of the same kind.
    Seed,
    /// Metres per metre: a gradient.
    Gradient,
    /// Per metre: a curvature or a wave number.
    PerMetre,
    /// Square metres.
    SquareMetre,
    /// Bytes.
    Byte,
    /// Seconds.
    Second,
}

impl Unit {
    const ALL: [(Self, &'static str); 12] = [
        (Self::One, "1"),
        (Self::Metre, "m"),
        (Self::Degree, "deg"),
        (Self::Cell, "cells"),
        (Self::Pixel, "px"),
        (Self::Percent, "%"),
        (Self::Seed, "seed"),
        (Self::Gradient, "m/m"),
        (Self::PerMetre, "1/m"),
        (Self::SquareMetre, "m2"),
        (Self::Byte, "B"),
        (Self::Second, "s"),
    ];

    /// The unit written as `symbol`.
    ///
    /// # Panics
    /// On a symbol outside the list; derives call this at compile time, where that is a compile error.
    #[must_use]
    pub const fn parse(symbol: &str) -> Self {
        match Self::of_symbol(symbol) {
            Some(unit) => unit,
            None => panic!("unknown unit: use one of 1, m, deg, cells, px, %, seed, m/m, 1/m, m2, B, s"),
        }
    }

    /// The unit written as `symbol`; `None` outside the list.
    #[must_use]
    pub const fn of_symbol(symbol: &str) -> Option<Self> {
        let mut i = 0;
        while i < Self::ALL.len() {
            if same(Self::ALL[i].1.as_bytes(), symbol.as_bytes()) {
                return Some(Self::ALL[i].0);
            }
            i += 1;
        }
        None
    }

    /// How the unit is written.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        Self::ALL.iter().find(|(unit, _)| *unit == self).map_or("1", |(_, symbol)| symbol)
    }
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
