//! Scanning: what a plugin says of itself, learnt in a process of its own and remembered by content.

use std::{
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use orograph_abi::PluginSpec;
use orograph_core::Digest;
use serde::{Deserialize, Serialize};

use super::{
    examine::examine,
    library::{Library, MOST_TEXT},
    program::Program,
    store::Store,
};
use crate::whole::write_whole;

/// How long a plugin may take to say what it is.
const PATIENCE: Duration = Duration::from_secs(10);

/// What a scan learnt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Scan {
    /// It is a plugin.
    Sound(Description),
    /// It is none, or none for here, and why.
    Refused(String),
}

/// A plugin as it describes itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Description {
    pub(super) spec: PluginSpec,
    /// Whether it checks settings against each other.
    pub(super) checks: bool,
    /// Whether it tells halos.
    pub(super) tells_halo: bool,
    /// Whether it tells costs.
    pub(super) tells_cost: bool,
    /// Whether it lifts parameters of older versions.
    pub(super) upgrades: bool,
}

impl Description {
    fn of(library: &Library) -> Self {
        let settings = library.settings;
        Self {
            spec: library.spec.clone(),
            checks: settings.is_some_and(|settings| settings.check.is_some()),
            tells_halo: settings.is_some_and(|settings| settings.halo.is_some()),
            tells_cost: settings.is_some_and(|settings| settings.cost.is_some()),
            upgrades: settings.is_some_and(|settings| settings.upgrade.is_some()),
        }
    }
}

/// What a scan found, and the private copy of the file that was scanned.
pub(super) struct Scanned {
    pub(super) digest: Digest,
    pub(super) copy: PathBuf,
    pub(super) scan: Scan,
}

/// Scans the library at `path`, or remembers what an earlier scan of the same content learnt.
///
/// # Errors
/// When the file or the store cannot be read or written.
pub(super) fn scan(path: &Path, store: &Store, program: &Program, again: bool) -> io::Result<Scanned> {
    let (digest, copy) = store.copy(path, again)?;
    let known = if again { None } else { store.scan(&digest) };
    let scan = match known {
        Some(scan) => scan,
        None => {
            let scan = match examine(&fs::read(&copy)?) {
                Ok(()) => in_child(&copy, program)?,
                Err(reason) => Scan::Refused(reason),
            };
            store.put_scan(&digest, &scan);
            scan
        }
    };
    Ok(Scanned { digest, copy, scan })
}

fn in_child(copy: &Path, program: &Program) -> io::Result<Scan> {
    let folder = tempfile::tempdir()?;
    let result = folder.path().join("scan.ron");
    let mut command: Command = program.command("scan");
    command.arg(copy).arg(&result);
    // What a plugin prints while it is loaded is no output of this program.
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn()?;
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if started.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            return Ok(Scan::Refused(format!(
                "it did not say within {} s what it is, and was stopped",
                PATIENCE.as_secs()
            )));
        }
        thread::sleep(Duration::from_millis(2));
    };
    let scan = read_answer(&result).and_then(|text| ron::from_str(&text).ok());
    Ok(match scan {
        Some(scan) if status.success() => scan,
        _ => Scan::Refused(format!("it ended the process that looked at it: {}", ending(status))),
    })
}

/// What the child wrote, whose code is a stranger's: no more of it than a spec may take, written as text within text.
fn read_answer(file: &Path) -> Option<String> {
    let most = 2 * MOST_TEXT as u64;
    let mut text = String::new();
    fs::File::open(file).ok()?.take(most).read_to_string(&mut text).ok()?;
    Some(text)
}

/// The child's part: loads the library and writes what it says.
///
/// # Errors
/// When the result cannot be written.
pub(super) fn serve(library: &Path, result: &Path) -> io::Result<()> {
    let scan = match Library::load(library) {
        Ok(library) => Scan::Sound(Description::of(&library)),
        Err(reason) => Scan::Refused(reason),
    };
    let text = ron::to_string(&scan).map_err(io::Error::other)?;
    write_whole(result.parent().unwrap_or(Path::new("")), result, &[text.as_bytes()])
}

/// How a process ended, in words.
pub(super) fn ending(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        if let Some(signal) = status.signal() {
            let name = signal_hook::low_level::signal_name(signal).unwrap_or("a signal");
            let meaning = match name {
                "SIGSEGV" | "SIGBUS" => ", it used memory that is not its own",
                "SIGABRT" => ", it gave up",
                "SIGILL" => ", it ran into code that there is not",
                "SIGFPE" => ", it divided a whole number by zero",
                "SIGKILL" => ", it was killed",
                _ => "",
            };
            return format!("{name}{meaning}");
        }
    }
    status.code().map_or_else(|| status.to_string(), |code| format!("exit code {code}"))
}
