//! Makes the system fail under a program: loaded into it before anything else, it lets one of the calls fail by which
//! the program changes files, or lets every write be short.
//!
//! Wrapping the functions of the C library would miss the calls that Rust crates make past it. So the kernel is told
//! (seccomp) to hand these calls to a signal handler, which fails them or makes them itself; a mark in the sixth
//! register, which none of them has an argument in, tells the kernel to let those through.
//!
//! What it does stands in the environment: `FAULT_WHERE`, a word in the paths that count; `FAULT_AT`, which of the
//! counted calls fails: `5` that one alone, `5-` that one and all that follow, `0` none; `FAULT_WITH`, the error's
//! number, or 0 for short writes; `FAULT_LOG`, a file that gets a line for each counted call.
//!
//! Linux on x86-64 alone. `tests/injected` builds and loads it; it is no part of any program.

use std::{
    arch::asm,
    env,
    ffi::{CString, c_int, c_ulong, c_void},
    slice,
    sync::atomic::{AtomicBool, AtomicI64, AtomicUsize, Ordering::SeqCst},
};

#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
compile_error!("knows the registers of Linux on x86-64 alone");

/// In the sixth register of the calls made here: any number that no program would have there.
const MARK: u32 = 0x51ca_11ed;

const WRITE: i64 = 1;
const OPEN: i64 = 2;
const READLINK: i64 = 89;
const OPENAT: i64 = 257;
/// Calls whose first argument is an open file.
const OF_FILES: [(i64, &str); 9] = [
    (WRITE, "write"),
    (18, "pwrite"),
    (20, "writev"),
    (74, "fsync"),
    (75, "fdatasync"),
    (77, "ftruncate"),
    (91, "fchmod"),
    (285, "fallocate"),
    (296, "pwritev"),
];
/// Calls on paths, and which argument is the path at which something is made or changed.
const OF_PATHS: [(i64, &str, usize); 10] = [
    (OPEN, "open", 0),
    (OPENAT, "open", 1),
    (82, "rename", 1),
    (264, "rename", 3),
    (316, "rename", 3),
    (83, "mkdir", 0),
    (258, "mkdir", 1),
    (86, "link", 1),
    (265, "link", 3),
    (90, "chmod", 0),
];
/// Flags of `open`: to write, to read and write, to make what is not there.
const CHANGES: u32 = 0o1 | 0o2 | 0o100;

static COUNT: AtomicUsize = AtomicUsize::new(0);
static AT: AtomicUsize = AtomicUsize::new(0);
static AND_ON: AtomicBool = AtomicBool::new(false);
static WITH: AtomicI64 = AtomicI64::new(0);
static LOG: AtomicI64 = AtomicI64::new(-1);
/// Address and length of the word in paths.
static WORD: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// `struct sigaction` of glibc.
#[repr(C)]
struct Action {
    handler: extern "C" fn(c_int, *mut c_void, *mut c_void),
    mask: [u64; 16],
    flags: c_int,
    restorer: usize,
}

/// `struct sock_filter`.
#[repr(C)]
struct Step {
    code: u16,
    yes: u8,
    no: u8,
    value: u32,
}

/// `struct sock_fprog`.
#[repr(C)]
struct Steps {
    len: u16,
    first: *const Step,
}

unsafe extern "C" {
    fn sigaction(signal: c_int, new: *const Action, old: *mut Action) -> c_int;
    fn prctl(option: c_int, a: c_ulong, b: c_ulong, c: c_ulong, d: c_ulong) -> c_int;
    fn _exit(code: c_int) -> !;
}

/// Runs before `main`.
#[used]
#[unsafe(link_section = ".init_array")]
static BEGIN: extern "C" fn() = begin;

