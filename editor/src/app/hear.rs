//! What the runner tells.

use eframe::egui;
use orograph_edit::{Badge, News};

use super::{App, nodes::node_of};
use crate::views::thumbnail;

impl App {
    pub(super) fn hear(&mut self, ctx: &egui::Context) {
        for news in self.runner.news() {
            self.stale = true;
            match news {
                News::Faults(faults) => {
                    self.faults = faults;
                    // What was said of nodes that run again is over.
                    self.badges.retain(|_, badge| !matches!(badge, Badge::Failed(_) | Badge::Running(_)));
                }
                News::Node(name, badge) => {
                    self.badges.insert(name, badge);
                }
                News::Shown(name, result) => self.show_answer(ctx, &name, result),
                News::Progress(done) => self.progress.is_at(done),
                News::Idle => {
                    self.progress.end();
                    self.badges.retain(|_, badge| !matches!(badge, Badge::Running(_)));
                }
                News::Building(done) => self.building.is_at(done),
                News::Built(result) => self.built(result),
            }
        }
    }

    fn show_answer(
        &mut self,
        ctx: &egui::Context,
        name: &str,
        result: Result<orograph_edit::Shown, Vec<orograph_edit::Fault>>,
    ) {
        if let Some(pane) = self.panes.iter_mut().find(|pane| pane.name == name) {
            pane.take(ctx, result);
            return;
        }
        if let Some(variations) = self.variations.as_mut().filter(|variations| variations.has(name)) {
            variations.take(ctx, name, result);
            return;
        }
        let node = node_of(name).filter(|node| self.editing.document().nodes.contains_key(*node));
        if let (Some(node), Ok(shown)) = (node, result)
            && let Some(picture) = thumbnail(ctx, name, &shown)
        {
            self.pictures.insert(node.to_owned(), picture);
        }
    }
}
