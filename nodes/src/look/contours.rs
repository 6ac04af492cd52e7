//! Contours: lines of equal height, drawn over a picture.
//!
//! Marching squares between cell centres: each square of four neighbouring heights is crossed by straight
//! lines, where a saddle is cut by the mean of its corners. Every pixel takes the coverage of the nearest
//! line, which needs nothing but its own surroundings, so tiles equal the whole. Level ground at exactly a
//! contour's height is edged, not filled.

use glam::DVec2;
use orograph_core::prelude::*;

use super::{
    canvas::distance_to_segment,
    colour::{PAPER, blend},
};

/// Beyond this many lines in one square the ground is a wall, drawn solid.
const MOST_LEVELS: f64 = 16.0;

/// Draws lines of equal height over a picture, or on white paper.
#[derive(Params, Clone, Debug)]
pub struct Contours {
    /// Height between two lines.
    #[param(default = 50, range = 0.01..=10_000.0, slider = 5.0..=500.0, unit = "m")]
    pub interval: f64,
    /// Height at which a line runs; the others follow from it by whole intervals.
    #[param(default = 0, range = -20_000.0..=20_000.0, slider = 0.0..=1000.0, unit = "m")]
    pub base: f64,
    /// Every so many lines one is drawn thicker; 0 for none.
    #[param(default = 5u32, range = 0..=1000, slider = 0..=10, unit = "1")]
    pub index_every: u32,
    /// Thickness of lines.
    #[param(default = 0.8, range = 0.1..=32.0, slider = 0.5..=4.0, unit = "px")]
    pub width: f64,
    /// Thickness of index lines.
    #[param(default = 1.6, range = 0.1..=32.0, slider = 0.5..=6.0, unit = "px")]
    pub index_width: f64,
    /// Colour of lines, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour([0x5a, 0x3c, 0x22, 0xc8]))]
    pub colour: Colour,
}

/// Inputs of [`Contours`].
#[derive(Inputs)]
pub struct ContoursIn<'a> {
    /// Terrain whose heights the lines follow.
    pub terrain: &'a Heightfield,
    /// Picture to draw over, on the terrain's grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`Contours`].
#[derive(Outputs)]
pub struct ContoursOut {
    /// The picture with the lines.
    pub picture: Texture,
}

impl Node for Contours {
    const ID: &'static str = "look.contours";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = ContoursIn<'a>;
    type Outputs = ContoursOut;

    fn halo(&self, _cell: CellSize) -> usize {
        self.reach()
    }

    fn cost(&self) -> f64 {
        8.0
    }

    fn run(&self, inputs: ContoursIn<'_>, job: &Job) -> Result<ContoursOut> {
        let ContoursIn { terrain, onto } = inputs;
        if let Some(onto) = onto {
            terrain.grid().match_size("terrain", onto.grid(), "onto")?;
        }
        let ink = self.colour.0;
        let picture = Texture::build(terrain.grid().clone(), job, |row, out| {
            let covered = self.coverage(terrain, row);
            for (col, (pixel, share)) in out.iter_mut().zip(covered).enumerate() {
                let under = onto.map_or(PAPER, |onto| onto.at(row, col));
                *pixel = blend(under, ink, share);
            }
            Ok(())
        })?;
        Ok(ContoursOut { picture })
    }
}

impl Contours {
    /// Cells beyond which no line touches a pixel.
    fn reach(&self) -> usize {
        (self.width.max(self.index_width) / 2.0 + 0.5).ceil() as usize
    }

    /// How much of each pixel of a row the nearest lines cover.
    fn coverage(&self, terrain: &Heightfield, row: usize) -> Vec<f64> {
        let (rows, cols) = terrain.grid().size();
        let reach = self.reach();
        let mut covered: Vec<f64> = vec![0.0; cols];
        for top in row.saturating_sub(reach)..(row + reach).min(rows.saturating_sub(1)) {
            let (north, south) = (terrain.row(top).windows(2), terrain.row(top + 1).windows(2));
            for (left, (north, south)) in north.zip(south).enumerate() {
                let square = [north[0], north[1], south[1], south[0]].map(f64::from);
                let Some(levels) = self.levels(square) else { continue };
                let (first, end) = ((left + 1).saturating_sub(reach), (left + reach + 1).min(cols));
                let start = DVec2::new(first as f64 - left as f64, row as f64 - top as f64);
                self.cover(square, levels, start, &mut covered[first..end]);
            }
        }
        covered
    }

    /// The numbers of the lines just below the lowest and the highest corner of a square; `None` where no
    /// line crosses it.
    fn levels(&self, square: [f64; 4]) -> Option<(f64, f64)> {
        let level = |height: f64| ((height - self.base) / self.interval).floor();
        let [a, b, c, d] = square.map(level);
        let (lowest, highest) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        (lowest != highest && square.iter().all(|height| height.is_finite())).then_some((lowest, highest))
    }