extern "C" fn begin() {
    let Ok(word) = env::var("FAULT_WHERE") else { return };
    let word: &'static str = word.leak();
    WORD[0].store(word.as_ptr().addr(), SeqCst);
    WORD[1].store(word.len(), SeqCst);
    let at = env::var("FAULT_AT").unwrap_or_default();
    let first = at.strip_suffix('-');
    AND_ON.store(first.is_some(), SeqCst);
    AT.store(first.unwrap_or(&at).parse().unwrap_or(0), SeqCst);
    WITH.store(env::var("FAULT_WITH").ok().and_then(|with| with.parse().ok()).unwrap_or(0), SeqCst);
    if let Some(log) = env::var("FAULT_LOG").ok().and_then(|log| CString::new(log).ok()) {
        /// To write at the end, made when it is not there, closed when another program begins.
        const FLAGS: u64 = 0o1 | 0o100 | 0o2000 | 0o2_000_000;
        LOG.store(call(OPEN, [log.as_ptr().addr() as u64, FLAGS, 0o644, 0, 0]), SeqCst);
    }
    if !hand_over() {
        // Going on would look like a run that met no fault.
        // SAFETY: ends the process.
        unsafe { _exit(99) };
    }
}

/// Has the kernel hand the calls to the handler.
fn hand_over() -> bool {
    const LOAD: u16 = 0x20;
    const EQUAL: u16 = 0x15;
    const ANY_BIT: u16 = 0x45;
    const ANSWER: u16 = 0x06;
    const X86_64: u32 = 0xc000_003e;
    // Places in `struct seccomp_data`.
    const NUMBER: u32 = 0;
    const MACHINE: u32 = 4;
    const fn argument(index: u32) -> u32 {
        16 + 8 * index
    }
    let step = |code, value, yes, no| Step { code, yes, no, value };
    let mut steps = vec![
        step(LOAD, MACHINE, 0, 0),
        step(EQUAL, X86_64, 1, 0),
        step(ANSWER, 0x7fff_0000, 0, 0),
        step(LOAD, argument(5), 0, 0),
        step(EQUAL, MARK, 0, 1),
        step(ANSWER, 0x7fff_0000, 0, 0),
        step(LOAD, NUMBER, 0, 0),
        // A file that is opened to be read passes.
        step(EQUAL, OPEN as u32, 0, 4),
        step(LOAD, argument(1), 0, 0),
        step(ANY_BIT, CHANGES, 0, 1),
        step(ANSWER, 0x0003_0000, 0, 0),
        step(ANSWER, 0x7fff_0000, 0, 0),
        step(EQUAL, OPENAT as u32, 0, 4),
        step(LOAD, argument(2), 0, 0),
        step(ANY_BIT, CHANGES, 0, 1),
        step(ANSWER, 0x0003_0000, 0, 0),
        step(ANSWER, 0x7fff_0000, 0, 0),
    ];
    let numbers = OF_FILES.iter().map(|of| of.0).chain(OF_PATHS.iter().map(|of| of.0));
    for number in numbers.filter(|number| ![OPEN, OPENAT].contains(number)) {
        steps.push(step(EQUAL, number as u32, 0, 1));
        steps.push(step(ANSWER, 0x0003_0000, 0, 0));
    }
    steps.push(step(ANSWER, 0x7fff_0000, 0, 0));
    let steps = Steps { len: steps.len() as u16, first: steps.leak().as_ptr() };
    const SIGSYS: c_int = 31;
    /// With the registers, and while another is handled.
    const FLAGS: c_int = 0x4 | 0x4000_0000;
    let action = Action { handler: handle, mask: [0; 16], flags: FLAGS, restorer: 0 };
    // SAFETY: the structs are as glibc and the kernel have them, and the steps stay.
    unsafe {
        sigaction(SIGSYS, &action, std::ptr::null_mut()) == 0
            // No new privileges, then mode 2: a filter.
            && prctl(38, 1, 0, 0, 0) == 0
            && prctl(22, 2, (&raw const steps).addr() as c_ulong, 0, 0) == 0
    }
}

