//! The host's side.

use std::{
    fs::File,
    io,
    os::{
        fd::{AsFd, OwnedFd},
        unix::net::UnixStream,
    },
    path::{Path, PathBuf},
    process::{Child, Stdio},
    sync::{
        Mutex, PoisonError,
        mpsc::{Receiver, RecvTimeoutError, channel},
    },
    thread,
    time::{Duration, Instant},
};

use orograph_core::{CellSize, Error, InputPath, Job, NodeSpec, ParamValue, RawParams, Result, Slot, Value};

use super::{
    Limits,
    message::{Ask, Fault, Hello, Port, Task, Tell, receive, send},
    shared::{SharedFile, Writer, take},
};
use crate::plugin::{host::defect, node::Calls, program::Program, scan::ending};

/// How often a waiting thread looks whether the run was cancelled.
const LOOK: Duration = Duration::from_millis(10);
/// How long a node may take to stop by itself once it was cancelled.
const GRACE: Duration = Duration::from_millis(70);

/// The processes of one plugin: as many as nodes of it run at once.
pub(in crate::plugin) struct Workers {
    library: PathBuf,
    program: Program,
    limits: Limits,
    idle: Mutex<Vec<Worker>>,
}

impl Workers {
    pub(in crate::plugin) fn new(library: PathBuf, program: Program, limits: Limits) -> Self {
        Self { library, program, limits, idle: Mutex::default() }
    }

    fn ask<T>(&self, ask: &Ask, read: impl FnOnce(Tell) -> Option<T>) -> Result<T> {
        self.with_worker(|worker| {
            let tell = worker.exchange(ask, None, &self.limits)?;
            read(tell).ok_or_else(|| worker.confused())
        })
    }

    /// Lends an idle worker, or a new one, and takes it back unless it is lost.
    fn with_worker<T>(&self, act: impl FnOnce(&mut Worker) -> Result<T>) -> Result<T> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut worker = match idle {
            Some(worker) => worker,
            None => Worker::start(&self.library, &self.program, &self.limits)?,
        };
        let result = act(&mut worker);
        if !worker.lost {
            self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(worker);
        }
        result
    }
}

impl Calls for Workers {
    fn run(
        &self,
        (node, spec): (u32, &NodeSpec),
        params: &[ParamValue],
        slots: &[Slot],
        job: &Job,
    ) -> Result<Vec<Value>> {
        self.with_worker(|worker| {
            let lost = |error: io::Error| Error::writing("the plugin's inputs", error);
            let mut writer = Writer::new(&worker.inputs);
            let mut put = |value: &Value| writer.put(value).map_err(lost);
            let ports = slots
                .iter()
                .map(|slot| {
                    Ok(match slot {
                        Slot::Empty => Port::Empty,
                        Slot::One(value) => Port::One(put(value)?),
                        Slot::Many(values) => Port::Many(values.iter().map(&mut put).collect::<Result<_>>()?),
                    })
                })
                .collect::<Result<_>>()?;
            let bytes = writer.end();
            if worker.inputs.metadata().map_err(lost)?.len() < bytes {
                worker.inputs.set_len(bytes).map_err(lost)?;
            }
            worker.task += 1;
            let ask = Ask::Run(Task {
                number: worker.task,
                cancelled: job.check().is_err(),
                node,
                params: params.to_vec(),
                ports,
                bytes,
                seed: job.seed(),
                resolution: job.resolution(),
                value_limit: job.memory_limit(),
                memory: self.limits.memory,
                files: files(spec, params, job),
            });
            let Tell::Ran(ran) = worker.exchange(&ask, Some(job), &self.limits)? else {
                return Err(worker.confused());
            };
            let spans = ran.map_err(Fault::into_error)?;
            let values: Vec<_> =
                spans.into_iter().map(|span| take(&worker.outputs, span, job)).collect::<Result<_>>()?;
            Ok(values)
        })
    }

    fn check(&self, node: u32, params: &[ParamValue]) -> Result<()> {
        self.ask(&Ask::Check { node, params: params.to_vec() }, |tell| match tell {
            Tell::Checked(checked) => Some(checked.map_err(Fault::into_error)),
            _ => None,
        })?
    }

    fn halo(&self, node: u32, params: &[ParamValue], cell: CellSize) -> Result<usize> {
        self.ask(&Ask::Halo { node, params: params.to_vec(), cell: (cell.x, cell.y) }, |tell| match tell {
            Tell::Halo(cells) => Some(usize::try_from(cells).unwrap_or(usize::MAX)),
            _ => None,
        })
    }

    fn cost(&self, node: u32, params: &[ParamValue]) -> Result<f64> {
        self.ask(&Ask::Cost { node, params: params.to_vec() }, |tell| match tell {
            Tell::Cost(cost) => Some(cost),
            _ => None,
        })
    }

    fn upgrade(&self, node: u32, from: u32, params: &mut RawParams) -> Result<()> {
        let ask = Ask::Upgrade { node, from, params: params.0.clone() };
        let upgraded = self.ask(&ask, |tell| match tell {
            Tell::Upgraded(upgraded) => Some(upgraded.map_err(Fault::into_error)),
            _ => None,
        })?;
        params.0 = upgraded?;
        Ok(())
    }
}

