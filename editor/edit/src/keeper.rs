//! The settings at hand, and a thread that writes what changes of them.

use std::{
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread::JoinHandle,
};

use orograph_session::{Error, Settings, settings::Theme};

/// Something else in the settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// The colours.
    Theme(Theme),
    /// The cache folder; `none` for memory alone, nothing for the usual one.
    Cache(Option<PathBuf>),
    /// Bytes of results in memory; nothing for as many as fit the machine.
    Memory(Option<u64>),
    /// One folder of plugins more.
    AddPlugins(PathBuf),
    /// One folder of plugins less.
    RemovePlugins(PathBuf),
    /// Whether the plugin of that name runs in processes of its own.
    Isolate(String, bool),
    /// A graph was opened, or saved under a name.
    Opened(PathBuf),
    /// A graph that was open once is gone.
    Gone(PathBuf),
}

impl Change {
    /// Makes the change.
    pub fn apply(&self, settings: &mut Settings) {
        match self {
            Self::Theme(theme) => settings.theme = *theme,
            Self::Cache(folder) => settings.cache.clone_from(folder),
            Self::Memory(bytes) => settings.memory = *bytes,
            Self::AddPlugins(folder) if settings.plugins.contains(folder) => {}
            Self::AddPlugins(folder) => settings.plugins.push(folder.clone()),
            Self::RemovePlugins(folder) => settings.plugins.retain(|known| known != folder),
            Self::Isolate(name, apart) => {
                settings.isolate.retain(|known| known != name);
                if *apart {
                    settings.isolate.push(name.clone());
                }
            }
            Self::Opened(graph) => settings.opened(graph),
            Self::Gone(graph) => settings.forget(graph),
        }
    }
}

enum Order {
    Change(Change),
    /// Reads what another program wrote.
    Look,
}

/// Holds the settings: a change is there at once and written beside.
pub struct Keeper {
    settings: Settings,
    file: Option<PathBuf>,
    wake: Arc<dyn Fn() + Send + Sync>,
    clerk: Option<Clerk>,
    /// Orders that were not answered yet.
    pending: usize,
}

struct Clerk {
    orders: Sender<Order>,
    answers: Receiver<Result<Settings, Error>>,
    thread: JoinHandle<()>,
}

impl Keeper {
    /// Holds `settings`, which were read from `file`; without a file changes last until the program ends. `wake` is
    /// called, from another thread, when something was written.
    #[must_use]
    pub fn new(settings: Settings, file: Option<PathBuf>, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        Self { settings, file, wake, clerk: None, pending: 0 }
    }

    /// The settings as they are now.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Where they are kept.
    #[must_use]
    pub fn file(&self) -> Option<&PathBuf> {
        self.file.as_ref()
    }

    /// Changes something, at once here and soon in the file, in which the rest stays as others wrote it.
    ///
    /// # Errors
    /// When no thread can be started; the change then lasts until the program ends.
    pub fn change(&mut self, change: Change) -> Result<(), Error> {
        change.apply(&mut self.settings);
        self.order(Order::Change(change))
    }

    /// Reads the file again, which another program may have written.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn look(&mut self) -> Result<(), Error> {
        self.order(Order::Look)
    }

    fn order(&mut self, order: Order) -> Result<(), Error> {
        let Some(file) = &self.file else { return Ok(()) };
        let clerk = match &self.clerk {
            Some(clerk) => clerk,
            None => self.clerk.insert(Clerk::hire(file.clone(), self.wake.clone())?),
        };
        if clerk.orders.send(order).is_ok() {
            self.pending += 1;
        }
        Ok(())
    }

    /// Whether something is not written yet.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.pending > 0
    }

    /// What could not be written or read since the last call. To be called in every frame.
    pub fn failures(&mut self) -> Vec<Error> {
        let mut failures = Vec::new();
        let answers = self.clerk.iter().flat_map(|clerk| clerk.answers.try_iter());
        for answer in answers {
            self.pending = self.pending.saturating_sub(1);
            match answer {
                // What is not answered yet is changed here already.
                Ok(settings) if self.pending == 0 => self.settings = settings,
                Ok(_) => {}
                Err(error) => failures.push(error),
            }
        }
        failures
    }
}

