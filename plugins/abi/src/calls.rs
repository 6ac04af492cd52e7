//! The calls between host and plugin.
//!
//! Host functions take the job's id, not a pointer, so that a call after the end of the job is harmless: it is
//! ignored, or answered as if the job had been cancelled. Those called "from any thread" may be called from
//! several at once.

use std::ffi::{CStr, c_char, c_void};

use crate::{OrographInput, OrographParam, OrographText, OrographValue};

/// The name of the constant that a plugin exports.
pub const ENTRY: &CStr = c"orograph_plugin";

/// All went well.
pub const OROGRAPH_OK: i32 = 0;
/// It failed; say why with `fail` or the reply.
pub const OROGRAPH_FAILED: i32 = 1;
/// The job was cancelled and the node stopped.
pub const OROGRAPH_CANCELLED: i32 = 2;
/// The plugin's code panicked behind its own fence; say more with `fail`.
pub const OROGRAPH_PANICKED: i32 = 3;

/// A message that only who looks for faults wants to see.
pub const OROGRAPH_LOG_DEBUG: i32 = 0;
/// A message for who watches the run.
pub const OROGRAPH_LOG_INFO: i32 = 1;
/// A remark that is kept with the outputs and told again when they come from the cache.
pub const OROGRAPH_LOG_WARNING: i32 = 2;

/// What a plugin exports, as a constant named `orograph_plugin`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographPlugin {
    /// `sizeof(OrographPlugin)`.
    pub size: u32,
    /// `OROGRAPH_ABI_MAJOR` of the header that it was built with.
    pub abi_major: u32,
    /// `OROGRAPH_ABI_MINOR` of the header that it was built with.
    pub abi_minor: u32,
    /// 0.
    pub reserved: u32,
    /// Gives the plugin's name, version and nodes as RON text, which must stay valid and the same for as long as
    /// the plugin is loaded. Called from any thread.
    pub describe: Option<unsafe extern "C" fn() -> OrographText>,
    /// Runs a node: reads the job's parameters and inputs, hands each output to `host->output`, and returns
    /// `OROGRAPH_OK`, `OROGRAPH_FAILED`, `OROGRAPH_CANCELLED` or `OROGRAPH_PANICKED`. The job and all that it
    /// points to are valid until it returns. Called from any thread, and from several at once; equal jobs must
    /// give equal outputs to the bit. No exception may leave it.
    pub run: Option<unsafe extern "C" fn(job: *const OrographJob) -> i32>,
    /// Gives the plugin's side of a named extension, such as an `OrographSettings` for `orograph.settings/1`, valid
    /// for as long as the plugin is loaded; or null. `name` is terminated. May be null itself. Called from any thread.
    pub extension: Option<unsafe extern "C" fn(name: *const c_char) -> *const c_void>,
}

/// One run of one node.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographJob {
    /// `sizeof(OrographJob)` of the host: a field beyond it is not there.
    pub size: u32,
    /// Which node to run: its index in the list that `describe` gives.
    pub node: u32,
    /// The job's name in calls of host functions.
    pub id: u64,
    /// The host's functions.
    pub host: *const OrographHost,
    /// Number of parameters, as the spec says.
    pub param_count: usize,
    /// The parameters in the spec's order.
    pub params: *const OrographParam,
    /// Number of input ports, as the spec says.
    pub input_count: usize,
    /// The input ports in the spec's order.
    pub inputs: *const OrographInput,
    /// The run's seed; 0 unless the spec says that the node reads it.
    pub seed: u64,
    /// Cells along the longer side that generators should make; 0 unless the spec says that the node reads it and
    /// the run sets it.
    pub resolution: u32,
    /// 0.
    pub reserved: u32,
    /// The most bytes that one value may take.
    pub memory_limit: u64,
}

/// The host's functions. The table is valid for as long as the plugin is loaded.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographHost {
    /// `sizeof(OrographHost)` of the host: a function beyond it is not there.
    pub size: u32,
    /// `OROGRAPH_ABI_MAJOR` of the host.
    pub abi_major: u32,
    /// `OROGRAPH_ABI_MINOR` of the host.
    pub abi_minor: u32,
    /// 0.
    pub reserved: u32,
    /// Whether to stop: 1 once the run was cancelled. Ask at least every few milliseconds of work, and return
    /// `OROGRAPH_CANCELLED` when it says so. From any thread.
    pub cancelled: unsafe extern "C" fn(job: u64) -> i32,
    /// Tells how much of the work is done, from 0 to 1. From any thread.
    pub progress: unsafe extern "C" fn(job: u64, done: f64),
    /// Tells the user something; `level` is `OROGRAPH_LOG_DEBUG`, `OROGRAPH_LOG_INFO` or `OROGRAPH_LOG_WARNING`.
    /// The message is copied. From any thread.
    pub log: unsafe extern "C" fn(job: u64, level: i32, message: OrographText),
    /// Says why the job fails, and what the user can do about it, before `run` returns `OROGRAPH_FAILED`. Both are
    /// copied; `hint` may be empty. The first call counts. From any thread.
    pub fail: unsafe extern "C" fn(job: u64, message: OrographText, hint: OrographText),
    /// Hands over the value of output port `port`, once for each port of the spec, in any order. All that it points to
    /// is copied before this returns. Gives `OROGRAPH_OK`, or `OROGRAPH_FAILED` when the value is refused; then the
    /// job has failed, and the host knows why. From any thread.
    pub output: unsafe extern "C" fn(job: u64, port: u32, value: *const OrographValue) -> i32,
    /// Gives the host's side of a named extension: an `OrographThreads` for `orograph.threads/1`, an `OrographScratch`
    /// for `orograph.scratch/1`, an `OrographFiles` for `orograph.files/1`; or null where the host has none of that
    /// name. `name` is terminated. What it gives is valid for as long as the plugin is loaded. From any thread.
    pub extension: unsafe extern "C" fn(name: *const c_char) -> *const c_void,
}

