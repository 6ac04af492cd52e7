//! Perspective view: a block of terrain as seen from beside and above.
//!
//! Every square of neighbouring cells is two triangles, projected through a pinhole and drawn with a depth buffer. The
//! picture is drawn larger and averaged down, which smooths edges. Where cells are finer than pixels, every k-th row
//! and column stand for all: what is drawn is a view, not data.

mod camera;
mod paint;

use glam::DVec3;
use orograph_core::prelude::*;
use rayon::prelude::*;

use self::{
    camera::Camera,
    paint::{Corner, Painter, Scene},
};
use super::{
    colour::{self, Tint},
    hillshade::{Light, Sun},
};

/// How many pixels each pixel of the picture is drawn as, along either side.
const SAMPLES: usize = 2;
/// The cut sides of the block, and bare ground without a picture on it.
const EARTH: Tint = [112, 98, 86, 255];
const STONE: Tint = [216, 208, 194, 255];

/// Shows terrain in three dimensions, as a block seen from beside and above.
///
/// The whole block is in view. Without a picture to lay over it the ground is shaded stone; connect the picture of
/// `look.colour_relief` or `look.hillshade`, or any texture on the terrain's grid. Voids are holes.
#[derive(Params, Clone, Debug)]
pub struct Perspective {
    /// Compass direction in which the viewer looks: at 0 from the south towards the north.
    #[param(default = 25, range = 0.0..=360.0, unit = "deg")]
    pub azimuth: f64,
    /// How steeply the viewer looks down: 90 is a map.
    #[param(default = 35, range = 1.0..=90.0, slider = 10.0..=90.0, unit = "deg")]
    pub tilt: f64,
    /// Angle of view: small as through a telescope, large as from close by.
    #[param(default = 35, range = 1.0..=120.0, slider = 5.0..=90.0, unit = "deg")]
    pub field_of_view: f64,
    /// Factor on heights.
    #[param(default = 1.5, range = 0.01..=1000.0, slider = 0.5..=5.0, unit = "1")]
    pub exaggeration: f64,
    /// Width of the picture.
    #[param(default = 1200u32, range = 16..=8192, slider = 400..=2400, unit = "px")]
    pub width: u32,
    /// Height of the picture.
    #[param(default = 800u32, range = 16..=8192, slider = 300..=1600, unit = "px")]
    pub height: u32,
    /// Colour behind the block, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xdf_e6ee))]
    pub background: Colour,
}

/// Inputs of [`Perspective`].
#[derive(Inputs)]
pub struct PerspectiveIn<'a> {
    /// Terrain to show.
    pub terrain: &'a Heightfield,
    /// Picture to lay over it, on the terrain's grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`Perspective`].
#[derive(Outputs)]
pub struct PerspectiveOut {
    /// The view; it has no place in the world.
    pub picture: Texture,
}

impl Node for Perspective {
    const ID: &'static str = "look.perspective";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = PerspectiveIn<'a>;
    type Outputs = PerspectiveOut;

    fn cost(&self) -> f64 {
        20.0
    }

    fn run(&self, inputs: PerspectiveIn<'_>, job: &Job) -> Result<PerspectiveOut> {
        let PerspectiveIn { terrain, onto } = inputs;
        if let Some(onto) = onto {
            terrain.grid().match_size("terrain", onto.grid(), "onto")?;
        }
        let background = self.background.0;
        let (width, height) = (self.width as usize, self.height as usize);
        let block = Block::new(terrain, onto, self.exaggeration, width.max(height), job)?;
        let large = (width * SAMPLES, height * SAMPLES);
        let mut painter = Painter::new(large, background, job)?;
        if let Some(bounds) = block.bounds() {
            let camera = Camera::around(
                bounds,
                [self.azimuth, self.tilt, self.field_of_view].map(f64::to_radians),
                large,
            );
            block.paint(&camera, &mut painter, job)?;
        }
        Ok(PerspectiveOut { picture: painter.averaged(SAMPLES, job)? })
    }
}

/// The terrain as a lattice of coloured points.
struct Block {
    rows: usize,
    cols: usize,
    /// Row by row; `None` at voids.
    points: Vec<Option<(DVec3, Tint)>>,
}

