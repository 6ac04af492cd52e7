//! Poisson's equation on cells: what a step at a seam is spread with.

mod columns;
mod floating;
mod iteration;
pub mod masked;
mod multigrid;
pub mod natural;
mod network;
pub mod rectangle;
mod rolling;
mod rows;
pub mod seam;
mod stencil;
mod terms;
