//! The build button: what `orograph run` does, from here.

use std::sync::Arc;

use orograph_core::Context;
use orograph_edit::{Fault, Scene};

use super::App;

impl App {
    pub(super) fn build(&mut self) {
        self.building.begin();
        // At full resolution, whatever the preview has.
        let context = Context { resolution: None, ..self.context };
        let scene = Scene { document: Arc::clone(self.editing.document()), folder: self.folder(), context };
        let history = self.file.as_ref().map(|file| orograph_session::targets::history(file.path()));
        self.runner.build(scene, self.out.clone(), history);
    }

    pub(super) fn built(&mut self, result: Result<Vec<String>, Vec<Fault>>) {
        self.building.end();
        match result {
            Ok(files) => {
                let folder = self.out.display().to_string();
                self.tell(format!("Built into {folder}: {}", files.join(", ")));
            }
            Err(faults) => {
                let words = faults.iter().map(|fault| match &fault.node {
                    Some(node) => format!("{node}: {}", fault.words()),
                    None => fault.words(),
                });
                let words = words.collect::<Vec<_>>().join("; ");
                self.complain(format!("Not built: {words}"));
            }
        }
    }
}
