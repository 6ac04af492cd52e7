//! Two panes beside each other: linked, so that both look at the same place, or as one picture with a line between.

use std::ops::RangeInclusive;

use eframe::egui::{self, Align, Color32, CursorIcon, Rect, Sense, Stroke, pos2, vec2};
use orograph_core::Grid;
use orograph_engine::Registry;

use super::{Asked, Offer, Pane, Tool, ground::Stand, keys, picture, probe::Probe, view::View};

/// Where the line between two pictures may stand, in shares of the view.
const LINE: RangeInclusive<f32> = 0.02..=0.98;

/// How panes that are seen together belong together.
pub struct Compare {
    /// Moving one moves the other.
    linked: bool,
    /// One picture with a line, left of which the first pane is seen, and right of it the second.
    wipe: bool,
    line: f32,
    /// Where each pane looked in the last frame.
    seen: Vec<Outlook>,
}

impl Default for Compare {
    fn default() -> Self {
        Self { linked: true, wipe: false, line: 0.5, seen: Vec::new() }
    }
}

impl Compare {
    /// Draws panes beside each other; `offers` says what there is for each.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        panes: &mut [Pane],
        registry: &Registry,
        offers: &[Offer],
        tool: Tool,
    ) -> Vec<(usize, Asked)> {
        let mut asked = Vec::new();
        if panes.len() > 1 {
            ui.horizontal(|ui| {
                let linked = ui.checkbox(&mut self.linked, "linked");
                if linked.on_hover_text("Moving one picture moves the other").changed() {
                    self.seen.clear();
                }
                ui.checkbox(&mut self.wipe, "wipe")
                    .on_hover_text("One picture: left of a line the first view, right of it the second");
            });
        }
        let others: Vec<_> = panes.iter().map(|pane| pane.output.clone()).collect();
        let other = |index: usize| others.iter().enumerate().find(|(i, _)| *i != index)?.1.clone();
        let size = vec2(ui.available_width() / panes.len().max(1) as f32 - 6.0, ui.available_height());
        let wipes = self.wipe && panes.len() == 2;
        ui.horizontal_top(|ui| {
            for (index, (pane, offer)) in panes.iter_mut().zip(offers).enumerate() {
                let other = other(index);
                let size = if wipes { vec2(size.x, ui.spacing().interact_size.y) } else { size };
                ui.allocate_ui_with_layout(size, egui::Layout::top_down(egui::Align::Min), |ui| {
                    ui.set_min_size(size);
                    let mut answers = Vec::new();
                    pane.bar(ui, registry, offer, other.as_ref(), &mut answers);
                    if !wipes {
                        answers.extend(pane.content(ui, tool, &offer.strokes));
                    }
                    asked.extend(answers.into_iter().map(|asked| (index, asked)));
                });
            }
        });
        match panes {
            [left, right] if wipes => self.wipe(ui, left, right),
            panes => self.link(panes),
        }
        asked
    }

    /// Whoever was moved takes the others along.
    fn link(&mut self, panes: &mut [Pane]) {
        if self.linked && panes.len() > 1 {
            let moved = match self.seen.len() == panes.len() {
                true => panes.iter().zip(&self.seen).position(|(pane, before)| pane.outlook() != *before),
                // Whoever comes anew looks where the first one looks.
                false => Some(0),
            };
            if let Some(moved) = moved {
                let outlook = panes[moved].outlook();
                for pane in panes.iter_mut() {
                    pane.look_at(outlook);
                }
            }
        }
        self.seen.clear();
        self.seen.extend(panes.iter().map(Pane::outlook));
    }

    fn wipe(&mut self, ui: &mut egui::Ui, left: &mut Pane, right: &mut Pane) {
        let both = [&*left, &*right].map(|pane| pane.picture.texture());
        let [Some(_), Some(_)] = both else {
            ui.set_min_size(ui.available_size());
            let missing = if both[0].is_none() { &*left } else { &*right };
            let title = missing.output.as_ref().map_or_else(|| "nothing".to_owned(), ToString::to_string);
            ui.label(format!("The {} shows no picture of `{title}` to be wiped over", missing.name));
            ui.weak("Show terrain, a mask, features or a picture in both, or take the mark off `wipe`.");
            return;
        };
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Image, true, "both pictures, with a line between")
        });
        left.picture.navigate(ui, &response, rect, Tool::Look);
        right.picture.view = left.picture.view;
        let x = self.line(ui, rect);
        let place = left.picture.place(rect);
        let grids = [&*left, &*right].map(|pane| pane.probe().and_then(|probe| probe.grid().cloned()));
        let other_place = match &grids {
            [Some(a), Some(b)] => place_of(place, a, b),
            _ => place,
        };
        let (west, east) = (rect.with_max_x(x), rect.with_min_x(x));
        let painter = ui.painter_at(rect);
        left.picture.paint(&painter.with_clip_rect(west), place);
        right.picture.paint(&painter.with_clip_rect(east), other_place);
        let ends = [pos2(x, rect.top()), pos2(x, rect.bottom())];
        painter.line_segment(ends, Stroke::new(4.0, Color32::from_black_alpha(170)));
        painter.line_segment(ends, Stroke::new(2.0, Color32::WHITE));
        if let [Some(grid), _] = &grids {
            picture::scale_bar(&painter, rect, place.width() / left.picture.size.x.max(1.0), grid.cell.x);
        }
        for (pane, side) in [(&*left, Align::Min), (&*right, Align::Max)] {
            if let Some(legend) = pane.sight().and_then(|sight| sight.legend.as_ref()) {
                legend.ui(ui, rect, side, response.id.with((&pane.name, "legend")));
            }
        }
        if let Some(pos) = response.hover_pos() {
            let what = |pane: &Pane, place: Rect| {
                let reach = pane.picture.reach(place);
                pane.probe()?.what(picture::share(place, pos), reach)
            };
            let words = |text: Option<String>| text.unwrap_or_else(|| "nothing".to_owned());
            let text = format!("{}   |   {}", words(what(left, place)), words(what(right, other_place)));
            picture::tell(ui, rect, response.id.with("probe"), text);
        }
    }

    /// The line, where the pointer or the keys put it.
    fn line(&mut self, ui: &egui::Ui, rect: Rect) -> f32 {
        /// What a press of a key moves it by.
        const STEP: f32 = 0.02;
        let x = rect.left() + self.line * rect.width();
        let handle = Rect::from_x_y_ranges(x - 5.0..=x + 5.0, rect.y_range());
        let response = ui.interact(handle, ui.id().with("wipe line"), Sense::click_and_drag());
        if let Some(pos) = response.interact_pointer_pos()
            && response.dragged()
        {
            self.line = (pos.x - rect.left()) / rect.width().max(1.0);
        }
        self.line += STEP * keys::held(ui, &response).arrows.x;
        self.line = self.line.clamp(*LINE.start(), *LINE.end());
        if response.hovered() || response.dragged() {
            ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        let share = f64::from(self.line);
        response.widget_info(|| egui::WidgetInfo::slider(true, share, "line between the pictures"));
        rect.left() + self.line * rect.width()
    }
}