/// Makes a call that the kernel lets through.
fn call(number: i64, [a, b, c, d, e]: [u64; 5]) -> i64 {
    let result;
    // SAFETY: the arguments are those of a call that the program makes, or of one made here.
    unsafe {
        asm!("syscall", inlateout("rax") number => result, in("rdi") a, in("rsi") b, in("rdx") c, in("r10") d,
            in("r8") e, in("r9") u64::from(MARK), lateout("rcx") _, lateout("r11") _);
    }
    result
}

/// Stands in for the kernel: the registers hold the call, and take its result.
extern "C" fn handle(_: c_int, _: *mut c_void, context: *mut c_void) {
    // SAFETY: glibc's `ucontext_t` has its 23 registers there.
    let registers = unsafe { &mut *context.cast::<u8>().add(40).cast::<[i64; 23]>() };
    let number = registers[13];
    // rdi, rsi, rdx, r10, r8
    let mut arguments = [8, 9, 12, 2, 0].map(|register| registers[register] as u64);
    registers[13] = match fault(number, &mut arguments) {
        Some(error) => -error,
        None => call(number, arguments),
    };
}

/// Counts the call where it is one that counts. Its error where it is to fail; a write may become a shorter one.
fn fault(number: i64, arguments: &mut [u64; 5]) -> Option<i64> {
    let mut link = [0_u8; 4096];
    let (name, path): (&str, &[u8]) =
        if let Some((_, name, index)) = OF_PATHS.iter().find(|of| of.0 == number) {
            // SAFETY: the program gave the path to the kernel.
            (name, unsafe { std::ffi::CStr::from_ptr(arguments[*index] as *const _) }.to_bytes())
        } else {
            let name = OF_FILES.iter().find(|of| of.0 == number)?.1;
            (name, path_of(arguments[0], &mut link))
        };
    // SAFETY: text that was leaked when this began.
    let word = unsafe { slice::from_raw_parts(WORD[0].load(SeqCst) as *const u8, WORD[1].load(SeqCst)) };
    if !path.windows(word.len().max(1)).any(|part| part == word) {
        return None;
    }
    let count = COUNT.fetch_add(1, SeqCst) + 1;
    let at = AT.load(SeqCst);
    let with = WITH.load(SeqCst);
    let mut hit = at > 0 && (count == at || (AND_ON.load(SeqCst) && count > at));
    if hit && with == 0 {
        hit = matches!(name, "write" | "pwrite") && arguments[2] > 1;
        if hit {
            arguments[2] = arguments[2].div_ceil(2).min(4096);
        }
    }
    log(&[name.as_bytes(), if hit { b" faulty " } else { b" sound " }, path, b"\n"]);
    (hit && with != 0).then_some(with)
}

/// The path of an open file.
fn path_of(file: u64, place: &mut [u8; 4096]) -> &[u8] {
    let mut name = *b"/proc/self/fd/\0\0\0\0\0\0\0\0\0\0\0";
    let mut digits = [0; 10];
    let (mut rest, mut len) = (file as u32, 0);
    while len == 0 || rest > 0 {
        digits[len] = b'0' + (rest % 10) as u8;
        (rest, len) = (rest / 10, len + 1);
    }
    for (index, digit) in digits[..len].iter().rev().enumerate() {
        name[14 + index] = *digit;
    }
    let size = place.len() as u64;
    let read = call(READLINK, [name.as_ptr().addr() as u64, place.as_mut_ptr().addr() as u64, size, 0, 0]);
    &place[..usize::try_from(read).unwrap_or(0)]
}

/// Writes a line at once, so that those of several threads do not mix.
fn log(parts: &[&[u8]]) {
    let file = LOG.load(SeqCst);
    let (mut line, mut len) = ([0_u8; 4096 + 64], 0);
    for part in parts {
        line[len..len + part.len()].copy_from_slice(part);
        len += part.len();
    }
    if file >= 0 {
        call(WRITE, [file as u64, line.as_ptr().addr() as u64, len as u64, 0, 0]);
    }
}
