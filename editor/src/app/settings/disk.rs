//! What the cache takes on the disk, counted and cleared beside the window.

use std::{
    io,
    sync::{
        Arc,
        mpsc::{self, Receiver, TryRecvError},
    },
};

use orograph_engine::Evaluator;

/// How much the cache takes, as far as it was counted.
#[derive(Default)]
pub(super) struct Disk {
    bytes: Option<u64>,
    work: Option<Receiver<io::Result<Counted>>>,
}

struct Counted {
    bytes: u64,
    /// What was there before it was cleared; nothing when it was counted alone.
    before: Option<u64>,
}

impl Disk {
    /// Bytes that the cache took when it was last counted.
    pub(super) fn bytes(&self) -> Option<u64> {
        self.bytes
    }

    pub(super) fn is_busy(&self) -> bool {
        self.work.is_some()
    }

    /// Begins to count.
    pub(super) fn count(&mut self, evaluator: &Arc<Evaluator>) {
        self.begin(evaluator, false);
    }

    /// Begins to remove everything. Runs that go on meanwhile compute again what they miss.
    pub(super) fn clear(&mut self, evaluator: &Arc<Evaluator>) {
        self.begin(evaluator, true);
    }

    fn begin(&mut self, evaluator: &Arc<Evaluator>, clear: bool) {
        if self.is_busy() || evaluator.cache().disk().is_none() {
            return;
        }
        let (sender, answer) = mpsc::channel();
        let evaluator = Arc::clone(evaluator);
        let work = move || {
            let Some(disk) = evaluator.cache().disk() else { return };
            let counted = disk.stat().and_then(|before| {
                if !clear {
                    return Ok(Counted { bytes: before.bytes(), before: None });
                }
                disk.clear()?;
                Ok(Counted { bytes: disk.stat()?.bytes(), before: Some(before.bytes()) })
            });
            // The window may be gone by then.
            let _ = sender.send(counted);
        };
        self.work = Some(answer);
        // Where no thread can be started, its end of the line is gone at once.
        let _ = std::thread::Builder::new().name("cache on disk".into()).spawn(work);
    }

    /// What came of the work, once: the bytes that were cleared away, when they were.
    pub(super) fn answer(&mut self) -> Option<io::Result<Option<u64>>> {
        let counted = match self.work.as_ref()?.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(io::Error::other("no thread could be started for it")),
            Ok(counted) => counted,
        };
        self.work = None;
        Some(counted.map(|counted| {
            self.bytes = Some(counted.bytes);
            counted.before.map(|before| before.saturating_sub(counted.bytes))
        }))
    }
}
