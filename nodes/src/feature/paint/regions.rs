//! Outlines filled with their numbers.

use orograph_core::prelude::*;

/// A raster that holds, where cells lie inside an outline of (row, column, number), the number at the outline's first
/// place, of later outlines before earlier ones, and `outside` elsewhere. An outline closes by itself; inside is what a
/// ray crosses it an odd number of times from. A cell whose middle lies on an outline belongs to one side of it alone, so
/// that regions with a border in common leave nothing between them.
///
/// # Errors
/// [`Error::TooLarge`], or cancellation.
pub(super) fn fill(
    outlines: &[Vec<[f64; 3]>],
    outside: f32,
    grid: &Grid,
    job: &Job<'_>,
) -> Result<Heightfield> {
    Heightfield::build(grid.clone(), job, |row, out| {
        out.fill(outside);
        let mut crossings = Vec::new();
        for outline in outlines.iter().filter(|outline| outline.len() > 2) {
            crossings.clear();
            let next = outline.iter().cycle().skip(1);
            for (a, b) in outline.iter().zip(next) {
                let row = row as f64;
                if (a[0] <= row) != (b[0] <= row) {
                    crossings.push(a[1] + (b[1] - a[1]) * ((row - a[0]) / (b[0] - a[0])));
                }
            }
            crossings.sort_unstable_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let cols = out.len();
                let column = |x: f64| (x.ceil().max(0.0) as usize).min(cols);
                out[column(pair[0])..column(pair[1])].fill(outline[0][2] as f32);
            }
        }
        job.check()
    })
}
