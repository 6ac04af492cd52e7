//! The host's functions: what a plugin may ask for while its node runs.
//!
//! None of them panics or trusts its arguments further than the ABI lets it: a panic here would end the process.

use std::ffi::{CStr, c_char, c_void};

use orograph_abi::{
    Cells, FILES, Malformed, OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR, OROGRAPH_FAILED, OROGRAPH_LOG_WARNING,
    OROGRAPH_OK, OrographFiles, OrographHost, OrographScratch, OrographText, OrographThreads, OrographValue,
    SCRATCH, THREADS, check_cells, read_text, read_value,
};
use orograph_core::{Error, InputPath};
use rayon::prelude::*;

use super::live::{LiveJob, Running, with};

/// The table that every job points to.
pub(super) static HOST: OrographHost = OrographHost {
    size: size_of::<OrographHost>() as u32,
    abi_major: OROGRAPH_ABI_MAJOR,
    abi_minor: OROGRAPH_ABI_MINOR,
    reserved: 0,
    cancelled,
    progress,
    log,
    fail,
    output,
    extension,
};

static THREAD_POOL: OrographThreads =
    OrographThreads { size: size_of::<OrographThreads>() as u32, reserved: 0, count, parallel_for };
static MEMORY: OrographScratch =
    OrographScratch { size: size_of::<OrographScratch>() as u32, reserved: 0, allocate, free };
static FILE_NAMES: OrographFiles =
    OrographFiles { size: size_of::<OrographFiles>() as u32, reserved: 0, input_path };

unsafe extern "C" fn cancelled(id: u64) -> i32 {
    i32::from(with(id, |_, running| running.job.check().is_err()).unwrap_or(true))
}

unsafe extern "C" fn progress(id: u64, done: f64) {
    if !done.is_nan() {
        with(id, |_, running| running.job.progress(done.clamp(0.0, 1.0)));
    }
}

unsafe extern "C" fn log(id: u64, level: i32, message: OrographText) {
    // SAFETY: the text stays until this returns, as the ABI says.
    let message = unsafe { lossy(message) };
    with(id, |_, running| {
        if level >= OROGRAPH_LOG_WARNING { running.job.warn(message) } else { running.job.note(message) }
    });
}

unsafe extern "C" fn fail(id: u64, message: OrographText, hint: OrographText) {
    // SAFETY: as above.
    let (message, hint) = unsafe { (lossy(message), lossy(hint)) };
    with(id, |live, _| live.fail(Error::invalid(message, hint)));
}

unsafe extern "C" fn output(id: u64, port: u32, value: *const OrographValue) -> i32 {
    let taken = with(id, |live, running| {
        // SAFETY: the view stays until this returns, as the ABI says.
        let taken = unsafe { take(live, running, port as usize, value) };
        taken.map_err(|error| live.fail(error)).is_ok()
    });
    if taken == Some(true) { OROGRAPH_OK } else { OROGRAPH_FAILED }
}

/// Checks an output and has it kept.
///
/// # Safety
/// As [`read_value`].
unsafe fn take(
    live: &LiveJob,
    running: &Running<'_>,
    port: usize,
    value: *const OrographValue,
) -> Result<(), Error> {
    let Some(spec) = running.ports.get(port) else {
        return Err(defect(format!("the node gave output {port}, but has {}", running.ports.len())));
    };
    let name = &spec.name;
    let malformed = |malformed: Malformed| defect(format!("output `{name}`: {}", malformed.0));
    let cells = running.keeper.cells();
    // SAFETY: as the caller vouches; what is lent is gone when the keeper returns.
    let value = unsafe { read_value(value, cells) }.map_err(malformed)?;
    if cells == Cells::Lent {
        check_cells(&value).map_err(malformed)?;
    }
    if value.value_type() != spec.value_type {
        let (found, wanted) = (value.value_type(), spec.value_type);
        return Err(defect(format!("output `{name}` is a {found}, but the spec says {wanted}")));
    }
    if std::mem::replace(&mut live.state().given[port], true) {
        return Err(defect(format!("the node gave its output `{name}` twice")));
    }
    running.keeper.keep(port, value)
}

