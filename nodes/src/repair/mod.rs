//! Mending terrain: voids filled, depressions drained, valleys made to fall.
//!
//! The pure functions that other families call: [`harmonic_fill::harmonic_fill`], [`breach_depressions::breach`],
//! [`fill_depressions::fill`].

pub mod breach_depressions;
pub mod enforce_valleys;
pub mod fill_depressions;
pub mod harmonic_fill;
pub mod lakes;
#[cfg(test)]
mod test_terrain;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<breach_depressions::BreachDepressions>(),
        NodeType::of::<enforce_valleys::EnforceValleys>(),
        NodeType::of::<fill_depressions::FillDepressions>(),
        NodeType::of::<harmonic_fill::HarmonicFill>(),
    ]
}
