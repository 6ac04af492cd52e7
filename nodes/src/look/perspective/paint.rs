//! Triangles into pixels, with a depth buffer.

use orograph_core::{CellSize, Grid, Job, Result, Texture};
use rayon::prelude::*;

use super::super::colour::{Tint, byte};

/// A corner of a triangle in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Pixels from the left.
    pub(super) x: f64,
    /// Pixels from the top.
    pub(super) y: f64,
    /// One over the distance along the view, which is linear in the picture.
    pub(super) near: f64,
    pub(super) colour: Tint,
}

/// What is to be drawn.
pub(super) struct Scene {
    /// A lattice, row by row; `None` at holes. Four neighbours are two triangles.
    pub(super) corners: Vec<Option<Corner>>,
    pub(super) cols: usize,
    pub(super) sides: Vec<[Corner; 3]>,
}

/// Squares of the lattice, side by side, that are looked at together.
const STRETCH: usize = 32;

impl Scene {
    /// Stretches of pairs of neighbouring rows, row by row.
    fn stretches(&self) -> impl Iterator<Item = [&[Option<Corner>]; 2]> {
        let rows = self.corners.len() / self.cols;
        let starts = move |row| (0..self.cols.saturating_sub(1)).step_by(STRETCH).map(move |col| (row, col));
        (1..rows).flat_map(starts).map(|(row, first)| {
            let end = (first + STRETCH + 1).min(self.cols);
            [row - 1, row].map(|row| &self.corners[row * self.cols..][first..end])
        })
    }
}

fn all(corners: [Option<Corner>; 3]) -> Option<[Corner; 3]> {
    let [a, b, c] = corners;
    Some([a?, b?, c?])
}

/// The rows of pixels that corners lie between.
fn span<'a>(corners: impl IntoIterator<Item = &'a Corner>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    corners.into_iter().fold(none, |(first, last), corner| (first.min(corner.y), last.max(corner.y)))
}

/// Pixels under work.
pub(super) struct Painter {
    width: usize,
    pixels: Vec<(f64, Tint)>,
}

/// Rows that one task paints.
const BAND: usize = 32;

impl Painter {
    pub(super) fn new((width, height): (usize, usize), background: Tint, job: &Job) -> Result<Self> {
        job.admit((width * height * size_of::<(f64, Tint)>()) as u64, || {
            format!("a view of {width} × {height} pixels")
        })?;
        Ok(Self { width, pixels: vec![(0.0, background); width * height] })
    }

    /// Draws a scene, the nearest on top; of equals the first.
    pub(super) fn paint(&mut self, scene: &Scene, job: &Job) -> Result<()> {
        let width = self.width;
        let stretches: Vec<[&[Option<Corner>]; 2]> = scene.stretches().collect();
        let spans: Vec<(f64, f64)> =
            stretches.par_iter().map(|rows| span(rows.iter().copied().flatten().flatten())).collect();
        let bands = self.pixels.par_chunks_mut(width * BAND).enumerate();
        let done = job.stage(bands.len() as u64);
        bands.try_for_each(|(band, pixels)| {
            job.check()?;
            let (top, bottom) = ((band * BAND) as f64, (band * BAND + pixels.len() / width) as f64);
            let crosses = |(first, last): (f64, f64)| last >= top && first <= bottom;
            let mut draw = |triangle: &[Corner; 3]| {
                if crosses(span(triangle)) {
                    fill(triangle, pixels, width, band * BAND);
                }
            };
            for ([north, south], _) in stretches.iter().zip(&spans).filter(|(_, span)| crosses(**span)) {
                for (north, south) in north.windows(2).zip(south.windows(2)) {
                    let [nw, ne, sw, se] = [north[0], north[1], south[0], south[1]];
                    [[nw, ne, sw], [ne, se, sw]]
                        .into_iter()
                        .filter_map(all)
                        .for_each(|triangle| draw(&triangle));
                }
            }
            scene.sides.iter().for_each(draw);
            done.advance(1);
            Ok(())
        })
    }

    /// The picture at one pixel for each square of `samples` × `samples`.
    pub(super) fn averaged(self, samples: usize, job: &Job) -> Result<Texture> {
        let (width, height) = (self.width / samples, self.pixels.len() / self.width / samples);
        let grid = Grid::new(height, width, CellSize::square(1.0))?;
        let count = (samples * samples) as f64;
        Texture::build(grid, job, |row, out| {
            for (col, out) in out.iter_mut().enumerate() {
                let mut sum = [0.0; 4];
                for y in row * samples..(row + 1) * samples {
                    for (_, colour) in &self.pixels[y * self.width + col * samples..][..samples] {
                        sum.iter_mut().zip(colour).for_each(|(sum, &part)| *sum += f64::from(part));
                    }
                }
                *out = sum.map(|sum| byte(sum / count));
            }
            Ok(())
        })
    }
}

/// Draws the part of a triangle that lies in the rows from `top` on that `pixels` hold.
fn fill([a, b, c]: &[Corner; 3], pixels: &mut [(f64, Tint)], width: usize, top: usize) {
    let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let rows = pixels.len() / width;
    let within = |low: f64, high: f64, from: usize, count: usize| {
        let first = (low - 0.5).ceil().max(from as f64) as usize;
        let last = (high - 0.5).floor().min((from + count) as f64 - 1.0);
        // Empty where the triangle passes between the middles of pixels.
        let end = if last < 0.0 { 0 } else { last as usize + 1 };
        first.min(end)..end
    };
    let columns = within(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), 0, width);
    for y in within(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), top, rows) {
        let middle_y = y as f64 + 0.5;
        for x in columns.clone() {
            let middle_x = x as f64 + 0.5;
            let across =
                |p: &Corner, q: &Corner| (q.x - p.x) * (middle_y - p.y) - (middle_x - p.x) * (q.y - p.y);
            let parts = [across(b, c), across(c, a), across(a, b)];
            // Most pixels of the box are outside, which is told without dividing.
            if parts.iter().any(|&part| part != 0.0 && (part < 0.0) != (area < 0.0)) {
                continue;
            }
            let shares = parts.map(|part| part / area);
            let near = shares[0] * a.near + shares[1] * b.near + shares[2] * c.near;
            let pixel = &mut pixels[(y - top) * width + x];
            if near > pixel.0 {
                let mix = |i: usize| {
                    let [a, b, c] = [a, b, c].map(|corner| f64::from(corner.colour[i]));
                    byte(shares[0] * a + shares[1] * b + shares[2] * c)
                };
                *pixel = (near, [mix(0), mix(1), mix(2), mix(3)]);
            }
        }
    }
}