unsafe extern "C" fn extension(name: *const c_char) -> *const c_void {
    if name.is_null() {
        return std::ptr::null();
    }
    // SAFETY: the name is terminated, as the ABI says.
    let name = unsafe { CStr::from_ptr(name) };
    if name == THREADS {
        std::ptr::from_ref(&THREAD_POOL).cast()
    } else if name == SCRATCH {
        std::ptr::from_ref(&MEMORY).cast()
    } else if name == FILES {
        std::ptr::from_ref(&FILE_NAMES).cast()
    } else {
        std::ptr::null()
    }
}

unsafe extern "C" fn count(_: u64) -> u32 {
    // On a thread of no pool the calls come one after the other.
    if rayon::current_thread_index().is_none() { 1 } else { rayon::current_num_threads() as u32 }
}

unsafe extern "C" fn parallel_for(
    _: u64,
    count: usize,
    context: *mut c_void,
    body: Option<unsafe extern "C" fn(*mut c_void, usize)>,
) {
    /// A pointer that the plugin's own functions share among threads.
    #[derive(Clone, Copy)]
    struct Context(*mut c_void);
    // SAFETY: the host never follows it, and the plugin asked for its use on several threads.
    unsafe impl Send for Context {}
    // SAFETY: as above.
    unsafe impl Sync for Context {}
    impl Context {
        fn get(self) -> *mut c_void {
            self.0
        }
    }
    let Some(body) = body else { return };
    let context = Context(context);
    // SAFETY: the plugin's own function, with what it gave for it.
    let call = move |index| unsafe { body(context.get(), index) };
    if rayon::current_thread_index().is_none() {
        (0..count).for_each(call);
    } else {
        (0..count).into_par_iter().for_each(call);
    }
}

unsafe extern "C" fn allocate(id: u64, bytes: usize) -> *mut c_void {
    with(id, |live, running| live.allocate(&running.job, bytes)).flatten().unwrap_or(std::ptr::null_mut())
}

unsafe extern "C" fn free(id: u64, memory: *mut c_void) {
    with(id, |live, _| live.free(memory));
}

unsafe extern "C" fn input_path(id: u64, name: OrographText, path: *mut OrographText) -> i32 {
    // SAFETY: the text stays until this returns, as the ABI says.
    let name = unsafe { lossy(name) };
    let found = with(id, |live, running| match running.job.input_path(&InputPath(name)) {
        Ok(found) => match found.into_os_string().into_string() {
            Ok(found) => Some(keep_path(live, found)),
            Err(found) => {
                live.fail(Error::reading(found.display(), "its name is no UTF-8, which no plugin can read"));
                None
            }
        },
        Err(error) => {
            live.fail(error);
            None
        }
    });
    match found.flatten() {
        Some(text) if !path.is_null() => {
            // SAFETY: not null, and the plugin's to be written, as the ABI says.
            unsafe { *path = text };
            OROGRAPH_OK
        }
        _ => OROGRAPH_FAILED,
    }
}

fn keep_path(live: &LiveJob, path: String) -> OrographText {
    let mut state = live.state();
    // The bytes of a text stay where they are when the list of texts grows.
    let text = OrographText::of(&path);
    state.paths.push(path);
    text
}

/// A text as well as it can be read.
///
/// # Safety
/// As [`read_text`].
unsafe fn lossy(text: OrographText) -> String {
    // SAFETY: as the caller vouches.
    unsafe { read_text(text) }.map_or_else(|malformed| malformed.0, str::to_owned)
}

/// A fault of the plugin.
pub(super) fn defect(message: impl Into<String>) -> Error {
    Error::invalid(message, "this is a defect of the plugin: report it to its author")
}
