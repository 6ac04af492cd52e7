//! The worker's side.

use std::{
    collections::BTreeMap,
    fs::{File, OpenOptions},
    io,
    os::{fd::AsFd, unix::net::UnixStream},
    path::PathBuf,
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
        mpsc::{Receiver, channel},
    },
    thread,
    time::Instant,
};

use memmap2::MmapOptions;
use orograph_abi::Cells;
use orograph_core::{CellSize, Context, Error, Host, Job, OutputStream, RawParams, Result, Slot, Value};
use rayon::{ThreadPool, ThreadPoolBuilder};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use super::{
    message::{Ask, Fault, Hello, Port, Task, Tell, receive, send},
    shared::{Span, Writer},
};
use crate::plugin::{library::Library, live::Keep};

/// Serves a host until it goes away. Its end of the line is standard input.
pub(in crate::plugin) fn serve() -> io::Result<()> {
    let line = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let mut incoming = line.try_clone()?;
    let hello: Hello = receive(&mut incoming)?;
    let tell = Arc::new(Mutex::new(line));
    // A crash of the plugin is no news; a file of its memory is of no use.
    let _ = setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
    let files = (File::open(&hello.inputs)?, OpenOptions::new().write(true).open(&hello.outputs)?);
    let library = match Library::load(&hello.library) {
        Ok(library) => library,
        Err(reason) => return say(&tell, &Tell::Unloadable(reason)),
    };
    let pool = ThreadPoolBuilder::new().num_threads(hello.threads).build().map_err(io::Error::other)?;
    say(&tell, &Tell::Ready)?;
    let cancelled = Arc::new(AtomicU64::new(0));
    let asks = listen(incoming, Arc::clone(&cancelled));
    let worker = Worker { library, pool, inputs: files.0, outputs: files.1, tell, cancelled };
    for ask in asks {
        worker.serve(ask)?;
    }
    Ok(())
}

fn say(line: &Mutex<UnixStream>, tell: &Tell) -> io::Result<()> {
    send(&mut *line.lock().unwrap_or_else(PoisonError::into_inner), tell)
}

/// Hears the host while nodes run: a cancel must not wait, and without a host there is nothing left to do.
fn listen(mut incoming: UnixStream, cancelled: Arc<AtomicU64>) -> Receiver<Ask> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        loop {
            let heard = match receive(&mut incoming) {
                Ok(Ask::Cancel { task }) => {
                    cancelled.store(task, Ordering::Relaxed);
                    true
                }
                Ok(ask) => sender.send(ask).is_ok(),
                Err(_) => false,
            };
            if !heard {
                process::exit(0);
            }
        }
    });
    receiver
}

struct Worker {
    library: Library,
    pool: ThreadPool,
    inputs: File,
    outputs: File,
    tell: Arc<Mutex<UnixStream>>,
    /// The number of the last task that was cancelled.
    cancelled: Arc<AtomicU64>,
}

impl Worker {
    fn serve(&self, ask: Ask) -> io::Result<()> {
        let library = &self.library;
        let told = match ask {
            Ask::Run(task) => Tell::Ran(self.run(&task).map_err(Fault::from)),
            Ask::Check { node, params } => Tell::Checked(library.check(node, &params).map_err(Fault::from)),
            Ask::Halo { node, params, cell: (x, y) } => {
                Tell::Halo(library.halo(node, &params, CellSize { x, y }) as u64)
            }
            Ask::Cost { node, params } => Tell::Cost(library.cost(node, &params)),
            Ask::Upgrade { node, from, params } => {
                let mut params = RawParams(params);
                let upgraded = library.upgrade(node, from, &mut params);
                Tell::Upgraded(upgraded.map(|()| params.0).map_err(Fault::from))
            }
            Ask::Cancel { .. } => return Ok(()),
        };
        say(&self.tell, &told)
    }