impl Block {
    /// Takes every k-th row and column such that neither side has more than about `most`; the last ones are kept.
    fn new(
        terrain: &Heightfield,
        onto: Option<&Texture>,
        exaggeration: f64,
        most: usize,
        job: &Job,
    ) -> Result<Self> {
        let grid = terrain.grid();
        if grid.is_empty() {
            return Err(Error::EmptyInput { what: "terrain".into() });
        }
        let step = grid.rows.max(grid.cols).div_ceil(most).max(1);
        let picked = |n: usize| -> Vec<usize> {
            (0..n).step_by(step).chain((n > 1 && !(n - 1).is_multiple_of(step)).then_some(n - 1)).collect()
        };
        let (rows, cols) = (picked(grid.rows), picked(grid.cols));
        job.admit((rows.len() * cols.len() * size_of::<Option<(DVec3, Tint)>>()) as u64, || {
            "the points of the view".into()
        })?;
        let sun = Sun::new(315.0, 45.0, Light::Multidirectional);
        let mut points = vec![None; rows.len() * cols.len()];
        points.par_chunks_mut(cols.len()).zip(&rows).try_for_each(|(points, &row)| {
            job.check()?;
            let mut shaded = Vec::new();
            if onto.is_none() {
                shaded.resize(grid.cols, STONE);
                sun.brightnesses(terrain, row, exaggeration, |start, bright| {
                    for (pixel, &bright) in shaded[start..].iter_mut().zip(bright) {
                        *pixel = colour::shade(STONE, sun.relative(bright, 1.0));
                    }
                });
            }
            let colours = onto.map_or(&shaded[..], |onto| onto.row(row));
            for (point, &col) in points.iter_mut().zip(&cols) {
                let z = f64::from(terrain.at(row, col)) * exaggeration;
                let at = DVec3::new(col as f64 * grid.cell.x, -(row as f64) * grid.cell.y, z);
                *point = z.is_finite().then_some((at, colours[col]));
            }
            Ok(())
        })?;
        Ok(Self { rows: rows.len(), cols: cols.len(), points })
    }

    /// Opposite corners of the box around the block and its base; `None` without a known height.
    fn bounds(&self) -> Option<[DVec3; 2]> {
        let of_row = |row: &[Option<(DVec3, Tint)>]| {
            let known = row.iter().flatten().map(|point| (point.0, point.0));
            known.reduce(|(low, high), at| (low.min(at.0), high.max(at.1)))
        };
        let rows: Vec<_> = self.points.par_chunks(self.cols.max(1)).filter_map(of_row).collect();
        let (low, high) = rows.into_iter().reduce(|(low, high), row| (low.min(row.0), high.max(row.1)))?;
        let depth = 0.04 * (high - low).truncate().max_element();
        Some([low - DVec3::Z * depth, high])
    }

    fn paint(&self, camera: &Camera, painter: &mut Painter, job: &Job) -> Result<()> {
        let see = |point: &Option<(DVec3, Tint)>| point.and_then(|(at, colour)| camera.see(at, colour));
        let corners = self.points.par_iter().map(see).collect();
        let scene = Scene { corners, cols: self.cols, sides: self.cut_sides(camera) };
        painter.paint(&scene, job)
    }