/// Where the files lie that the settings name; what cannot be found is told when the node asks for it.
fn files(spec: &NodeSpec, params: &[ParamValue], job: &Job) -> Vec<(String, Result<PathBuf, Fault>)> {
    let named = spec.input_files(params).map(|(_, name)| name.to_owned());
    named.map(|name| (name.clone(), job.input_path(&InputPath(name)).map_err(Fault::from))).collect()
}

/// A process that holds the plugin.
struct Worker {
    child: Child,
    line: UnixStream,
    tells: Receiver<Tell>,
    inputs: File,
    outputs: File,
    /// The number of the last task that it was given.
    task: u64,
    /// Not to be used again.
    lost: bool,
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Worker {
    fn start(library: &Path, program: &Program, limits: &Limits) -> Result<Self> {
        let failed = |error: io::Error| {
            Error::invalid(
                format!("no process could be started for the plugin: {error}"),
                "check the system's limits on processes and open files",
            )
        };
        let shared = || SharedFile::new().map_err(failed);
        let (inputs, outputs) = (shared()?, shared()?);
        let (line, child, tells) = spawn(library, program).map_err(failed)?;
        let mut worker =
            Self { child, line, tells, inputs: inputs.file, outputs: outputs.file, task: 0, lost: false };
        let (inputs, outputs) = (inputs.path, outputs.path);
        let threads = rayon::current_num_threads();
        let hello = Hello { library: library.to_owned(), inputs, outputs, threads };
        send(&mut worker.line, &hello).map_err(failed)?;
        match worker.wait(None, limits)? {
            Tell::Ready => Ok(worker),
            Tell::Unloadable(reason) => Err(defect(reason)),
            _ => Err(worker.confused()),
        }
    }

    fn exchange(&mut self, ask: &Ask, job: Option<&Job>, limits: &Limits) -> Result<Tell> {
        if send(&mut self.line, ask).is_err() {
            return Err(self.ended(limits));
        }
        self.wait(job, limits)
    }

    /// The worker's answer, while it may take its time, be cancelled, or end.
    fn wait(&mut self, job: Option<&Job>, limits: &Limits) -> Result<Tell> {
        let started = Instant::now();
        let mut heard = started;
        let mut cancelled = None;
        loop {
            match self.tells.recv_timeout(LOOK) {
                Ok(Tell::Alive) => heard = Instant::now(),
                Ok(Tell::Progress(done)) => {
                    heard = Instant::now();
                    job.inspect(|job| job.progress(done));
                }
                Ok(Tell::Warn(message)) => {
                    job.inspect(|job| job.warn(message));
                }
                Ok(Tell::Note(message)) => {
                    job.inspect(|job| job.note(message));
                }
                Ok(tell) => return Ok(tell),
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended(limits)),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if job.is_some_and(|job| job.check().is_err()) {
                let since = *cancelled.get_or_insert_with(|| {
                    // If the line is broken, the next look tells.
                    let _ = send(&mut self.line, &Ask::Cancel { task: self.task });
                    Instant::now()
                });
                if since.elapsed() > GRACE {
                    self.lost = true;
                    return Err(Error::Cancelled);
                }
            }
            if heard.elapsed() > limits.silence {
                let hint = "it hangs, or never asks whether to stop: report it to its author, or raise `--isolate-silence`";
                return Err(
                    self.stopped(&format!("was not heard of for {} s", limits.silence.as_secs()), hint)
                );
            }
            if let Some(time) = limits.time.filter(|time| started.elapsed() > *time) {
                let hint = "ask less of it, or raise `--isolate-timeout`";
                return Err(self.stopped(&format!("ran for more than {} s", time.as_secs()), hint));
            }
        }
    }

    fn stopped(&mut self, why: &str, hint: &str) -> Error {
        self.lost = true;
        Error::Crashed { how: format!("it {why} and was stopped"), hint: hint.into() }
    }

    fn ended(&mut self, limits: &Limits) -> Error {
        self.lost = true;
        let how = match self.child.wait() {
            Ok(status) => ending(status),
            Err(error) => error.to_string(),
        };
        let limit = limits.memory;
        Error::Crashed {
            how,
            hint: format!(
                "report it to the plugin's author; it may take {limit} bytes beyond its inputs, which `--isolate-memory` raises"
            ),
        }
    }

    fn confused(&mut self) -> Error {
        self.lost = true;
        defect("the plugin's process answered what it was not asked")
    }
}

/// Starts a process that waits for a [`Hello`], and hears it.
fn spawn(library: &Path, program: &Program) -> io::Result<(UnixStream, Child, Receiver<Tell>)> {
    let (line, theirs) = UnixStream::pair()?;
    let mut command = program.command("work");
    // The name serves who looks at the list of processes. What the plugin prints is no result of the run.
    command.arg(library).stdin(OwnedFd::from(theirs));
    command.stdout(Stdio::from(io::stderr().as_fd().try_clone_to_owned()?)).stderr(Stdio::inherit());
    let child = command.spawn()?;
    let mut incoming = line.try_clone()?;
    let (sender, tells) = channel();
    thread::spawn(move || {
        while let Ok(tell) = receive(&mut incoming) {
            if sender.send(tell).is_err() {
                break;
            }
        }
    });
    Ok((line, child, tells))
}
