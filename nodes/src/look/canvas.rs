//! A picture to draw on: text in bitmap fonts, anti-aliased lines and dots, other pictures.
//!
//! Positions are (x, y) in pixels, x right, y down; whole numbers are pixel centres. Everything is clipped.
//! Bitmap fonts and coverage by distance need only additions and square roots, so a picture has the same
//! bits everywhere.

use embedded_graphics::{
    Drawable, Pixel,
    draw_target::DrawTarget,
    geometry::{OriginDimensions, Point, Size},
    mono_font::{MonoFont, MonoTextStyle, iso_8859_1 as fonts},
    pixelcolor::BinaryColor,
    text::{Baseline, Text},
};
use glam::DVec2;
use orograph_core::prelude::*;

use super::colour::{Tint, blend};

/// Size and weight of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Type {
    /// Heavier strokes, for titles.
    pub bold: bool,
    /// Whole enlargement, for large pictures.
    pub scale: u32,
}

impl Type {
    /// Plain text, enlarged `scale` times.
    #[must_use]
    pub const fn plain(scale: u32) -> Self {
        Self { bold: false, scale }
    }

    /// Bold text, enlarged `scale` times.
    #[must_use]
    pub const fn bold(scale: u32) -> Self {
        Self { bold: true, scale }
    }

    fn font(self) -> &'static MonoFont<'static> {
        if self.bold { &fonts::FONT_8X13_BOLD } else { &fonts::FONT_7X13 }
    }

    /// Width of a text in pixels.
    #[must_use]
    pub fn width(self, text: &str) -> i64 {
        let letter = i64::from(self.font().character_size.width * self.scale);
        i64::try_from(text.chars().count()).unwrap_or(0).saturating_mul(letter)
    }

    /// Height of a line in pixels.
    #[must_use]
    pub fn height(self) -> i64 {
        i64::from(self.font().character_size.height * self.scale)
    }

    /// As much of a text's beginning as fits into `width` pixels.
    #[must_use]
    pub fn fit(self, text: &str, width: i64) -> &str {
        let letter = i64::from(self.font().character_size.width * self.scale);
        let letters = usize::try_from(width / letter).unwrap_or(0);
        text.char_indices().nth(letters).map_or(text, |(end, _)| &text[..end])
    }
}

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The point is its left end.
    Left,
    /// The point is its middle.
    Middle,
    /// The point is its right end.
    Right,
}

/// A picture being drawn.
#[derive(Debug)]
pub struct Canvas {
    picture: Texture,
}

impl Canvas {
    /// A canvas of one colour without a place in the world.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory.
    pub fn new(width: i64, height: i64, colour: Tint, job: &Job) -> Result<Self> {
        let side = |pixels: i64| usize::try_from(pixels).unwrap_or(0);
        let grid = Grid::new(side(height), side(width), CellSize::square(1.0))?;
        Self::on(grid, colour, job)
    }

    /// A canvas of one colour that lies on `grid`.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when `job` does not admit the memory.
    pub fn on(grid: Grid, colour: Tint, job: &Job) -> Result<Self> {
        Ok(Self { picture: Texture::filled(grid, colour, job)? })
    }

    /// The finished picture.
    #[must_use]
    pub fn into_picture(self) -> Texture {
        self.picture
    }

