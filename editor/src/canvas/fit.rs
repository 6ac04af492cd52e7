//! All of the graph in view: also while its nodes still grow, as their pictures come.

use eframe::egui::{self, Event, Rect};

/// Whether all is to be looked at.
pub(super) struct Fit {
    wanted: bool,
    /// What was looked at last, until the user does something.
    seen: Option<Rect>,
}

impl Default for Fit {
    fn default() -> Self {
        Self { wanted: true, seen: None }
    }
}

impl Fit {
    /// Looks at all in the next frame.
    pub(super) fn ask(&mut self) {
        self.wanted = true;
    }

    /// Whether to look at `all`, the rectangle around everything: because it was asked for, or because it is another
    /// one than a moment ago, while nobody did anything.
    pub(super) fn is_due(&mut self, ctx: &egui::Context, all: Rect) -> bool {
        let touched = ctx.input(|input| {
            input.pointer.any_down()
                || input.events.iter().any(|event| {
                    matches!(
                        event,
                        Event::Key { pressed: true, .. } | Event::MouseWheel { .. } | Event::Zoom(_)
                    )
                })
        });
        if touched {
            self.seen = None;
        }
        // Text is a little wider or narrower at another scale, which is no growth.
        let grown = |seen: Rect| (seen.min - all.min).length() > 4.0 || (seen.max - all.max).length() > 4.0;
        let due = std::mem::take(&mut self.wanted) || self.seen.is_some_and(grown);
        if due {
            self.seen = Some(all);
        }
        due
    }
}