/// Name of the host's extension [`OrographThreads`].
pub const THREADS: &CStr = c"orograph.threads/1";
/// Name of the host's extension [`OrographScratch`].
pub const SCRATCH: &CStr = c"orograph.scratch/1";
/// Name of the host's extension [`OrographFiles`].
pub const FILES: &CStr = c"orograph.files/1";
/// Name of the plugin's extension [`OrographSettings`].
pub const SETTINGS: &CStr = c"orograph.settings/1";

/// The host's extension `orograph.threads/1`: its thread pool.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographThreads {
    /// `sizeof(OrographThreads)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// How many threads the run may use, at least 1. From any thread.
    pub count: unsafe extern "C" fn(job: u64) -> u32,
    /// Calls `body(context, i)` once for each `i` below `count`, on the host's threads, in any order and several at
    /// once, and returns when all calls have. A result must not depend on their order. Called from the thread that
    /// `run` was called on or from inside another `body`; from elsewhere the calls come one after the other.
    /// `body` must not be null; no exception may leave it.
    pub parallel_for: unsafe extern "C" fn(
        job: u64,
        count: usize,
        context: *mut c_void,
        body: Option<unsafe extern "C" fn(context: *mut c_void, index: usize)>,
    ),
}

/// The host's extension `orograph.scratch/1`: memory that the host counts and frees at the end of the job.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographScratch {
    /// `sizeof(OrographScratch)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Gives `bytes` of zeroed memory, aligned to 64 bytes, until the job ends or `free`; null where the run may not
    /// take as much. From any thread.
    pub allocate: unsafe extern "C" fn(job: u64, bytes: usize) -> *mut c_void,
    /// Gives memory back before the job ends. A pointer that `allocate` did not give is ignored. From any thread.
    pub free: unsafe extern "C" fn(job: u64, memory: *mut c_void),
}

/// The host's extension `orograph.files/1`: the files that the node's parameters name.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographFiles {
    /// `sizeof(OrographFiles)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Where the file of a parameter of kind `InputPath` lies: `name` is the parameter's text, `path` becomes an
    /// absolute path in the system's own form, valid until the job ends. Gives `OROGRAPH_OK`, or `OROGRAPH_FAILED`
    /// when there is no such file; then the host knows why, and the node may just return `OROGRAPH_FAILED`. The
    /// content of the file counts in the node's key, so a node must read no other files. From any thread.
    pub input_path: unsafe extern "C" fn(job: u64, name: OrographText, path: *mut OrographText) -> i32,
}

/// Takes a plugin's answer to a question about settings.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographReply {
    /// To be handed back to `put`.
    pub context: *mut c_void,
    /// Copies an answer: for a refusal its message and hint, for new parameters their text and nothing. Called from
    /// the thread that was asked, before it returns.
    pub put: unsafe extern "C" fn(context: *mut c_void, text: OrographText, hint: OrographText),
}

/// The plugin's extension `orograph.settings/1`: what a node knows of its settings without running. Any function may
/// be null. All are called from any thread, and from several at once.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OrographSettings {
    /// `sizeof(OrographSettings)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Checks settings against each other, after the host has checked each against its range. `OROGRAPH_OK`, or
    /// `OROGRAPH_FAILED` after a `put` of message and hint.
    pub check: Option<
        unsafe extern "C" fn(
            node: u32,
            param_count: usize,
            params: *const OrographParam,
            reply: *const OrographReply,
        ) -> i32,
    >,
    /// For a node of extent `Local`: how many cells beyond its own position an output cell looks, on cells of this
    /// size in metres. 0 where it is null.
    pub halo: Option<
        unsafe extern "C" fn(
            node: u32,
            param_count: usize,
            params: *const OrographParam,
            cell_x: f64,
            cell_y: f64,
        ) -> u64,
    >,
    /// Rough work per cell relative to copying it; weighs the progress display. 1 where it is null.
    pub cost:
        Option<unsafe extern "C" fn(node: u32, param_count: usize, params: *const OrographParam) -> f64>,
    /// Lifts parameters of version `from` of the node to its own version. `params` is a RON map from name to value,
    /// such as `{"strength": Number(0.5)}`; the new map is `put` as text. `OROGRAPH_OK`, or `OROGRAPH_FAILED` after a
    /// `put` of message and hint. Where it is null, parameters keep name and meaning.
    pub upgrade: Option<
        unsafe extern "C" fn(node: u32, from: u32, params: OrographText, reply: *const OrographReply) -> i32,
    >,
}
