//! Scattered constraints.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// Scattered heights: world x and y and height, in metres, one entry of each per point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    heights: Vec<f64>,
}

impl Points {
    /// Points from three columns of equal length.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the lengths differ.
    pub fn new(x: Vec<f64>, y: Vec<f64>, heights: Vec<f64>) -> Result<Self> {
        if x.len() != y.len() || x.len() != heights.len() {
            return Err(Error::invalid(
                format!("{} x, {} y and {} heights do not pair up", x.len(), y.len(), heights.len()),
                "give one x, y and height for each point",
            ));
        }
        Ok(Self { x, y, heights })
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The columns x, y and height.
    #[must_use]
    pub fn columns(&self) -> (&[f64], &[f64], &[f64]) {
        (&self.x, &self.y, &self.heights)
    }

    /// Each point as (x, y, height).
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (f64, f64, f64)> + '_ {
        (0..self.x.len()).map(|i| (self.x[i], self.y[i], self.heights[i]))
    }
}