    /// Raises what is covered of a run of pixels, the first of which lies at `start`, by the lines in a
    /// square whose corners run clockwise from (0, 0).
    fn cover(&self, square: [f64; 4], levels: (f64, f64), start: DVec2, covered: &mut [f64]) {
        let (lowest, highest) = levels;
        let mut raise = |share: &dyn Fn(DVec2) -> f64| {
            for (i, covered) in covered.iter_mut().enumerate() {
                *covered = covered.max(share(start + DVec2::X * i as f64));
            }
        };
        if highest - lowest > MOST_LEVELS {
            let inside = |at: DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all();
            return raise(&|at| if inside(at) { 1.0 } else { 0.0 });
        }
        for step in 1..=(highest - lowest) as u32 {
            let line = lowest + f64::from(step);
            let every = f64::from(self.index_every);
            let index = every > 0.0 && line - (line / every).floor() * every == 0.0;
            let width = if index { self.index_width } else { self.width };
            // A line thinner than a pixel is paler, not narrower: it never falls between pixels.
            let (reach, ink) = (width.max(1.0) / 2.0 + 0.5, width.min(1.0));
            for (from, to) in segments(square, self.base + line * self.interval).into_iter().flatten() {
                raise(&|at| (reach - distance_to_segment(at, from, to)).clamp(0.0, 1.0) * ink);
            }
        }
    }
}

/// Where a level crosses a unit square whose corners run clockwise from (0, 0).
fn segments(square: [f64; 4], level: f64) -> [Option<(DVec2, DVec2)>; 2] {
    const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let above = square.map(|height| height >= level);
    // The crossing of each side, from its corner to the next.
    let crossing = |side: usize| {
        let (i, j) = (side, (side + 1) % 4);
        (above[i] != above[j])
            .then(|| CORNERS[i].lerp(CORNERS[j], (level - square[i]) / (square[j] - square[i])))
    };
    let sides = [crossing(0), crossing(1), crossing(2), crossing(3)];
    if let [Some(top), Some(right), Some(bottom), Some(left)] = sides {
        let mean = square.iter().sum::<f64>() / 4.0;
        // The lines of a saddle cut off the two corners that are unlike its middle.
        return if (mean >= level) == above[0] {
            [Some((top, right)), Some((bottom, left))]
        } else {
            [Some((top, left)), Some((right, bottom))]
        };
    }
    let mut ends = sides.into_iter().flatten();
    [ends.next().zip(ends.next()), None]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    fn draw(node: &Contours, terrain: &Heightfield) -> Texture {
        node.run(ContoursIn { terrain, onto: None }, &Job::detached()).unwrap().picture
    }

    fn crisp() -> Contours {
        Contours { width: 1.0, index_width: 1.0, colour: Colour::rgb(0), ..Contours::default() }
    }

    #[test]
    fn a_slope_has_a_line_at_each_interval() {
        // 10 m a column, one line every 5 columns, which runs through cell centres.
        let terrain = field(6, 16, |_, col| col as f64 * 10.0);
        let out = draw(&crisp(), &terrain);
        for col in 1..16 {
            let expected = if col % 5 == 0 { 0 } else { 255 };
            assert_eq!(out.at(3, col)[0], expected, "column {col}");
        }
    }

    #[test]
    fn a_cone_s_contours_are_circles() {
        let radius = |row: usize, col: usize| {
            let (y, x) = (row as f64 - 30.0, col as f64 - 30.0);
            (x * x + y * y).sqrt()
        };
        let terrain = field(61, 61, |row, col| 1000.0 - 10.0 * radius(row, col));
        let node = Contours { interval: 200.0, index_every: 0, ..crisp() };
        let out = draw(&node, &terrain);
        for i in 0..61 * 61 {
            let off = (radius(i / 61, i % 61) - 20.0).abs();
            let ink = 1.0 - f64::from(out.cells()[i][0]) / 255.0;
            // One circle of 20 cells, away from the top and the corners; chords of the squares stay within
            // 0.1 cells of it.
            if (2.0..30.0).contains(&radius(i / 61, i % 61)) {
                assert!((ink - (1.0 - off).max(0.0)).abs() < 0.1, "{i}: {ink} at {off}");
            }
        }
    }

    #[test]
    fn level_ground_on_a_line_stays_paper_and_index_lines_are_thicker() {
        let out = draw(&crisp(), &field(5, 5, |_, _| 100.0));
        assert!(out.cells().iter().all(|pixel| *pixel == PAPER));
        let node = Contours { index_every: 2, index_width: 3.0, ..crisp() };
        let out = draw(&node, &field(5, 30, |_, col| col as f64 * 5.0 + 1.0));
        let ink = |range: std::ops::Range<usize>| range.filter(|&col| out.at(2, col)[0] < 255).count();
        assert!(ink(15..25) > ink(5..15));
    }

    #[test]
    fn tiles_with_a_halo_equal_the_whole_and_voids_break_lines() {
        let job = Job::detached();
        let mut terrain = field(30, 30, |row, col| ((row * 37 + col * 91) % 50) as f64 * 9.0);
        terrain.cells_mut()[30 * 12 + 12] = f32::NAN;
        for node in [Contours::default(), Contours { width: 4.0, ..Contours::default() }] {
            let halo = node.halo(terrain.grid().cell);
            let whole = draw(&node, &terrain);
            let tile = draw(&node, &terrain.crop(8, 9, 12, 11, &job).unwrap());
            let inner = tile.crop(halo, halo, 12 - 2 * halo, 11 - 2 * halo, &job).unwrap();
            let same = whole.crop(8 + halo, 9 + halo, 12 - 2 * halo, 11 - 2 * halo, &job).unwrap();
            assert_eq!(inner.cells(), same.cells());
        }
        for size in [(0, 0), (1, 1), (1, 5)] {
            let out = draw(&crisp(), &field(size.0, size.1, |_, col| col as f64 * 1e9));
            assert_eq!(out.grid().size(), size);
        }
    }
}
