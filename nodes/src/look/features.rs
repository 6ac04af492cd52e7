//! Features: ridges or valleys drawn over a picture, with their branch points, ends, rings and placement order.

use glam::DVec2;
use orograph_core::{FeatureKind, PointKind, prelude::*};

use super::{
    canvas::{Anchor, Canvas, Type},
    colour::{INK, PAPER, Palette, Tint},
};
use crate::{
    PatchSize,
    feature::plan::{Item, ItemKind, Order, plan},
};

/// How the placement order is shown.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Not at all.
    Nothing,
    /// A dot on each patch, coloured from the first to the last.
    Colours,
    /// The same with the number of each patch.
    Numbers,
    /// The same with the outline of each patch.
    Patches,
}

/// Draws ridges or valleys over a picture, or on white paper.
#[derive(Params, Clone, Debug)]
pub struct Features {
    /// Colour of ridges, `#rrggbb` or `#rrggbbaa`.
    #[param(default = Colour::rgb(0xc8_321e))]
    pub ridge_colour: Colour,
    /// Colour of valleys.
    #[param(default = Colour::rgb(0x1e_5ac8))]
    pub valley_colour: Colour,
    /// Colour of branch points.
    #[param(default = Colour::rgb(0xff_b400))]
    pub branch_colour: Colour,
    /// Colour of ends.
    #[param(default = Colour::rgb(0xff_ffff))]
    pub end_colour: Colour,
    /// Thickness of lines; 0 draws none.
    #[param(default = 2, range = 0.0..=32.0, slider = 0.0..=8.0, unit = "px")]
    pub width: f64,
    /// Radius of branch points and ends; 0 draws none.
    #[param(default = 3, range = 0.0..=64.0, slider = 0.0..=12.0, unit = "px")]
    pub point_radius: f64,
    /// What is shown of the order in which patches are placed.
    #[param(default = Show::Nothing)]
    pub show: Show,
    /// That order.
    #[param(default = Order::TreeBfs)]
    pub order: Order,
    /// Those patches.
    #[param(flatten)]
    pub patches: PatchSize,
    /// Colours from the first patch to the last.
    #[param(default = Palette::Viridis)]
    pub palette: Palette,
}

/// Inputs of [`Features`].
#[derive(Inputs)]
pub struct FeaturesIn<'a> {
    /// The lines to draw.
    pub features: &'a orograph_core::Features,
    /// Picture to draw over, of the size of the features' grid.
    pub onto: Option<&'a Texture>,
}

/// Outputs of [`Features`].
#[derive(Outputs)]
pub struct FeaturesOut {
    /// The picture with the lines.
    pub picture: Texture,
}

impl Node for Features {
    const ID: &'static str = "look.features";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FeaturesIn<'a>;
    type Outputs = FeaturesOut;

    fn check(&self) -> Result<()> {
        self.inks().map(|_| ())
    }

    fn cost(&self) -> f64 {
        2.0
    }

    fn run(&self, inputs: FeaturesIn<'_>, job: &Job) -> Result<FeaturesOut> {
        let FeaturesIn { features, onto } = inputs;
        let mut canvas = Canvas::on(features.grid.clone(), PAPER, job)?;
        if let Some(onto) = onto {
            features.grid.match_size("features", onto.grid(), "onto")?;
            canvas.paste(onto, 0, 0);
        }
        job.check()?;
        let items = match self.show {
            Show::Nothing => Vec::new(),
            _ => plan(features, f64::from(self.patches.patch), self.order, job)?,
        };
        if self.show == Show::Patches {
            self.outline(&mut canvas, &items, job)?;
        }
        self.lines(&mut canvas, features, job)?;
        self.number(&mut canvas, &items, job)?;
        Ok(FeaturesOut { picture: canvas.into_picture() })
    }
}

/// Colours of the lines of each kind and of the points.
struct Inks {
    ridge: Tint,
    valley: Tint,
    branch: Tint,
    end: Tint,
}

/// A place (row, column) on the canvas.
fn spot(place: [f64; 2]) -> DVec2 {
    DVec2::new(place[1], place[0])
}

impl Features {
    fn inks(&self) -> Result<Inks> {
        Ok(Inks {
            ridge: self.ridge_colour.0,
            valley: self.valley_colour.0,
            branch: self.branch_colour.0,
            end: self.end_colour.0,
        })
    }

    fn lines(&self, canvas: &mut Canvas, features: &orograph_core::Features, job: &Job) -> Result<()> {
        let inks = self.inks()?;
        let ink = if features.kind == FeatureKind::Ridge { inks.ridge } else { inks.valley };
        if self.width > 0.0 {
            for line in &features.lines {
                job.check()?;
                for pair in line.vertices.windows(2) {
                    canvas.line(spot(pair[0]), spot(pair[1]), self.width, ink);
                }
            }
            for [a, b] in &features.rings {
                let at = |point: &u32| features.points.get(*point as usize);
                if let (Some(a), Some(b)) = (at(a), at(b)) {
                    canvas.line(spot([a.row, a.col]), spot([b.row, b.col]), self.width / 2.0, ink);
                }
            }
        }
        if self.point_radius > 0.0 {
            for (n, point) in features.points.iter().enumerate() {
                if n.is_multiple_of(1024) {
                    job.check()?;
                }
                let fill = match point.kind {
                    PointKind::Branch => inks.branch,
                    PointKind::End => inks.end,
                    PointKind::Path => continue,
                };
                let at = spot([point.row, point.col]);
                disc(canvas, at, self.point_radius + 1.0, INK);
                disc(canvas, at, self.point_radius, fill);
            }
        }
        Ok(())
    }

