//! Pictures of any size. A large one comes into the window as a whole with cells left out, which is soon done; where one
//! looks closely, square by square in full, few in each frame, so that no frame waits for them.

use std::{collections::HashMap, sync::Arc};

use eframe::egui::{
    Color32, ColorImage, Context, Painter, Rect, TextureFilter, TextureHandle, TextureId, TextureOptions,
    Vec2, pos2, vec2,
};
use orograph_core::Texture;

/// Most cells on a side of the whole. So many are converted and handed over within a frame.
const WHOLE: usize = 2048;
/// Cells on a side of a square.
const SIDE: usize = 512;
/// Squares that a frame may make.
const A_FRAME: usize = 2;
/// Squares that are kept: a window of 4096 × 4096 pixels has as many at most, when it shows them at their size or larger.
const KEPT: usize = 81;

/// A picture in the window.
pub(super) struct Tiles {
    source: Arc<Texture>,
    name: String,
    whole: TextureHandle,
    /// Cells for one of the whole.
    step: usize,
    squares: HashMap<[usize; 2], Square>,
    frame: u64,
}

struct Square {
    handle: TextureHandle,
    seen: u64,
}

const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    ..TextureOptions::LINEAR
};

const ALL: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

impl Tiles {
    pub(super) fn new(ctx: &Context, name: &str, source: Arc<Texture>) -> Self {
        let most = ctx.input(|input| input.max_texture_side).min(WHOLE);
        let step = step(&source, most);
        let whole =
            ctx.load_texture(name, sampled(&source, [0, 0], [source.rows(), source.cols()], step), OPTIONS);
        Self { source, name: name.to_owned(), whole, step, squares: HashMap::new(), frame: 0 }
    }

    /// Its cells, to the right and down.
    pub(super) fn size(&self) -> Vec2 {
        vec2(self.source.cols() as f32, self.source.rows() as f32)
    }

    /// The whole as one texture.
    pub(super) fn whole(&self) -> TextureId {
        self.whole.id()
    }

    /// Paints it into `place`, of which the painter shows a part.
    pub(super) fn paint(&mut self, painter: &Painter, place: Rect) {
        painter.image(self.whole.id(), place, ALL, Color32::WHITE);
        let pixels = place.width() * painter.ctx().pixels_per_point() / self.size().x.max(1.0);
        // The whole shows as much, or its squares would be more than are worth it.
        if self.step == 1 || pixels * self.step as f32 <= 1.0 || pixels < 0.25 {
            return;
        }
        self.frame += 1;
        let mut made = 0;
        for (at, part) in self.seen(painter.clip_rect(), place) {
            if !self.squares.contains_key(&at) {
                if made == A_FRAME {
                    painter.ctx().request_repaint();
                    break;
                }
                made += 1;
                self.make(painter.ctx(), at);
            }
            let Some(square) = self.squares.get_mut(&at) else { continue };
            square.seen = self.frame;
            painter.image(square.handle.id(), part, ALL, Color32::WHITE);
        }
    }

    /// The squares within `clip` and where they lie, those in its middle first.
    fn seen(&self, clip: Rect, place: Rect) -> Vec<([usize; 2], Rect)> {
        let cell = place.size() / self.size().max(Vec2::splat(1.0));
        let seen = clip.intersect(place);
        let range = |from: f32, to: f32, cell: f32, cells: usize| {
            let at = |pos: f32| (pos / cell.max(1e-9)).max(0.0) as usize / SIDE;
            at(from)..=at(to).min(cells.saturating_sub(1) / SIDE)
        };
        let rows = range(seen.top() - place.top(), seen.bottom() - place.top(), cell.y, self.source.rows());
        let cols = range(seen.left() - place.left(), seen.right() - place.left(), cell.x, self.source.cols());
        let part = |[row, col]: [usize; 2]| {
            let (top, left) = (row * SIDE, col * SIDE);
            let bottom = (top + SIDE).min(self.source.rows());
            let right = (left + SIDE).min(self.source.cols());
            let pos = |col: usize, row: usize| place.min + vec2(col as f32, row as f32) * cell;
            Rect::from_min_max(pos(left, top), pos(right, bottom))
        };
        let all = rows.flat_map(|row| cols.clone().map(move |col| [row, col]));
        let mut all: Vec<_> =
            all.map(|at| (at, part(at))).filter(|(_, part)| part.intersects(seen)).collect();
        let distance = |part: &Rect| part.center().distance_sq(seen.center());
        all.sort_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
        all.truncate(KEPT);
        all
    }

    fn make(&mut self, ctx: &Context, at: [usize; 2]) {
        if self.squares.len() >= KEPT
            && let Some(oldest) =
                self.squares.iter().min_by_key(|(at, square)| (square.seen, **at)).map(|(at, _)| *at)
        {
            self.squares.remove(&oldest);
        }
        let [top, left] = at.map(|index| index * SIDE);
        let image = sampled(&self.source, [top, left], [top + SIDE, left + SIDE], 1);
        let handle = ctx.load_texture(format!("{} {top} {left}", self.name), image, OPTIONS);
        self.squares.insert(at, Square { handle, seen: self.frame });
    }
}

