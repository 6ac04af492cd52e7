//! The host as a node sees it.

use std::{ffi::CStr, path::PathBuf, thread};

use orograph_abi::{
    FILES, OROGRAPH_LOG_INFO, OROGRAPH_LOG_WARNING, OROGRAPH_OK, OrographFiles, OrographHost, OrographJob,
    OrographText, OrographThreads, OrographValue, THREADS,
};
use orograph_core::{Error, Host, OutputStream, Result};

/// The host's functions for one job. They may be called from any thread, and after its end.
pub(crate) struct Caller<'a> {
    host: &'a OrographHost,
    job: u64,
    memory_limit: u64,
}

impl<'a> Caller<'a> {
    /// The host that gave `job`; `None` where its structs are smaller than those of ABI 1.0.
    pub(crate) fn of(job: &'a OrographJob) -> Option<Self> {
        let large_enough = |said: u32, needed: usize| said as usize >= needed;
        // SAFETY: the host's table is valid for as long as the plugin is loaded.
        let host = unsafe { job.host.as_ref() }?;
        (large_enough(job.size, size_of::<OrographJob>())
            && large_enough(host.size, size_of::<OrographHost>()))
        .then_some(Self { host, job: job.id, memory_limit: job.memory_limit })
    }

    /// The host's side of an extension.
    fn extension<T>(&self, name: &CStr) -> Option<&'a T> {
        // SAFETY: the name is terminated, and of what struct the host answers with goes by the name.
        unsafe { (self.host.extension)(name.as_ptr()).cast::<T>().as_ref() }
    }

    /// How many threads the run may use.
    pub(crate) fn threads(&self) -> usize {
        match self.extension::<OrographThreads>(THREADS) {
            // SAFETY: the function may be called from any thread.
            Some(threads) => unsafe { (threads.count)(self.job) }.max(1) as usize,
            None => thread::available_parallelism().map_or(1, Into::into),
        }
    }

    /// Hands an output over; false when the host refuses it.
    pub(crate) fn output(&self, port: usize, value: &OrographValue) -> bool {
        // SAFETY: the view is good until this returns, which is as long as the host looks at it.
        u32::try_from(port)
            .is_ok_and(|port| unsafe { (self.host.output)(self.job, port, value) } == OROGRAPH_OK)
    }

    /// Says why the job fails.
    pub(crate) fn fail(&self, message: &str, hint: &str) {
        // SAFETY: the host copies both texts before it returns.
        unsafe { (self.host.fail)(self.job, OrographText::of(message), OrographText::of(hint)) };
    }

    /// Ends the process: to go on would be to read memory that is no longer there.
    #[expect(clippy::print_stderr, reason = "the last words before the end; no host hears any others")]
    pub(crate) fn abort(&self, message: &str) -> ! {
        eprintln!("orograph-plugin: {message}");
        std::process::abort()
    }
}

impl Host for Caller<'_> {
    fn cancelled(&self) -> bool {
        // SAFETY: the function may be called from any thread.
        unsafe { (self.host.cancelled)(self.job) != 0 }
    }

    fn progress(&self, done: f64) {
        // SAFETY: as above.
        unsafe { (self.host.progress)(self.job, done) }
    }

    fn warn(&self, message: &str) {
        // SAFETY: as above; the host copies the text before it returns.
        unsafe { (self.host.log)(self.job, OROGRAPH_LOG_WARNING, OrographText::of(message)) }
    }

    fn note(&self, message: &str) {
        // SAFETY: as above.
        unsafe { (self.host.log)(self.job, OROGRAPH_LOG_INFO, OrographText::of(message)) }
    }

    fn memory_limit(&self) -> u64 {
        self.memory_limit
    }

    fn input_path(&self, path: &str) -> Result<PathBuf> {
        let Some(files) = self.extension::<OrographFiles>(FILES) else {
            return Err(Error::reading(path, "this host lends no files to plugins"));
        };
        let mut found = OrographText::EMPTY;
        // SAFETY: the function may be called from any thread; it copies the name and fills in `found`.
        let status = unsafe { (files.input_path)(self.job, OrographText::of(path), &raw mut found) };
        if status != OROGRAPH_OK {
            return Err(Error::reading(path, "the host has no such file"));
        }
        // SAFETY: the host keeps the path until the job ends.
        unsafe { path_of(found) }.ok_or_else(|| Error::reading(path, "the host's path is no path here"))
    }

    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::writing(path, "a plugin's node writes no files"))
    }
}

/// The path of a text in the system's own form: any bytes on Unix, UTF-8 elsewhere.
///
/// # Safety
/// Where the pointer is not null, `len` bytes must lie there.
unsafe fn path_of(text: OrographText) -> Option<PathBuf> {
    if text.data.is_null() || text.len == 0 {
        return None;
    }
    // SAFETY: as the caller vouches.
    let bytes = unsafe { std::slice::from_raw_parts(text.data.cast::<u8>(), text.len) };
    #[cfg(unix)]
    let path: Option<&std::ffi::OsStr> = Some(std::os::unix::ffi::OsStrExt::from_bytes(bytes));
    #[cfg(not(unix))]
    let path = std::str::from_utf8(bytes).ok().map(std::ffi::OsStr::new);
    path.map(PathBuf::from)
}
