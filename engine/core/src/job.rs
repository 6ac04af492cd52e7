//! What a running node asks of its host: whether to stop, how much memory, which file, where to write.

use std::{
    io::{Seek, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use crate::{Error, InputPath, OutputPath, Result};

/// The run's context, reduced to what the node declared that it reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Context {
    /// The run's seed.
    pub seed: u64,
    /// Cells along the longer side that generators should make, when the run says so.
    pub resolution: Option<u32>,
}

/// A file being written. Dropping it without [`finish`](Self::finish) leaves nothing behind.
pub trait OutputStream: Write + Seek + Send {
    /// Puts the whole file in its place at once.
    ///
    /// # Errors
    /// [`Error::Io`]; then no file appears.
    fn finish(self: Box<Self>) -> Result<()>;
}

/// What the engine, or a test, does for a running node.
pub trait Host: Sync {
    /// Whether the run was cancelled.
    fn cancelled(&self) -> bool;
    /// Hears how much of the node's work is done, 0 to 1.
    fn progress(&self, done: f64);
    /// Hears a remark for the user that is no failure.
    fn warn(&self, message: &str);
    /// Hears something for who watches the run; it is not kept.
    fn note(&self, _message: &str) {}
    /// Most bytes that one value may take.
    fn memory_limit(&self) -> u64;
    /// Where the file to read lies.
    ///
    /// # Errors
    /// [`Error::Io`] when it is not to be had.
    fn input_path(&self, path: &str) -> Result<PathBuf>;
    /// Where the file `name` beside the file to read lies; `None` where there is no such file.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a name that is not among the node's [`companions`](crate::Node::companions);
    /// [`Error::Io`] when the system does not say whether it is there.
    fn companion(&self, _path: &str, _name: &str) -> Result<Option<PathBuf>> {
        Ok(None)
    }
    /// Begins a file in the output folder.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be made.
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>>;
}

/// One run of one node. Parallel work uses rayon, whose current pool is the one that the job runs in.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    host: &'a dyn Host,
    context: Context,
    silent: bool,
}

impl<'a> Job<'a> {
    /// A job on `host` that sees `context`.
    #[must_use]
    pub fn new(host: &'a dyn Host, context: Context) -> Self {
        Self { host, context, silent: false }
    }

    /// The same job, whose progress and remarks nobody hears: for a part of the work that is done as a whole elsewhere.
    #[must_use]
    pub fn silent(&self) -> Self {
        Self { silent: true, ..*self }
    }

    /// # Errors
    /// [`Error::Cancelled`] once the run was cancelled. Call it at least every few milliseconds of work.
    pub fn check(&self) -> Result<()> {
        if self.host.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// # Errors
    /// [`Error::TooLarge`] when a value of `bytes` is more than the run may hold. Ask before taking memory.
    pub fn admit(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
        let limit = self.host.memory_limit();
        if bytes > limit { Err(Error::TooLarge { what: what(), bytes, limit }) } else { Ok(()) }
    }

    /// Reports how much of the work is done, 0 to 1.
    pub fn progress(&self, done: f64) {
        if !self.silent {
            self.host.progress(done);
        }
    }

    /// A counter that reports progress as `total` steps are done, from any thread.
    #[must_use]
    pub fn stage(&self, total: u64) -> Stage<'a> {
        Stage { job: *self, total: total.max(1), done: AtomicU64::new(0) }
    }

    /// Tells the user something that is no failure. It is kept with the outputs and told again on a hit.
    pub fn warn(&self, message: impl AsRef<str>) {
        if !self.silent {
            self.host.warn(message.as_ref());
        }
    }

    /// Tells something to who watches the run. It is not kept with the outputs.
    pub fn note(&self, message: impl AsRef<str>) {
        if !self.silent {
            self.host.note(message.as_ref());
        }
    }

    /// Most bytes that one value may take.
    #[must_use]
    pub fn memory_limit(&self) -> u64 {
        self.host.memory_limit()
    }

    /// The run's seed; 0 unless the node declares that it reads it.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.context.seed
    }

    /// The run's resolution; `None` unless the node declares that it reads it and the run sets it.
    #[must_use]
    pub fn resolution(&self) -> Option<u32> {
        self.context.resolution
    }

    /// Where the file to read lies.
    ///
    /// # Errors
    /// [`Error::Io`] when it is not to be had.
    pub fn input_path(&self, path: &InputPath) -> Result<PathBuf> {
        self.host.input_path(&path.0)
    }

    /// Where the file `name` beside the file to read lies, one of the node's
    /// [`companions`](crate::Node::companions); `None` where there is no such file.
    ///
    /// # Errors
    /// As [`Host::companion`].
    pub fn companion(&self, path: &InputPath, name: &str) -> Result<Option<PathBuf>> {
        self.host.companion(&path.0, name)
    }

    /// Begins a file in the output folder; it appears when it is finished, or not at all.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be made.
    pub fn create(&self, path: &OutputPath) -> Result<Box<dyn OutputStream>> {
        self.host.create(&path.0)
    }
}

/// Counts steps of work and reports them.
pub struct Stage<'a> {
    job: Job<'a>,
    total: u64,
    done: AtomicU64,
}

impl Stage<'_> {
    /// Reports `steps` more; about a hundred reports reach the host however many steps there are.
    pub fn advance(&self, steps: u64) {
        let before = self.done.fetch_add(steps, Ordering::Relaxed);
        let percent = |done: u64| done.saturating_mul(100) / self.total;
        if percent(before) != percent(before + steps) {
            self.job.progress((before + steps) as f64 / self.total as f64);
        }
    }
}

/// A host without engine: never cancelled, 4 GiB, files where they are named, no outputs.
#[derive(Clone, Copy, Debug, Default)]
pub struct DetachedHost;

impl Host for DetachedHost {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, _: &str) {}
    fn memory_limit(&self) -> u64 {
        4 << 30
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Ok(PathBuf::from(path))
    }
    fn companion(&self, path: &str, name: &str) -> Result<Option<PathBuf>> {
        Ok(Some(Path::new(path).with_file_name(name)).filter(|path| path.is_file()))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::writing(path, "this run has no output folder"))
    }
}

impl Job<'static> {
    /// A job without engine, for calling an algorithm as a plain function.
    #[must_use]
    pub fn detached() -> Self {
        Job::new(&DetachedHost, Context::default())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Hears everything.
    #[derive(Default)]
    struct Ear(Mutex<Vec<String>>);

    impl Ear {
        fn hear(&self, what: &str) {
            self.0.lock().unwrap().push(what.to_owned());
        }
    }

    impl Host for Ear {
        fn cancelled(&self) -> bool {
            true
        }
        fn progress(&self, _: f64) {
            self.hear("progress");
        }
        fn warn(&self, message: &str) {
            self.hear(message);
        }
        fn note(&self, message: &str) {
            self.hear(message);
        }
        fn memory_limit(&self) -> u64 {
            0
        }
        fn input_path(&self, path: &str) -> Result<PathBuf> {
            DetachedHost.input_path(path)
        }
        fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
            DetachedHost.create(path)
        }
    }

    #[test]
    fn nothing_is_heard_of_a_silent_job_but_it_can_be_cancelled() {
        let ear = Ear::default();
        let job = Job::new(&ear, Context::default());
        for job in [job, job.silent()] {
            job.stage(1).advance(1);
            job.warn("a warning");
            job.note("a note");
            assert_eq!(job.check(), Err(Error::Cancelled));
        }
        assert_eq!(*ear.0.lock().unwrap(), ["progress", "a warning", "a note"]);
    }
}
