//! Where in an exemplar a partly known window fits: sums of squared differences at all positions at once.
//!
//! Zhou 2007 §5.5, after Kwatra 2003: with S the exemplar, T the window and m what is known of it,
//! `SSD(o) = sum m T² - 2 (S ⋆ mT)(o) + (S² ⋆ m)(o)`, correlations by Fourier transform. By default the mean difference
//! is taken out first, so that ground fits at any level. Large exemplars are searched at a coarser resolution and what is
//! found there is compared again cell by cell.

mod fourier;
mod roughness;
pub mod search;

pub use search::{Found, Query, Searcher};
