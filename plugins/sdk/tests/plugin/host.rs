//! A host that is no Orograph: it calls through the exported struct and writes down what it hears.

use std::{
    collections::BTreeMap,
    ffi::{CStr, c_char, c_void},
    ptr,
    sync::{
        Mutex, MutexGuard,
        atomic::{AtomicU64, Ordering},
    },
};

use orograph_plugin::{ParamValue, Slot, Value, abi::*};

/// What the host heard of a job.
#[derive(Default)]
pub struct Heard {
    pub outputs: BTreeMap<u32, Value>,
    pub failure: Option<(String, String)>,
    pub warnings: Vec<String>,
    pub progress: Vec<f64>,
}

static JOBS: Mutex<BTreeMap<u64, Heard>> = Mutex::new(BTreeMap::new());

fn jobs() -> MutexGuard<'static, BTreeMap<u64, Heard>> {
    JOBS.lock().unwrap()
}

/// How the host treats a job.
#[derive(Clone, Copy)]
pub struct Manner {
    pub cancel: bool,
    pub refuse_outputs: bool,
    pub threads: u32,
    pub memory_limit: u64,
    pub size: u32,
}

impl Default for Manner {
    fn default() -> Self {
        let size = size_of::<OrographJob>() as u32;
        Self { cancel: false, refuse_outputs: false, threads: 3, memory_limit: 1 << 20, size }
    }
}

// The manner of a job lies in its id, so that the host's functions know it without more state.
fn id_of(manner: Manner) -> u64 {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let flags = u64::from(manner.cancel) | u64::from(manner.refuse_outputs) << 1;
    COUNT.fetch_add(1, Ordering::Relaxed) << 32 | u64::from(manner.threads) << 8 | flags
}

unsafe fn owned(text: OrographText) -> String {
    unsafe { read_text(text) }.unwrap().to_owned()
}

unsafe extern "C" fn cancelled(job: u64) -> i32 {
    // A job that has ended counts as cancelled.
    i32::from(job & 1 == 1 || !jobs().contains_key(&job))
}
unsafe extern "C" fn progress(job: u64, done: f64) {
    if let Some(heard) = jobs().get_mut(&job) {
        heard.progress.push(done);
    }
}
unsafe extern "C" fn log(job: u64, level: i32, message: OrographText) {
    assert_eq!(level, OROGRAPH_LOG_WARNING);
    let message = unsafe { owned(message) };
    if let Some(heard) = jobs().get_mut(&job) {
        heard.warnings.push(message);
    }
}
unsafe extern "C" fn fail(job: u64, message: OrographText, hint: OrographText) {
    let told = unsafe { (owned(message), owned(hint)) };
    if let Some(heard) = jobs().get_mut(&job) {
        heard.failure.get_or_insert(told);
    }
}
unsafe extern "C" fn output(job: u64, port: u32, value: *const OrographValue) -> i32 {
    if job & 2 == 2 {
        return OROGRAPH_FAILED;
    }
    let value = unsafe { read_value(value, Cells::Copied) }.unwrap();
    assert!(jobs().get_mut(&job).unwrap().outputs.insert(port, value).is_none(), "output {port} twice");
    OROGRAPH_OK
}
unsafe extern "C" fn count(job: u64) -> u32 {
    (job >> 8) as u32 & 0xff
}
unsafe extern "C" fn parallel_for(
    _: u64,
    _: usize,
    _: *mut c_void,
    _: Option<unsafe extern "C" fn(*mut c_void, usize)>,
) {
    unreachable!("Rust has its own pool");
}
unsafe extern "C" fn input_path(_: u64, name: OrographText, path: *mut OrographText) -> i32 {
    if unsafe { owned(name) } != "data/there.tif" {
        return OROGRAPH_FAILED;
    }
    unsafe { *path = OrographText::of("/somewhere/data/there.tif") };
    OROGRAPH_OK
}
unsafe extern "C" fn extension(name: *const c_char) -> *const c_void {
    static THREADS_TABLE: OrographThreads =
        OrographThreads { size: size_of::<OrographThreads>() as u32, reserved: 0, count, parallel_for };
    static FILES_TABLE: OrographFiles =
        OrographFiles { size: size_of::<OrographFiles>() as u32, reserved: 0, input_path };
    let name = unsafe { CStr::from_ptr(name) };
    if name == THREADS {
        ptr::from_ref(&THREADS_TABLE).cast()
    } else if name == FILES {
        ptr::from_ref(&FILES_TABLE).cast()
    } else {
        ptr::null()
    }
}

static HOST: OrographHost = OrographHost {
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

/// Runs a node of the plugin.
pub fn run(
    plugin: &OrographPlugin,
    node: u32,
    params: &[ParamValue],
    slots: &[Slot],
    manner: Manner,
) -> (i32, Heard) {
    let id = id_of(manner);
    jobs().insert(id, Heard::default());
    let mut lender = Lender::new();
    let (params, inputs) = (lender.params(params), lender.inputs(slots));
    let job = OrographJob {
        size: manner.size,
        node,
        id,
        host: &HOST,
        param_count: params.len(),
        params: params.as_ptr(),
        input_count: inputs.len(),
        inputs: inputs.as_ptr(),
        seed: 7,
        resolution: 512,
        reserved: 0,
        memory_limit: manner.memory_limit,
    };
    let status = unsafe { plugin.run.unwrap()(&job) };
    (status, jobs().remove(&id).unwrap())
}

/// The plugin's answer to a question about settings.
pub fn reply(ask: impl FnOnce(*const OrographReply) -> i32) -> (i32, Option<(String, String)>) {
    unsafe extern "C" fn put(context: *mut c_void, text: OrographText, hint: OrographText) {
        unsafe { *context.cast::<Option<(String, String)>>() = Some((owned(text), owned(hint))) };
    }
    let mut answer: Option<(String, String)> = None;
    let reply = OrographReply { context: ptr::from_mut(&mut answer).cast(), put };
    let status = ask(&reply);
    (status, answer)
}

/// The plugin's settings extension.
pub fn settings(plugin: &OrographPlugin) -> OrographSettings {
    let ask = plugin.extension.unwrap();
    unsafe {
        assert!(ask(c"orograph.nothing/1".as_ptr()).is_null());
        assert!(ask(ptr::null()).is_null());
        *ask(SETTINGS.as_ptr()).cast::<OrographSettings>()
    }
}