    fn run(&self, task: &Task) -> Result<Vec<Span>> {
        let unreadable = |error: io::Error| Error::reading("the plugin's inputs", error);
        limit_memory(task.memory);
        let map = if task.bytes == 0 {
            None
        } else {
            let mut options = MmapOptions::new();
            // SAFETY: the host changes the file between tasks alone, and never makes it shorter.
            let map = unsafe { options.len(task.bytes as usize).populate().map(&self.inputs) };
            Some(map.map_err(unreadable)?)
        };
        let bytes: &[u8] = map.as_deref().unwrap_or(&[]);
        // SAFETY: a longer lifetime than it has: the values over it are dropped before the map is.
        let bytes = unsafe { std::mem::transmute::<&[u8], &'static [u8]>(bytes) };
        let slots = slots(&task.ports, bytes)?;
        let host = WorkerHost {
            worker: self,
            task,
            told: Mutex::default(),
            beat: AtomicU64::new(0),
            started: Instant::now(),
        };
        let job = Job::new(&host, Context { seed: task.seed, resolution: task.resolution });
        let spans = Spans(Mutex::new((Writer::new(&self.outputs), BTreeMap::new())));
        let run = || self.library.run_into(task.node, &task.params, &slots, &job, &spans);
        self.pool.install(run)?;
        drop(slots);
        drop(map);
        let (_, spans) = spans.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(spans.into_values().collect())
    }
}

/// Outputs, written where the host reads them while the plugin lends them.
struct Spans<'a>(Mutex<(Writer<'a>, BTreeMap<usize, Span>)>);

impl Keep for Spans<'_> {
    fn cells(&self) -> Cells {
        Cells::Lent
    }
    fn keep(&self, port: usize, value: Value) -> Result<()> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (writer, spans) = &mut *kept;
        let span = writer.put(&value).map_err(|error| Error::writing("the plugin's outputs", error))?;
        spans.insert(port, span);
        Ok(())
    }
}

fn slots(ports: &[Port], bytes: &'static [u8]) -> Result<Vec<Slot>> {
    let value = |span: &Span| {
        let part = |start: u64, len: u64| bytes.get(start as usize..)?.get(..len as usize);
        let parts = part(span.head, span.head_len).zip(part(span.payload, span.payload_len));
        parts.and_then(|(head, payload)| Value::decode_lent(head, payload).ok()).ok_or_else(|| {
            Error::invalid("the plugin's inputs did not reach its process", "report it with the graph")
        })
    };
    ports
        .iter()
        .map(|port| {
            Ok(match port {
                Port::Empty => Slot::Empty,
                Port::One(span) => Slot::One(value(span)?),
                Port::Many(spans) => Slot::Many(spans.iter().map(value).collect::<Result<_>>()?),
            })
        })
        .collect()
}

/// Bounds what the process may take from here on. Where the system cannot tell what it has, there is no bound.
///
/// What counts is memory that can be written. Bounding addresses would count what threads reserve and never use.
fn limit_memory(more: u64) {
    let Ok(pages) = std::fs::read_to_string("/proc/self/statm") else { return };
    let Some(pages) = pages.split_whitespace().nth(5).and_then(|pages| pages.parse::<u64>().ok()) else {
        return;
    };
    let has = pages.saturating_mul(rustix::param::page_size() as u64);
    let maximum = getrlimit(Resource::Data).maximum;
    let _ = setrlimit(Resource::Data, Rlimit { current: Some(has.saturating_add(more)), maximum });
}

/// The host of a node, far away.
struct WorkerHost<'a> {
    worker: &'a Worker,
    task: &'a Task,
    told: Mutex<Option<Instant>>,
    /// Seconds since the start when it last told that it is alive, and one more.
    beat: AtomicU64,
    started: Instant,
}

impl WorkerHost<'_> {
    fn say(&self, tell: &Tell) {
        // Without a host the listening thread ends the process.
        let _ = say(&self.worker.tell, tell);
    }
}

impl Host for WorkerHost<'_> {
    fn cancelled(&self) -> bool {
        let second = self.started.elapsed().as_secs() + 1;
        if self.beat.swap(second, Ordering::Relaxed) != second {
            self.say(&Tell::Alive);
        }
        self.task.cancelled || self.worker.cancelled.load(Ordering::Relaxed) == self.task.number
    }
    fn progress(&self, done: f64) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.is_none_or(|told| told.elapsed().as_millis() >= 50) {
            *told = Some(Instant::now());
            self.say(&Tell::Progress(done));
        }
    }
    fn warn(&self, message: &str) {
        self.say(&Tell::Warn(message.into()));
    }
    fn note(&self, message: &str) {
        self.say(&Tell::Note(message.into()));
    }
    fn memory_limit(&self) -> u64 {
        self.task.value_limit
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        match self.task.files.iter().find(|(name, _)| name == path) {
            Some((_, Ok(found))) => Ok(found.clone()),
            Some((_, Err(Fault::Other { message, hint }))) => Err(Error::invalid(message, hint)),
            _ => Err(Error::reading(path, "no parameter of the node names it")),
        }
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Err(Error::writing(path, "a plugin's node writes no files"))
    }
}
