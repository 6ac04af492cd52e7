//! Evaluation beside the window: what is wished to be seen is computed on threads of its own and told as news.
//!
//! A new edit starts a new round and then ends the old one. Both go through one evaluator, which computes each thing
//! once for everyone who wants it, so what the edit did not touch goes on.

mod sight;

use std::{
    collections::VecDeque,
    path::PathBuf,
    sync::{
        Arc, Condvar, Mutex, PoisonError,
        mpsc::{self, Receiver, Sender},
    },
    time::{Duration, Instant},
};

use orograph_core::{Context, Value};
use orograph_engine::{
    CancelToken, CompileOptions, Compiled, Document, DocumentErrors, Evaluator, Registry, compile,
    document::{Link, read_file},
};

use orograph_session::Targets;

use crate::{
    beside::Beside,
    looks::Scale,
    operations::part,
    teller::{Teller, Work, outermost},
};

/// Something that is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// By what name the answer is known.
    pub name: String,
    /// The output that it is about.
    pub output: Link,
    /// The node type that makes a picture of it, when that is wished.
    pub look: Option<String>,
    /// What the picture shows besides: what it is compared with, or the terrain that it lies on.
    pub beside: Beside,
    /// Settings that replace those of the document, as `orograph run --set` takes them.
    pub overrides: Vec<(String, String)>,
}

/// The document and what running it depends on besides.
#[derive(Clone)]
pub struct Scene {
    /// The document.
    pub document: Arc<Document>,
    /// Its folder.
    pub folder: PathBuf,
    /// Seed and resolution.
    pub context: Context,
}

/// Something that is wrong, in words, and the mend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The node that it is about, when it is about one.
    pub node: Option<String>,
    /// What is wrong.
    pub message: String,
    /// What would mend it.
    pub help: Option<String>,
}

impl Fault {
    /// What is wrong, and the mend where there is one.
    #[must_use]
    pub fn words(&self) -> String {
        match &self.help {
            Some(help) => format!("{}: {help}", self.message),
            None => self.message.clone(),
        }
    }
}

/// What a wish came to.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The value of the output.
    pub value: Value,
    /// The picture of it, when one was wished.
    pub picture: Option<Value>,
    /// What it is compared with, or the terrain that it lies on.
    pub beside: Option<Value>,
    /// The picture of that terrain alone.
    pub ground: Option<Value>,
    /// What the colours of the picture mean.
    pub scale: Option<Scale>,
}

/// How a node stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Badge {
    /// It runs; the share that is done.
    Running(f64),
    /// It is there: how it came there, how long it took in this run, and how much it is.
    Done {
        /// How: `computed`, `memory`, `disk`, `cutoff`.
        how: &'static str,
        /// Microseconds.
        micros: u64,
        /// Bytes of all outputs.
        bytes: u64,
        /// What it told.
        warnings: Vec<String>,
    },
    /// It failed.
    Failed(Fault),
}

/// What a runner tells.
#[derive(Debug)]
pub enum News {
    /// What is wrong with the document as a whole; nothing when it is sound.
    Faults(Vec<Fault>),
    /// How a node stands.
    Node(String, Badge),
    /// A wish was met, or why it was not.
    Shown(String, Result<Shown, Vec<Fault>>),
    /// Share of all wishes that is done.
    Progress(f64),
    /// Nothing is left to do.
    Idle,
    /// Share of a build that is done.
    Building(f64),
    /// A build is over: the files that it wrote, relative to the output folder, or what went wrong.
    Built(Result<Vec<String>, Vec<Fault>>),
}

/// Runs documents beside the window.
pub struct Runner {
    evaluator: Arc<Evaluator>,
    registry: Arc<Registry>,
    wake: Arc<dyn Fn() + Send + Sync>,
    sender: Sender<(u64, News)>,
    news: Receiver<(u64, News)>,
    round: u64,
    /// Tokens of rounds that go on, the newest last, and when they were overtaken.
    rounds: VecDeque<(CancelToken, Option<Instant>)>,
    build: Option<CancelToken>,
    running: Arc<(Mutex<usize>, Condvar)>,
}

