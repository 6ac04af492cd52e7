//! Work under way: how far it is, how long it still takes, and how it is stopped.

use eframe::egui;
use orograph_edit::TimeLeft;

use super::App;

/// One kind of work.
#[derive(Default)]
pub(super) struct Progress {
    /// The share that is done; none when nothing is under way.
    share: Option<f64>,
    left: TimeLeft,
}

impl Progress {
    /// Other work begins in place of what was under way.
    pub(super) fn begin(&mut self) {
        self.left.over();
        self.share = Some(0.0);
    }

    /// So much of it is done.
    pub(super) fn is_at(&mut self, share: f64) {
        self.share = Some(share);
    }

    /// It is over.
    pub(super) fn end(&mut self) {
        self.left.over();
        self.share = None;
    }

    pub(super) fn is_under_way(&self) -> bool {
        self.share.is_some()
    }

    fn show(&mut self, ui: &mut egui::Ui, name: &str) {
        let Some(share) = self.share else { return };
        let now = ui.input(|input| input.time);
        self.left.learn(share, now);
        ui.add(egui::ProgressBar::new(share as f32).desired_width(140.0).text(name));
        if let Some(words) = self.left.words(now) {
            ui.label(words);
        }
        // Time goes on while nothing is heard.
        ui.ctx().request_repaint_after(std::time::Duration::from_millis(500));
    }
}

impl App {
    pub(super) fn progress_ui(&mut self, ui: &mut egui::Ui) {
        self.building.show(ui, "building");
        self.progress.show(ui, "preview");
        let under_way = self.building.is_under_way() || self.progress.is_under_way();
        if under_way && ui.small_button("stop").clicked() {
            self.runner.stop();
        }
    }
}