/// Where the ground of grid `b` lies when that of `a` lies in `place`; there as well when they share no ground.
fn place_of(place: Rect, a: &Grid, b: &Grid) -> Rect {
    let bounds = |grid: &Grid| {
        let first = grid.position(0, 0);
        let (west, north) = (first.x - grid.cell.x / 2.0, first.y + grid.cell.y / 2.0);
        let (width, height) = (grid.cols as f64 * grid.cell.x, grid.rows as f64 * grid.cell.y);
        [west, north, width, height]
    };
    let ([ax, ay, aw, ah], [bx, by, bw, bh]) = (bounds(a), bounds(b));
    let apart = bx >= ax + aw || ax >= bx + bw || by <= ay - ah || ay <= by - bh;
    if apart || aw <= 0.0 || ah <= 0.0 {
        return place;
    }
    let (per_x, per_y) = (f64::from(place.width()) / aw, f64::from(place.height()) / ah);
    let min = place.min + vec2(((bx - ax) * per_x) as f32, ((ay - by) * per_y) as f32);
    Rect::from_min_size(min, vec2((bw * per_x) as f32, (bh * per_y) as f32))
}

/// Where a pane looks, at pictures and at ground.
#[derive(Clone, Copy, PartialEq)]
struct Outlook {
    view: View,
    stand: Stand,
}

impl Pane {
    fn outlook(&self) -> Outlook {
        Outlook { view: self.picture.view, stand: self.ground.stand }
    }

    fn look_at(&mut self, outlook: Outlook) {
        (self.picture.view, self.ground.stand) = (outlook.view, outlook.stand);
    }

    fn probe(&self) -> Option<Probe<'_>> {
        self.sight().map(super::Sight::probe)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use orograph_core::CellSize;

    use super::*;

    #[test]
    fn the_same_ground_lies_in_the_same_place_on_coarser_cells_and_in_a_part() {
        let place = Rect::from_min_size(pos2(100.0, 50.0), vec2(400.0, 400.0));
        let whole = Grid::new(80, 80, CellSize::square(10.0)).unwrap();
        let part = whole.crop(20, 40, 20, 40).unwrap();
        let expected = Rect::from_min_size(pos2(300.0, 150.0), vec2(200.0, 100.0));
        assert_eq!(place_of(place, &whole, &part), expected);
        let coarse = whole.resized(40, 40).unwrap();
        let same = place_of(place, &whole, &coarse);
        assert!((same.min - place.min).length() < 1e-3 && (same.max - place.max).length() < 1e-3, "{same}");
    }

    #[test]
    fn other_ground_is_laid_on_the_same_place() {
        let place = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 400.0));
        let here = Grid::new(80, 80, CellSize::square(10.0)).unwrap();
        let mut away = here.clone();
        away.col0 = 1000;
        assert_eq!(place_of(place, &here, &away), place);
    }
}