    /// Blends a colour into one pixel.
    pub fn dot(&mut self, x: i64, y: i64, colour: Tint, share: f64) {
        let (rows, cols) = self.picture.grid().size();
        if let (Ok(row), Ok(col)) = (usize::try_from(y), usize::try_from(x))
            && row < rows
            && col < cols
        {
            let pixel = &mut self.picture.cells_mut()[row * cols + col];
            *pixel = blend(*pixel, colour, share);
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Tint) {
        let (rows, cols) = self.picture.grid().size();
        let clip = |start: i64, n: i64, all: usize| {
            let all = i64::try_from(all).unwrap_or(i64::MAX);
            start.clamp(0, all)..start.saturating_add(n).clamp(0, all)
        };
        for row in clip(y, height, rows) {
            for col in clip(x, width, cols) {
                self.dot(col, row, colour, 1.0);
            }
        }
    }

    /// Outlines a rectangle with a line of one pixel inside it.
    pub fn frame(&mut self, x: i64, y: i64, width: i64, height: i64, colour: Tint) {
        self.fill(x, y, width, 1, colour);
        self.fill(x, y + height - 1, width, 1, colour);
        self.fill(x, y + 1, 1, height - 2, colour);
        self.fill(x + width - 1, y + 1, 1, height - 2, colour);
    }

    /// Lays another picture on this one with its first pixel at (x, y).
    pub fn paste(&mut self, picture: &Texture, x: i64, y: i64) {
        for row in 0..picture.rows() {
            for (col, &colour) in picture.row(row).iter().enumerate() {
                self.dot(x + col as i64, y + row as i64, colour, 1.0);
            }
        }
    }

    /// Draws an anti-aliased disc.
    pub fn disc(&mut self, centre: DVec2, radius: f64, colour: Tint) {
        let reach = radius + 1.0;
        for y in (centre.y - reach).floor() as i64..=(centre.y + reach).ceil() as i64 {
            for x in (centre.x - reach).floor() as i64..=(centre.x + reach).ceil() as i64 {
                let far = DVec2::new(x as f64, y as f64).distance(centre);
                self.dot(x, y, colour, (radius + 0.5 - far).clamp(0.0, 1.0));
            }
        }
    }

    /// Draws an anti-aliased line with round ends.
    pub fn line(&mut self, a: DVec2, b: DVec2, width: f64, colour: Tint) {
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        let (rows, cols) = self.picture.grid().size();
        let reach = width / 2.0 + 1.0;
        let along = b - a;
        // The line is followed along its longer axis; across it only its own breadth is visited.
        let steep = along.y.abs() > along.x.abs();
        let swap = |v: DVec2| if steep { DVec2::new(v.y, v.x) } else { v };
        let (p, q) = (swap(a), swap(b));
        let (p, q) = if p.x <= q.x { (p, q) } else { (q, p) };
        let limit = if steep { rows } else { cols } as f64;
        let rise = if q.x > p.x { (q.y - p.y) / (q.x - p.x) } else { 0.0 };
        // A diagonal's breadth across one axis is its width times the square root of two at most.
        let breadth = reach * std::f64::consts::SQRT_2;
        let (first, last) = ((p.x - reach).floor().max(0.0), (q.x + reach).ceil().min(limit));
        for major in first as i64..=last as i64 {
            let middle = p.y + rise * ((major as f64).clamp(p.x, q.x) - p.x);
            for minor in (middle - breadth).floor() as i64..=(middle + breadth).ceil() as i64 {
                let at = DVec2::new(major as f64, minor as f64);
                let far = distance_to_segment(at, p, q);
                let share = (width / 2.0 + 0.5 - far).clamp(0.0, 1.0);
                if share > 0.0 {
                    let (x, y) = if steep { (minor, major) } else { (major, minor) };
                    self.dot(x, y, colour, share);
                }
            }
        }
    }

    /// Writes a line of text whose vertical middle is at `y`.
    pub fn text(&mut self, text: &str, x: i64, y: i64, anchor: Anchor, face: Type, colour: Tint) {
        let x = x - shift(text, anchor, face);
        self.write(text, face, colour, move |dx, dy| (x + dx, y - face.height() / 2 + dy));
    }

    /// Writes a text that reads upwards; `x` is the middle of its line, `y` its middle.
    pub fn text_upwards(&mut self, text: &str, x: i64, y: i64, face: Type, colour: Tint) {
        let start = y + shift(text, Anchor::Middle, face);
        self.write(text, face, colour, move |dx, dy| (x - face.height() / 2 + dy, start - dx));
    }

    fn write(&mut self, text: &str, face: Type, colour: Tint, place: impl Fn(i64, i64) -> (i64, i64)) {
        let mut glyphs = Glyphs { canvas: self, colour, scale: i64::from(face.scale), place };
        let style = MonoTextStyle::new(face.font(), BinaryColor::On);
        // Drawing on a canvas never fails: its error type has no value.
        let Ok(_) = Text::with_baseline(text, Point::zero(), style, Baseline::Top).draw(&mut glyphs);
    }
}

fn shift(text: &str, anchor: Anchor, face: Type) -> i64 {
    match anchor {
        Anchor::Left => 0,
        Anchor::Middle => face.width(text) / 2,
        Anchor::Right => face.width(text),
    }
}

/// Distance from a point to a segment; a segment of no length is a point.
#[must_use]
pub fn distance_to_segment(at: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    let t = if square > 0.0 { ((at - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    at.distance(a + along * t)
}

/// Takes a font's pixels, enlarges them and puts them where `place` says.
struct Glyphs<'a, F> {
    canvas: &'a mut Canvas,
    colour: Tint,
    scale: i64,
    place: F,
}

impl<F: Fn(i64, i64) -> (i64, i64)> DrawTarget for Glyphs<'_, F> {
    type Color = BinaryColor;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        for Pixel(point, on) in pixels {
            if on.is_off() {
                continue;
            }
            for i in 0..self.scale * self.scale {
                let dx = i64::from(point.x) * self.scale + i % self.scale;
                let dy = i64::from(point.y) * self.scale + i / self.scale;
                let (x, y) = (self.place)(dx, dy);
                self.canvas.dot(x, y, self.colour, 1.0);
            }
        }
        Ok(())
    }
}

impl<F> OriginDimensions for Glyphs<'_, F> {
    fn size(&self) -> Size {
        Size::new(u32::MAX, u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Tint = [0, 0, 0, 255];
    const WHITE: Tint = [255; 4];

    fn canvas() -> Canvas {
        Canvas::new(20, 10, WHITE, &Job::detached()).unwrap()
    }

    #[test]
    fn a_line_covers_its_length_times_its_width() {
        for (a, b) in [((3.0, 5.0), (15.0, 5.0)), ((4.0, 2.0), (10.0, 8.0)), ((5.0, 1.0), (6.0, 8.0))] {
            let (a, b) = (DVec2::from(a), DVec2::from(b));
            let mut canvas = canvas();
            canvas.line(a, b, 2.0, BLACK);
            let ink: f64 = canvas.picture.cells().iter().map(|pixel| 1.0 - f64::from(pixel[0]) / 255.0).sum();
            // Two half discs at the ends.
            let area = 2.0 * a.distance(b) + std::f64::consts::PI;
            assert!((ink - area).abs() < 0.08 * area, "{ink} for {area}");
        }
    }

    #[test]
    fn drawing_outside_is_clipped() {
        let mut canvas = canvas();
        canvas.line(DVec2::new(-1e9, 3.0), DVec2::new(1e9, 3.0), 1.0, BLACK);
        canvas.line(DVec2::new(f64::NAN, 3.0), DVec2::new(1.0, 3.0), 1.0, BLACK);
        canvas.fill(-5, -5, i64::MAX, 7, BLACK);
        canvas.text("far away", 15, 9, Anchor::Left, Type::bold(1), BLACK);
        assert_eq!(canvas.picture.at(1, 0), BLACK);
        assert_eq!(canvas.picture.at(3, 10), BLACK);
        assert_eq!(canvas.picture.at(2, 3), WHITE);
    }

    #[test]
    fn text_upwards_is_text_turned() {
        let job = Job::detached();
        let mut across = Canvas::new(61, 61, WHITE, &job).unwrap();
        let mut upwards = Canvas::new(61, 61, WHITE, &job).unwrap();
        across.text("Agy", 30, 30, Anchor::Middle, Type::plain(1), BLACK);
        upwards.text_upwards("Agy", 30, 30, Type::plain(1), BLACK);
        assert!(across.picture.cells().contains(&BLACK));
        for i in 0..61 * 61 {
            let (row, col) = (i / 61, i % 61);
            assert_eq!(across.picture.at(row, col), upwards.picture.at(60 - col, row));
        }
    }
}
