//! Metrics.

pub mod append;
pub mod compare;
pub mod copies;
pub mod curvature;
pub mod distribution;
pub mod drainage;
mod fourier;
pub mod geomorphons;
pub mod hypsometry;
pub mod realism;
mod rim;
pub mod seams;
pub mod slope;
mod slope_distance;
pub mod slope_distribution;
pub mod spectrum;
pub mod statistics;
mod sums;
pub mod variogram;

use orograph_core::NodeType;

/// The nodes of this family.
pub(crate) fn nodes() -> Vec<NodeType> {
    vec![
        NodeType::of::<append::Append>(),
        NodeType::of::<compare::Compare>(),
        NodeType::of::<copies::Copies>(),
        NodeType::of::<curvature::Curvature>(),
        NodeType::of::<drainage::Drainage>(),
        NodeType::of::<geomorphons::Geomorphons>(),
        NodeType::of::<hypsometry::Hypsometry>(),
        NodeType::of::<realism::Realism>(),
        NodeType::of::<seams::Seams>(),
        NodeType::of::<slope::Slope>(),
        NodeType::of::<slope_distribution::SlopeDistribution>(),
        NodeType::of::<spectrum::Spectrum>(),
        NodeType::of::<statistics::Statistics>(),
        NodeType::of::<variogram::Variogram>(),
    ]
}
