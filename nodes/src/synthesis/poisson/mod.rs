//! Poisson's equation on cells: what a step at a seam is spread with.

mod columns;
pub mod masked;
mod multigrid;
pub mod natural;
pub mod rectangle;
pub mod seam;