/// Cells for one so that no side has more than `most`.
pub(super) fn step(texture: &Texture, most: usize) -> usize {
    texture.rows().max(texture.cols()).div_ceil(most.max(1)).max(1)
}

/// Every `step`th cell of a part of a texture, as the window takes it.
pub(super) fn sampled(
    texture: &Texture,
    [top, left]: [usize; 2],
    [bottom, right]: [usize; 2],
    step: usize,
) -> ColorImage {
    let (bottom, right) = (bottom.min(texture.rows()), right.min(texture.cols()));
    let size = [(right - left).div_ceil(step), (bottom - top).div_ceil(step)];
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for row in (top..bottom).step_by(step) {
        let cells = texture.row(row)[left..right].iter().step_by(step);
        pixels.extend(cells.map(|[r, g, b, a]| Color32::from_rgba_unmultiplied(*r, *g, *b, *a)));
    }
    ColorImage::new(size, pixels)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::collections::BTreeMap;

    use eframe::egui::{RawInput, epaint::ImageData};
    use orograph_core::{CellSize, Grid};

    use super::*;

    /// A picture that has another colour in every cell.
    fn odd(rows: usize, cols: usize) -> Arc<Texture> {
        let cells = (0..rows * cols).map(|i| {
            let [a, b, c, _] = u32::try_from(i).unwrap().to_le_bytes();
            [a, b, c, 255]
        });
        Arc::new(
            Texture::new(Grid::new(rows, cols, CellSize::square(1.0)).unwrap(), cells.collect()).unwrap(),
        )
    }

    /// Paints a picture into `place` through a window of 1000 × 800; the images that came into it, by their size.
    fn frame(
        ctx: &Context,
        tiles: &mut Option<Tiles>,
        source: &Arc<Texture>,
        place: Rect,
    ) -> Vec<ColorImage> {
        let window = Rect::from_min_size(pos2(0.0, 0.0), vec2(1000.0, 800.0));
        let input =
            RawInput { screen_rect: Some(window), max_texture_side: Some(8192), ..RawInput::default() };
        let mut output = ctx.run_ui(input, |ui| {
            let tiles = tiles.get_or_insert_with(|| Tiles::new(ui.ctx(), "x", source.clone()));
            tiles.paint(&ui.painter_at(window), place);
        });
        // The letters' own texture comes with the first frame.
        let set = std::mem::take(&mut output.textures_delta.set);
        let pictures = set.into_iter().filter(|(id, _)| *id != TextureId::default());
        let images = pictures.flat_map(|(_, deltas)| deltas).map(|delta| {
            let ImageData::Color(image) = delta.image;
            (*image).clone()
        });
        images.collect()
    }

    #[test]
    fn a_small_picture_is_handed_over_once_with_every_cell() {
        let (ctx, source) = (Context::default(), odd(300, 400));
        let place = Rect::from_min_size(pos2(-5000.0, -5000.0), vec2(40000.0, 30000.0));
        let mut tiles = None;
        let images = frame(&ctx, &mut tiles, &source, place);
        assert_eq!(images, [sampled(&source, [0, 0], [300, 400], 1)]);
        assert!(frame(&ctx, &mut tiles, &source, place).is_empty());
    }

    #[test]
    fn of_a_large_picture_close_by_every_cell_in_view_comes_and_no_frame_brings_many() {
        let (ctx, source) = (Context::default(), odd(2300, 4100));
        let mut tiles = None;
        // From afar the whole is as fine as the window.
        let afar = Rect::from_min_size(pos2(0.0, 0.0), vec2(1000.0, 561.0));
        let images = frame(&ctx, &mut tiles, &source, afar);
        assert_eq!(images.iter().map(|image| image.size).collect::<Vec<_>>(), [[1367, 767]]);
        assert!(frame(&ctx, &mut tiles, &source, afar).is_empty());
        // Two pixels for a cell: the window shows 500 × 400 of them, here those from 3550 and 1900 on.
        let near = Rect::from_min_size(pos2(-7100.0, -3800.0), vec2(8200.0, 4600.0));
        let mut shown = BTreeMap::new();
        for _ in 0..10 {
            let images = frame(&ctx, &mut tiles, &source, near);
            assert!(images.len() <= A_FRAME);
            for image in images {
                assert!(image.size[0] <= SIDE && image.size[1] <= SIDE);
                for pixel in image.pixels {
                    let [a, b, c, _] = pixel.to_array();
                    let cell = u32::from_le_bytes([a, b, c, 0]) as usize;
                    assert!(shown.insert(cell, ()).is_none(), "no cell comes twice");
                }
            }
        }
        for (row, col) in (1900..2300).flat_map(|row| (3550..4050).map(move |col| (row, col))) {
            assert!(shown.contains_key(&(row * 4100 + col)), "{row} {col}");
        }
        assert!(shown.len() <= 6 * SIDE * SIDE, "and little besides");
        assert_eq!(tiles.unwrap().seen(Rect::EVERYTHING, near).len(), 5 * 9);
    }
}