/// The number of news that no later round overtakes.
const ALWAYS: u64 = 0;

/// How long an overtaken round goes on, so that the new one can join what both want.
const OVERLAP: Duration = Duration::from_millis(60);

impl Runner {
    /// A runner over an evaluator; `wake` is called, from any thread, when there is news.
    #[must_use]
    pub fn new(
        evaluator: Arc<Evaluator>,
        registry: Arc<Registry>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Self {
        let (sender, news) = mpsc::channel();
        let running = Arc::new((Mutex::new(0), Condvar::new()));
        Self {
            evaluator,
            registry,
            wake,
            sender,
            news,
            round: 0,
            rounds: VecDeque::new(),
            build: None,
            running,
        }
    }

    /// The evaluator.
    #[must_use]
    pub fn evaluator(&self) -> &Arc<Evaluator> {
        &self.evaluator
    }

    /// Takes other node types for what is begun from now on, as after plugins came or went.
    pub fn use_registry(&mut self, registry: Arc<Registry>) {
        self.registry = registry;
    }

    /// Begins to meet wishes, in their order, and gives up those of earlier calls.
    pub fn show(&mut self, scene: Scene, wishes: Vec<Wish>) {
        self.overtake();
        self.round += 1;
        let token = CancelToken::new();
        self.rounds.push_back((token.clone(), None));
        let round = self.begin(self.round, token);
        self.spawn(move || {
            round.run(&scene, &wishes);
            round.tell(News::Idle);
        });
    }

    /// Runs the document as `orograph run` does: every writer writes into `out`, at the seed and resolution of the
    /// scene. `history` names the document in the record of runs.
    pub fn build(&mut self, scene: Scene, out: PathBuf, history: Option<String>) {
        let token = CancelToken::new();
        if let Some(before) = self.build.replace(token.clone()) {
            before.cancel();
        }
        let round = self.begin(ALWAYS, token);
        self.spawn(move || {
            let built = round.build(&scene, out, history);
            round.tell(News::Built(built));
        });
    }

    fn begin(&self, number: u64, token: CancelToken) -> Round {
        Round {
            number,
            evaluator: self.evaluator.clone(),
            registry: self.registry.clone(),
            sender: self.sender.clone(),
            wake: self.wake.clone(),
            token,
        }
    }

    fn spawn(&self, work: impl FnOnce() + Send + 'static) {
        let running = self.running.clone();
        *running.0.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        let thread = std::thread::Builder::new().name("round".into());
        let spawned = thread.spawn(move || {
            work();
            *running.0.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
            running.1.notify_all();
        });
        if let Err(error) = spawned {
            *self.running.0.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
            let fault = Fault { node: None, message: format!("cannot start a thread: {error}"), help: None };
            let _ = self.sender.send((ALWAYS, News::Faults(vec![fault])));
        }
    }

    /// Gives up what is under way, a build as well.
    pub fn stop(&mut self) {
        let build = self.build.take();
        for token in self.rounds.drain(..).map(|(token, _)| token).chain(build) {
            token.cancel();
        }
    }

    fn overtake(&mut self) {
        let now = Instant::now();
        for (_, overtaken) in &mut self.rounds {
            overtaken.get_or_insert(now);
        }
    }

    /// The news of the newest round that came since the last call. To be called in every frame.
    pub fn news(&mut self) -> Vec<News> {
        let round = self.round;
        self.rounds.retain(|(token, overtaken)| {
            let over = overtaken.is_some_and(|since| since.elapsed() >= OVERLAP);
            if over {
                token.cancel();
            }
            !over
        });
        if self.rounds.len() > 1 {
            // Someone has to come back to end the overtaken ones.
            (self.wake)();
        }
        self.news
            .try_iter()
            .filter(|(number, _)| [round, ALWAYS].contains(number))
            .map(|(_, news)| news)
            .collect()
    }

    /// Waits until no round is under way.
    pub fn wait(&self) {
        let mut running = self.running.0.lock().unwrap_or_else(PoisonError::into_inner);
        while *running > 0 {
            running = self.running.1.wait(running).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        self.stop();
    }
}

struct Round {
    number: u64,
    evaluator: Arc<Evaluator>,
    registry: Arc<Registry>,
    sender: Sender<(u64, News)>,
    wake: Arc<dyn Fn() + Send + Sync>,
    token: CancelToken,
}

impl Round {
    fn tell(&self, news: News) {
        // Nobody listens any more when the window is gone.
        let _ = self.sender.send((self.number, news));
        (self.wake)();
    }

    fn teller(&self, work: Work) -> Arc<Teller> {
        let (sender, wake) = (self.sender.clone(), self.wake.clone());
        Arc::new(Teller { number: self.number, work, sender, wake })
    }

    fn compile(
        &self,
        document: &Document,
        scene: &Scene,
        overrides: &[(String, String)],
    ) -> Result<Compiled, DocumentErrors> {
        let (base_dir, overrides) = (scene.folder.clone(), overrides.to_vec());
        let options = CompileOptions { base_dir, overrides, loader: &|path| read_file(path) };
        compile(document, &self.registry, &options)
    }

    fn run(&self, scene: &Scene, wishes: &[Wish]) {
        let whole = self.compile(&scene.document, scene, &[]);
        self.tell(News::Faults(match &whole {
            Ok(compiled) => missing(compiled),
            Err(errors) => faults(errors),
        }));
        for (met, wish) in wishes.iter().enumerate() {
            if self.token.is_cancelled() {
                return;
            }
            let work = Work::Wish { met, of: wishes.len() };
            let result = match &whole {
                Ok(compiled) if wish.overrides.is_empty() => self.meet(wish, work, compiled, scene),
                // What is wrong elsewhere does not matter here.
                _ => {
                    let mut nodes = vec![wish.output.node.as_str()];
                    if let Beside::Against(other) = &wish.beside {
                        nodes.push(&other.node);
                    }
                    let part = part(&scene.document, &nodes);
                    self.compile(&part, scene, &wish.overrides)
                        .map_err(|errors| faults(&errors))
                        .and_then(|compiled| self.meet(wish, work, &compiled, scene))
                }
            };
            if !self.token.is_cancelled() {
                self.tell(News::Shown(wish.name.clone(), result));
                self.tell(work.share(1.0));
            }
        }
    }

    fn build(&self, scene: &Scene, out: PathBuf, history: Option<String>) -> Result<Vec<String>, Vec<Fault>> {
        let compiled = self.compile(&scene.document, scene, &[]).map_err(|errors| faults(&errors))?;
        let targets = Targets::choose(compiled, &[], &self.registry).map_err(|error| match &error {
            orograph_session::Error::Graph(errors) => faults(errors),
            other => {
                let help = other.help().map(str::to_owned);
                vec![Fault { node: None, message: other.to_string(), help }]
            }
        })?;
        let request = targets.into_request(scene.context, out, history);
        let report = self.evaluator.run(request, self.teller(Work::Build), &self.token);
        self.evaluator.flush();
        let failures: Vec<_> = report
            .failures()
            .map(|(node, error)| Fault {
                node: Some(outermost(&node.name).to_owned()),
                message: error.to_string(),
                help: error.hint(),
            })
            .collect();
        if !failures.is_empty() {
            return Err(failures);
        }
        Ok(report
            .nodes
            .iter()
            .flat_map(|node| &node.files)
            .map(|file| file.name.display().to_string())
            .collect())
    }
}

fn fault(error: &orograph_engine::DocumentError) -> Fault {
    Fault {
        node: error.node().map(str::to_owned),
        message: error.message().to_owned(),
        help: error.help_text().map(str::to_owned),
    }
}

fn faults(errors: &DocumentErrors) -> Vec<Fault> {
    errors.errors().iter().map(fault).collect()
}

/// Placeholders are no fault of the document, but their nodes cannot run.
fn missing(compiled: &Compiled) -> Vec<Fault> {
    compiled.missing.values().map(fault).collect()
}
