//! Mending terrain: voids filled, depressions drained, valleys made to fall.
//!
//! The pure functions that other families call: [`harmonic_fill::harmonic_fill`], [`breach_depressions::breach`],
//! [`fill_depressions::fill`].

pub mod area_details;
pub mod breach_depressions;
pub mod combine_by_relevance;
pub mod curve_patch;
pub mod curves;
pub mod enforce_valleys;
pub mod feather;
pub mod fill_depressions;
pub mod find_voids;
pub mod harmonic_fill;
pub mod lakes;
#[cfg(test)]
mod test_terrain;
pub mod thin_plate_fill;
pub mod void_patch;
pub mod void_uncertainty;
pub mod voids;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<area_details::AreaDetails>(),
        NodeType::of::<breach_depressions::BreachDepressions>(),
        NodeType::of::<combine_by_relevance::CombineByRelevance>(),
        NodeType::of::<curve_patch::CurvePatch>(),
        NodeType::of::<enforce_valleys::EnforceValleys>(),
        NodeType::of::<feather::FeatherRim>(),
        NodeType::of::<fill_depressions::FillDepressions>(),
        NodeType::of::<find_voids::FindVoids>(),
        NodeType::of::<harmonic_fill::HarmonicFill>(),
        NodeType::of::<thin_plate_fill::ThinPlateFill>(),
        NodeType::of::<void_patch::VoidPatch>(),
        NodeType::of::<void_uncertainty::VoidUncertainty>(),
    ]
}
