//! Profile: heights along a straight line.

use glam::DVec2;
use orograph_core::prelude::*;

use super::chart::{Axis, Chart, Series, Style};
use crate::measure::append::split_list;

/// Plots heights along a straight line across one terrain or several.
///
/// Heights are interpolated linearly between cell centres; a void interrupts the line. Distances are true
/// ones on the ground. The plot has no place in the world.
#[derive(Params, Clone, Debug)]
pub struct Profile {
    /// Where the line starts, as a share of the width from the west.
    #[param(default = 0, range = 0.0..=1.0, unit = "1")]
    pub from_x: f64,
    /// Where the line starts, as a share of the height from the north.
    #[param(default = 0.5, range = 0.0..=1.0, unit = "1")]
    pub from_y: f64,
    /// Where the line ends, as a share of the width from the west.
    #[param(default = 1, range = 0.0..=1.0, unit = "1")]
    pub to_x: f64,
    /// Where the line ends, as a share of the height from the north.
    #[param(default = 0.5, range = 0.0..=1.0, unit = "1")]
    pub to_y: f64,
    /// Names of the terrains, in order, separated by `;` or line ends.
    #[param(default = "")]
    pub labels: String,
    /// Heading of the plot; none when empty.
    #[param(default = "")]
    pub title: String,
    /// Width of the plot.
    #[param(default = 960u32, range = 64..=8192, slider = 320..=1920, unit = "px")]
    pub width: u32,
    /// Height of the plot.
    #[param(default = 360u32, range = 64..=8192, slider = 240..=1080, unit = "px")]
    pub height: u32,
}

/// Inputs of [`Profile`].
#[derive(Inputs)]
pub struct ProfileIn<'a> {
    /// Terrains to cut.
    pub terrains: Vec<&'a Heightfield>,
}

/// Outputs of [`Profile`].
#[derive(Outputs)]
pub struct ProfileOut {
    /// The plot.
    pub picture: Texture,
}

impl Node for Profile {
    const ID: &'static str = "look.profile";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ProfileIn<'a>;
    type Outputs = ProfileOut;

    fn run(&self, inputs: ProfileIn<'_>, job: &Job) -> Result<ProfileOut> {
        if inputs.terrains.iter().all(|terrain| terrain.grid().is_empty()) {
            return Err(Error::EmptyInput { what: "terrains".into() });
        }
        let labels = split_list(&self.labels);
        let mut series = Vec::new();
        for (i, terrain) in inputs.terrains.iter().enumerate() {
            let name = labels.get(i).map_or_else(String::new, |label| (*label).to_owned());
            let points = if terrain.grid().is_empty() { Vec::new() } else { self.cut(terrain, job)? };
            series.push(Series { name, style: Style::Line, points });
        }
        let longest =
            series.iter().filter_map(|series| series.points.last()).fold(0.0, |long, end| end.x.max(long));
        let kilometres = longest >= 5000.0;
        if kilometres {
            series.iter_mut().flat_map(|series| &mut series.points).for_each(|point| point.x /= 1000.0);
        }
        let label = if kilometres { "distance (km)" } else { "distance (m)" };
        let chart = Chart {
            title: self.title.clone(),
            x: Axis { label: label.into(), tight: true, ..Axis::default() },
            y: Axis { label: "height (m)".into(), ..Axis::default() },
            series,
            width: self.width,
            height: self.height,
        };
        Ok(ProfileOut { picture: chart.draw(job)? })
    }
}

impl Profile {
    /// (distance in metres, height) along the line, about two points a cell.
    fn cut(&self, terrain: &Heightfield, job: &Job) -> Result<Vec<DVec2>> {
        let grid = terrain.grid();
        let place = |x: f64, y: f64| {
            DVec2::new(x * grid.cols.saturating_sub(1) as f64, y * grid.rows.saturating_sub(1) as f64)
        };
        let (from, to) = (place(self.from_x, self.from_y), place(self.to_x, self.to_y));
        let ground = ((to - from) * DVec2::new(grid.cell.x, grid.cell.y)).length();
        let cells = (to - from).abs().max_element();
        // More points than this no plot can show.
        let steps = (2.0 * cells).ceil().clamp(1.0, 65_536.0);
        let mut points = Vec::new();
        for i in 0..=steps as usize {
            if i % 1024 == 0 {
                job.check()?;
            }
            let t = i as f64 / steps;
            points.push(DVec2::new(t * ground, interpolated(terrain, from.lerp(to, t))));
        }
        Ok(points)
    }
}

/// The height at a fractional (column, row) inside the grid; NaN beside a void that counts.
fn interpolated(terrain: &Heightfield, at: DVec2) -> f64 {
    let (rows, cols) = terrain.grid().size();
    let corner = at.floor();
    let part = at - corner;
    let (row, col) = (corner.y as usize, corner.x as usize);
    let mut height = 0.0;
    for (dr, tall) in [(0, 1.0 - part.y), (1, part.y)] {
        for (dc, wide) in [(0, 1.0 - part.x), (1, part.x)] {
            // A neighbour without weight may be a void, or outside.
            if tall * wide > 0.0 {
                let cell = terrain.at((row + dr).min(rows - 1), (col + dc).min(cols - 1));
                height += tall * wide * f64::from(cell);
            }
        }
    }
    height
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_through_a_plane_is_a_straight_line() {
        let grid = Grid::new(5, 9, CellSize { x: 30.0, y: 20.0 }).unwrap();
        let cells = (0..45).map(|i| (i / 9) as f32 * 2.0 + (i % 9) as f32).collect();
        let terrain = Heightfield::new(grid, cells).unwrap();
        let node = Profile { from_x: 0.1, from_y: 0.0, to_x: 1.0, to_y: 0.9, ..Profile::default() };
        let points = node.cut(&terrain, &Job::detached()).unwrap();
        let length = libm::hypot(7.2 * 30.0, 3.6 * 20.0);
        for (i, point) in points.iter().enumerate() {
            let t = i as f64 / (points.len() - 1) as f64;
            assert!((point.x - t * length).abs() < 1e-9);
            assert!((point.y - (0.8 + t * (7.2 + 7.2))).abs() < 1e-6, "{i}: {point}");
        }
    }

    #[test]
    fn odd_terrains_are_drawn_or_refused() {
        let run = |heights: &[f32]| {
            let terrain = crate::test_fields::row(heights);
            Profile::default().run(ProfileIn { terrains: vec![&terrain] }, &Job::detached()).map(|_| ())
        };
        for heights in [&[3.0][..], &[f32::NAN; 4], &[f32::INFINITY, 0.0], &[1.0, f32::NAN, 2.0]] {
            assert_eq!(run(heights), Ok(()));
        }
        assert!(matches!(run(&[]), Err(Error::EmptyInput { .. })));
    }
}