    /// The four sides, from the ground down to the base.
    fn cut_sides(&self, camera: &Camera) -> Vec<[Corner; 3]> {
        let mut triangles = Vec::new();
        let Some([low, _]) = self.bounds() else { return triangles };
        let (last_row, last_col) = (self.rows - 1, self.cols - 1);
        let north_and_south = [(0, 0.8), (last_row, 0.9)]
            .map(|(row, bright)| ((0..self.cols).map(move |col| (row, col)).collect(), bright));
        let west_and_east = [(0, 1.0), (last_col, 0.7)]
            .map(|(col, bright)| ((0..self.rows).map(move |row| (row, col)).collect(), bright));
        for (side, bright) in north_and_south.into_iter().chain(west_and_east) {
            let side: Vec<(usize, usize)> = side;
            let colour = colour::shade(EARTH, bright);
            let edge = |&(row, col): &(usize, usize)| {
                let (top, _) = self.points[row * self.cols + col]?;
                Some([camera.see(top, colour)?, camera.see(DVec3 { z: low.z, ..top }, colour)?])
            };
            for pair in side.windows(2) {
                if let (Some([a, below_a]), Some([b, below_b])) = (edge(&pair[0]), edge(&pair[1])) {
                    triangles.extend([[a, b, below_a], [b, below_b, below_a]]);
                }
            }
        }
        triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    const RED: Tint = [200, 0, 0, 255];
    const BLUE: Tint = [0, 0, 200, 255];

    fn view(node: &Perspective, terrain: &Heightfield, colour: impl Fn(usize, usize) -> Tint) -> Texture {
        let cols = terrain.cols();
        let cells = (0..terrain.cells().len()).map(|i| colour(i / cols, i % cols)).collect();
        let onto = Texture::new(terrain.grid().clone(), cells).unwrap();
        node.run(PerspectiveIn { terrain, onto: Some(&onto) }, &Job::detached()).unwrap().picture
    }

    fn node() -> Perspective {
        Perspective { azimuth: 0.0, width: 200, height: 160, exaggeration: 1.0, ..Perspective::default() }
    }

    fn count(picture: &Texture, colour: Tint) -> usize {
        picture.cells().iter().filter(|&&pixel| pixel == colour).count()
    }

    #[test]
    fn from_straight_above_it_is_a_map_with_north_at_the_top() {
        let map = Perspective { tilt: 90.0, ..node() };
        let flat = field(40, 40, |_, _| 100.0);
        let picture = view(&map, &flat, |row, col| if row < 20 && col < 20 { RED } else { BLUE });
        // The square map stands in the middle of a wider picture.
        assert_eq!(picture.at(50, 70), RED);
        assert_eq!([picture.at(50, 130), picture.at(110, 70), picture.at(110, 130)], [BLUE; 3]);
        assert_eq!(picture.at(80, 3), map.background.0);
        let turned = Perspective { azimuth: 90.0, ..map };
        // Looking east, what lies in the north-west is down on the left.
        let picture = view(&turned, &flat, |row, col| if row < 20 && col < 20 { RED } else { BLUE });
        assert_eq!(picture.at(110, 70), RED);
        assert_eq!(picture.at(50, 70), BLUE);
    }

    #[test]
    fn a_wall_hides_what_lies_behind_it() {
        let low = Perspective { tilt: 25.0, ..node() };
        let strip = |row: usize, _: usize| if (8..12).contains(&row) { RED } else { BLUE };
        let open = view(&low, &field(40, 40, |_, _| 0.0), strip);
        let walled = view(&low, &field(40, 40, |row, _| if row == 20 { 200.0 } else { 0.0 }), strip);
        assert!(count(&open, RED) > 50);
        assert_eq!(count(&walled, RED), 0);
        // From the other side the wall stands behind the strip.
        let behind = Perspective { azimuth: 180.0, ..low };
        assert!(
            count(&view(&behind, &field(40, 40, |row, _| if row == 20 { 200.0 } else { 0.0 }), strip), RED)
                > 20
        );
    }

    #[test]
    fn the_whole_block_is_in_view_from_everywhere() {
        let hill = field(60, 30, |row, col| 3.0 * ((row * 7 + col * 3) % 40) as f64);
        let background = node().background.0;
        for azimuth in [0.0, 40.0, 133.0, 290.0] {
            for tilt in [1.0, 30.0, 75.0, 90.0] {
                for field_of_view in [1.0, 35.0, 120.0] {
                    let node = Perspective { azimuth, tilt, field_of_view, ..node() };
                    let picture = view(&node, &hill, |_, _| RED);
                    let (rows, cols) = picture.grid().size();
                    let rim = (0..cols).flat_map(|col| [(0, col), (rows - 1, col)]);
                    let rim = rim.chain((0..rows).flat_map(|row| [(row, 0), (row, cols - 1)]));
                    assert!(rim.into_iter().all(|(row, col)| picture.at(row, col) == background));
                    assert!(count(&picture, background) < rows * cols, "nothing seen from {azimuth}, {tilt}");
                }
            }
        }
    }

    #[test]
    fn voids_are_holes_and_odd_terrain_is_met() {
        let background = node().background.0;
        let nothing = view(&node(), &field(10, 10, |_, _| f64::NAN), |_, _| RED);
        assert_eq!(count(&nothing, background), 200 * 160);
        let map = Perspective { tilt: 90.0, ..node() };
        let holed =
            view(&map, &field(9, 9, |row, col| if (row, col) == (4, 4) { f64::NAN } else { 1.0 }), |_, _| {
                RED
            });
        assert_eq!(holed.at(80, 100), background);
        let void = row_of(&[1.0]);
        for terrain in [void, row_of(&[1.0, 2.0, f32::INFINITY])] {
            assert!(node().run(PerspectiveIn { terrain: &terrain, onto: None }, &Job::detached()).is_ok());
        }
    }

    fn row_of(heights: &[f32]) -> Heightfield {
        crate::test_fields::row(heights)
    }
}