    /// How far along the plan an item comes, as a colour.
    fn tint(&self, i: usize, n: usize) -> Tint {
        self.palette.at(i as f64 / (n.max(2) - 1) as f64)
    }

    fn outline(&self, canvas: &mut Canvas, items: &[Item], job: &Job) -> Result<()> {
        for (i, item) in items.iter().enumerate() {
            job.check()?;
            let corner = |k: usize| (item.centre[k] - f64::from(self.patches.patch / 2)).round() as i64;
            let side = i64::from(self.patches.patch);
            canvas.frame(corner(1), corner(0), side, side, self.tint(i, items.len()));
        }
        Ok(())
    }

    fn number(&self, canvas: &mut Canvas, items: &[Item], job: &Job) -> Result<()> {
        let face = Type::plain(1);
        for (i, item) in items.iter().enumerate() {
            job.check()?;
            let at = spot(item.centre);
            let radius = self.point_radius.max(3.0) + if item.kind == ItemKind::Branch { 2.0 } else { 0.0 };
            disc(canvas, at, radius + 1.0, INK);
            disc(canvas, at, radius, self.tint(i, items.len()));
            if self.show == Show::Numbers && on_picture(at) {
                let (x, y) = ((at.x + radius) as i64 + 3, at.y as i64);
                let text = (i + 1).to_string();
                canvas.fill(x - 1, y - 6, face.width(&text) + 2, 12, [255, 255, 255, 190]);
                canvas.text(&text, x, y, Anchor::Left, face, INK);
            }
        }
        Ok(())
    }
}

/// Places that a picture could hold at all; damaged features may lie anywhere.
fn on_picture(at: DVec2) -> bool {
    at.is_finite() && at.abs().max_element() < 1e9
}

fn disc(canvas: &mut Canvas, at: DVec2, radius: f64, colour: Tint) {
    if on_picture(at) {
        canvas.disc(at, radius, colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use orograph_core::{FeaturePoint, Polyline};

    fn fork() -> orograph_core::Features {
        let places = [[50.0, 50.0], [50.0, 90.0], [10.0, 20.0], [90.0, 20.0]];
        let point = |(i, &[row, col]): (usize, &[f64; 2])| {
            let kind = if i == 0 { PointKind::Branch } else { PointKind::End };
            FeaturePoint { row, col, height: 1.0, kind }
        };
        let line = |to: u32| Polyline {
            from: 0,
            to,
            vertices: vec![places[0], places[to as usize]],
            profiles: Vec::new(),
        };
        orograph_core::Features {
            grid: Grid::new(100, 100, CellSize::square(1.0)).unwrap(),
            kind: FeatureKind::Ridge,
            points: places.iter().enumerate().map(point).collect(),
            lines: (1..4).map(line).collect(),
            rings: vec![[1, 2]],
            scale: 1.0,
            profile_len: 0,
            profile_step: 0.0,
        }
    }

    fn draw(node: &Features, features: &orograph_core::Features) -> Texture {
        node.run(FeaturesIn { features, onto: None }, &Job::detached()).unwrap().picture
    }

    #[test]
    fn lines_and_points_have_their_colours() {
        let picture = draw(&Features::default(), &fork());
        assert_eq!(picture.at(50, 70), [0xc8, 0x32, 0x1e, 255]);
        assert_eq!(picture.at(50, 50), [0xff, 0xb4, 0x00, 255]);
        assert_eq!(picture.at(10, 20), [255; 4]);
        assert_eq!(picture.at(95, 95), PAPER);
        let valleys = orograph_core::Features { kind: FeatureKind::Valley, ..fork() };
        assert_eq!(draw(&Features::default(), &valleys).at(50, 70), [0x1e, 0x5a, 0xc8, 255]);
    }

    #[test]
    fn the_order_is_drawn_from_the_first_colour_on() {
        for show in [Show::Colours, Show::Numbers, Show::Patches] {
            let picture =
                draw(&Features { show, patches: PatchSize { patch: 40 }, ..Features::default() }, &fork());
            assert_eq!(picture.at(50, 50), Palette::Viridis.at(0.0), "{show:?}");
        }
    }

    #[test]
    fn damaged_features_are_drawn_as_far_as_they_go() {
        let mut features = fork();
        features.points[1].row = f64::NAN;
        features.points[2].col = 1e300;
        features.lines[0].vertices[1] = [f64::INFINITY, 0.0];
        features.rings.push([0, 99]);
        draw(&Features::default(), &features);
        let node = Features { show: Show::Numbers, ..Features::default() };
        assert!(node.run(FeaturesIn { features: &features, onto: None }, &Job::detached()).is_err());
    }
}
