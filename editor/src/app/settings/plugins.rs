//! Plugins: found again beside the window, and put in place of those before without losing the document.

use std::{
    collections::BTreeSet,
    sync::{
        Arc,
        mpsc::{self, Receiver, TryRecvError},
    },
};

use orograph_edit::Interfaces;
use orograph_engine::{Registry, plugin::Found};
use orograph_session::{Error, Settings};

use super::App;

/// Finds the node types that there are, those of plugins among them, and tells what became of each library. Called on
/// a thread of its own.
pub type PluginLoader = Arc<dyn Fn(&Settings) -> Result<(Registry, Vec<Found>), Error> + Send + Sync>;

type Loaded = Result<(Registry, Vec<Found>), Error>;

/// The plugins that were found.
pub(super) struct Plugins {
    loader: PluginLoader,
    found: Vec<Found>,
    loading: Option<Receiver<Loaded>>,
    /// Asked for while it was being done: the folders may have changed since.
    again: bool,
}

impl Plugins {
    pub(super) fn new(loader: PluginLoader, found: Vec<Found>) -> Self {
        Self { loader, found, loading: None, again: false }
    }

    /// Every library that was found.
    pub(super) fn found(&self) -> &[Found] {
        &self.found
    }

    /// Whether node types come from a plugin.
    pub(super) fn are_there(&self) -> bool {
        self.found.iter().any(|found| found.outcome.is_ok())
    }

    pub(super) fn is_busy(&self) -> bool {
        self.loading.is_some()
    }

    fn begin(&mut self, settings: Settings) {
        if self.is_busy() {
            self.again = true;
            return;
        }
        let (sender, answer) = mpsc::channel();
        let loader = Arc::clone(&self.loader);
        let load = move || {
            // The window may be gone by then.
            let _ = sender.send(loader(&settings));
        };
        self.loading = Some(answer);
        // Where no thread can be started, its end of the line is gone at once.
        let _ = std::thread::Builder::new().name("plugins".into()).spawn(load);
    }

    fn answer(&mut self) -> Option<Loaded> {
        let loaded = match self.loading.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                Err(Error::Failed("plugins cannot be looked at: the thread for it ended".into()))
            }
            Ok(loaded) => loaded,
        };
        self.loading = None;
        Some(loaded)
    }
}

impl App {
    /// Looks for plugins again, beside the window.
    pub(super) fn reload_plugins(&mut self) {
        let settings = self.preferences.keeper.settings().clone();
        self.preferences.plugins.begin(settings);
    }

    pub(super) fn plugins_answer(&mut self) {
        let Some(loaded) = self.preferences.plugins.answer() else { return };
        match loaded {
            Ok((registry, found)) => {
                let words = difference(&self.registry, &registry, self.preferences.plugins.found == found);
                let refused = found.iter().filter(|found| found.outcome.is_err()).count();
                self.preferences.plugins.found = found;
                self.use_registry(Arc::new(registry));
                match refused {
                    0 => self.tell(words),
                    1 => self.complain(format!("{words}; one was refused, the settings say why")),
                    n => self.complain(format!("{words}; {n} were refused, the settings say why")),
                }
            }
            Err(error) => self.complain(error.in_words()),
        }
        if std::mem::take(&mut self.preferences.plugins.again) {
            self.reload_plugins();
        }
    }

    /// Takes other node types: placeholders whose type came become nodes, nodes whose type went become placeholders.
    /// Document, history and selection stay as they are.
    fn use_registry(&mut self, registry: Arc<Registry>) {
        let before = std::mem::replace(&mut self.registry, Arc::clone(&registry));
        self.interfaces = Interfaces::new(Arc::clone(&registry), self.folder());
        self.runner.use_registry(Arc::clone(&registry));
        if let Some(journal) = &self.journal {
            journal.use_registry(registry);
        }
        // Whatever was made by nodes of before is not what these make.
        self.badges.clear();
        self.pictures.clear();
        self.panes.iter_mut().for_each(crate::views::Pane::clear);
        self.variations = None;
        (self.stale, self.asked) = (true, None);
        // Processes of plugins end with the last who holds them: nothing to wait for here.
        let _ = std::thread::Builder::new().name("plugins that went".into()).spawn(move || drop(before));
    }
}

/// What came and went, in words.
fn difference(before: &Registry, after: &Registry, same: bool) -> String {
    let ids = |registry: &Registry| {
        registry.iter().map(|node_type| node_type.spec().id.to_string()).collect::<BTreeSet<_>>()
    };
    let (before, after) = (ids(before), ids(after));
    let types = |n: usize| if n == 1 { "one node type".to_owned() } else { format!("{n} node types") };
    match (after.difference(&before).count(), before.difference(&after).count()) {
        (0, 0) if same => "Plugins are as they were".into(),
        (0, 0) => "Plugins were looked at again: the same node types are there".into(),
        (came, 0) => format!("Plugins were looked at again: {} came", types(came)),
        (0, went) => format!("Plugins were looked at again: {} went", types(went)),
        (came, went) => format!("Plugins were looked at again: {} came, {} went", types(came), types(went)),
    }
}