impl Drop for Keeper {
    /// What was ordered is still written.
    fn drop(&mut self) {
        if let Some(Clerk { orders, thread, .. }) = self.clerk.take() {
            drop(orders);
            let _ = thread.join();
        }
    }
}

impl Clerk {
    fn hire(file: PathBuf, wake: Arc<dyn Fn() + Send + Sync>) -> Result<Self, Error> {
        let (orders, desk) = mpsc::channel();
        let (sender, answers) = mpsc::channel();
        let serve = move || {
            for order in desk {
                let answer = match order {
                    Order::Change(change) => Settings::change_in(&file, |settings| change.apply(settings)),
                    Order::Look => Settings::load_from(&file),
                };
                // The window may be gone by then; what it ordered is written all the same.
                let _ = sender.send(answer);
                wake();
            }
        };
        let thread = std::thread::Builder::new().name("settings".into()).spawn(serve);
        let thread = thread
            .map_err(|error| Error::Failed(format!("the settings are not kept: no thread: {error}")))?;
        Ok(Self { orders, answers, thread })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn heard(keeper: &mut Keeper) -> Vec<Error> {
        let mut failures = Vec::new();
        while keeper.is_busy() {
            failures.extend(keeper.failures());
            std::thread::yield_now();
        }
        failures
    }

    #[test]
    fn a_change_is_there_at_once_and_in_the_file_when_the_program_ends() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        let mut keeper = Keeper::new(Settings::default(), Some(file.clone()), Arc::new(|| ()));
        let changes = [
            Change::Theme(Theme::Dark),
            Change::Cache(Some(folder.path().join("cache"))),
            Change::Memory(Some(1 << 30)),
            Change::AddPlugins(folder.path().join("a")),
            Change::AddPlugins(folder.path().join("b")),
            Change::AddPlugins(folder.path().join("b")),
            Change::RemovePlugins(folder.path().join("a")),
            Change::Isolate("Coast".into(), true),
            Change::Isolate("Dunes".into(), true),
            Change::Isolate("Coast".into(), false),
            Change::Opened(folder.path().join("x.ron")),
            Change::Opened(folder.path().join("y.ron")),
            Change::Gone(folder.path().join("x.ron")),
        ];
        for change in changes {
            keeper.change(change).unwrap();
        }
        let expected = Settings {
            theme: Theme::Dark,
            cache: Some(folder.path().join("cache")),
            memory: Some(1 << 30),
            plugins: vec![folder.path().join("b")],
            isolate: vec!["Dunes".into()],
            recent: vec![folder.path().join("y.ron")],
        };
        assert_eq!(*keeper.settings(), expected);
        drop(keeper);
        assert_eq!(Settings::load_from(&file).unwrap(), expected);
    }

    #[test]
    fn what_others_wrote_stays_and_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        let mut keeper = Keeper::new(Settings::default(), Some(file.clone()), Arc::new(|| ()));
        fs::write(&file, "(memory: 5)").unwrap();
        keeper.change(Change::Theme(Theme::Light)).unwrap();
        assert!(heard(&mut keeper).is_empty());
        assert_eq!(keeper.settings().memory, Some(5));
        fs::write(&file, "(memory: 6, theme: Dark)").unwrap();
        keeper.look().unwrap();
        assert!(heard(&mut keeper).is_empty());
        assert_eq!((keeper.settings().memory, keeper.settings().theme), (Some(6), Theme::Dark));
    }

    #[test]
    fn what_cannot_be_kept_is_told_and_still_holds_here() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("settings.ron");
        fs::write(&file, "(theme: Blue)").unwrap();
        let mut keeper = Keeper::new(Settings::default(), Some(file), Arc::new(|| ()));
        keeper.change(Change::Theme(Theme::Dark)).unwrap();
        let failures = heard(&mut keeper);
        assert!(failures[0].to_string().contains("Blue"), "{failures:?}");
        assert_eq!(keeper.settings().theme, Theme::Dark);
        let mut nowhere = Keeper::new(Settings::default(), None, Arc::new(|| ()));
        nowhere.change(Change::Theme(Theme::Dark)).unwrap();
        assert!(!nowhere.is_busy());
    }
}
