//! Where one looks at a picture, told so that it holds for pictures of other sizes and in other panes.

use eframe::egui::{Pos2, Rect, Vec2, vec2};

/// Least and most pixels of the window for one of a picture.
const PIXELS: (f32, f32) = (0.02, 64.0);

/// A place in a picture and how much it is enlarged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// What stands in the middle, as shares of the picture.
    centre: Vec2,
    /// How often larger than where all of the picture is seen.
    zoom: f32,
}

impl Default for View {
    fn default() -> Self {
        Self { centre: Vec2::splat(0.5), zoom: 1.0 }
    }
}

impl View {
    /// Where a picture of `size` cells lies that is looked at through `rect`.
    pub(super) fn place(self, rect: Rect, size: Vec2) -> Rect {
        let shown = size * fit(rect, size) * self.zoom;
        Rect::from_min_size(rect.center() - self.centre * shown, shown)
    }

    /// Moves the picture by so many pixels of the window; some of it stays in the middle.
    pub(super) fn pan(&mut self, by: Vec2, rect: Rect, size: Vec2) {
        let shown = self.place(rect, size).size().max(Vec2::splat(1.0));
        self.centre = (self.centre - by / shown).clamp(Vec2::ZERO, Vec2::splat(1.0));
    }

    /// Enlarges by a factor; what stands at `pos` stays there.
    pub(super) fn enlarge(&mut self, factor: f32, pos: Pos2, rect: Rect, size: Vec2) {
        let fit = fit(rect, size);
        let under = share(self.place(rect, size), pos);
        self.zoom = (self.zoom * factor).clamp(PIXELS.0 / fit, PIXELS.1 / fit);
        let shown = (size * fit * self.zoom).max(Vec2::splat(1.0));
        self.centre = (under - (pos - rect.center()) / shown).clamp(Vec2::ZERO, Vec2::splat(1.0));
    }
}

/// Pixels of the window for one of a picture that is seen whole.
fn fit(rect: Rect, size: Vec2) -> f32 {
    (rect.width() / size.x.max(1.0)).min(rect.height() / size.y.max(1.0)).max(1e-6)
}

/// A place in the window as a share of what lies in `place`.
pub(super) fn share(place: Rect, pos: Pos2) -> Vec2 {
    let size = place.size().max(Vec2::splat(1e-6));
    let from = pos - place.min;
    vec2(from.x / size.x, from.y / size.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    const SIZE: Vec2 = vec2(200.0, 100.0);

    fn window() -> Rect {
        Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 400.0))
    }

    #[test]
    fn all_of_a_picture_is_seen_at_first_and_in_the_middle() {
        let place = View::default().place(window(), SIZE);
        assert_eq!(place, Rect::from_min_max(pos2(10.0, 120.0), pos2(410.0, 320.0)));
    }

    #[test]
    fn what_is_under_the_pointer_stays_there_when_it_is_enlarged() {
        let mut view = View::default();
        let pos = pos2(150.0, 180.0);
        let before = share(view.place(window(), SIZE), pos);
        view.enlarge(3.0, pos, window(), SIZE);
        let after = share(view.place(window(), SIZE), pos);
        assert!((before - after).length() < 1e-5, "{before} {after}");
        assert!((view.place(window(), SIZE).width() - 1200.0).abs() < 1e-2);
    }

    #[test]
    fn the_same_view_of_a_finer_picture_shows_the_same_place() {
        let mut view = View::default();
        view.enlarge(4.0, pos2(300.0, 200.0), window(), SIZE);
        view.pan(vec2(30.0, -20.0), window(), SIZE);
        let (coarse, fine) = (view.place(window(), SIZE), view.place(window(), SIZE * 5.0));
        assert!((coarse.min - fine.min).length() < 1e-2 && (coarse.max - fine.max).length() < 1e-2);
    }

    #[test]
    fn a_picture_cannot_be_moved_out_of_sight() {
        let mut view = View::default();
        view.pan(vec2(1e6, -1e6), window(), SIZE);
        assert!(view.place(window(), SIZE).expand(0.5).contains(window().center()));
    }
}
