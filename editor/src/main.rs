//! The node editor's window.

use std::{
    path::PathBuf,
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use clap::Parser;
use eframe::egui;
use etcetera::BaseStrategy;
use orograph_editor::{App, Dialogs, NoDialogs, Question, Start};
use orograph_session::{PluginOptions, Settings};

/// The node editor of Orograph.
#[derive(Parser)]
#[command(name = "orograph-editor", version)]
struct Arguments {
    /// The graph file to open
    graph: Option<PathBuf>,
    /// The folder that builds write into
    #[arg(long, default_value = "out", value_name = "DIR")]
    out: PathBuf,
    /// A folder of plugins; may be given many times
    #[arg(long, value_name = "DIR")]
    plugins: Vec<PathBuf>,
    /// Run every plugin in a process of its own
    #[arg(long)]
    isolate: bool,
    /// The cache folder, or `none` to keep results in memory alone
    #[arg(long, value_name = "DIR|none")]
    cache: Option<PathBuf>,
}

fn main() -> ExitCode {
    orograph_session::outlive_file_size_limit();
    if let Some(code) = orograph_session::plugins::serve(std::env::args_os().skip(1)) {
        return code;
    }
    let arguments = Arguments::parse();
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            #[expect(clippy::print_stderr, reason = "there is no window to tell it in")]
            {
                eprintln!("error: {message}");
            }
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), String> {
    let mut notes = Vec::new();
    let settings = Settings::load().unwrap_or_else(|error| {
        notes.push(error.in_words());
        Settings::default()
    });
    let cache = settings.cache_folder(arguments.cache.as_deref());
    let options = PluginOptions {
        folders: arguments.plugins,
        isolate: arguments.isolate,
        cache: cache.clone(),
        ..PluginOptions::default()
    };
    let (registry, found) =
        orograph_session::registry(&options, &settings).map_err(|error| error.to_string())?;
    notes.extend(found.iter().filter_map(orograph_session::plugins::complaint));
    let (evaluator, warning) = orograph_session::evaluator(settings.memory_budget(None), cache.as_deref(), 0)
        .map_err(|error| error.to_string())?;
    notes.extend(warning);
    let start = Start {
        registry: Arc::new(registry),
        found,
        plugins: Arc::new(move |settings| orograph_session::registry(&options, settings)),
        settings,
        settings_file: Settings::file(),
        evaluator: Arc::new(evaluator),
        file: arguments.graph,
        recoveries: recoveries(),
        out: arguments.out,
        notes,
        dialogs: dialogs(),
    };
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([1440.0, 900.0]).with_title("Orograph"),
        ..eframe::NativeOptions::default()
    };
    let create = move |creation: &eframe::CreationContext<'_>| {
        Ok(Box::new(App::new(&creation.egui_ctx, start)) as Box<dyn eframe::App>)
    };
    eframe::run_native("orograph-editor", options, Box::new(create)).map_err(|error| error.to_string())
}

/// Where unsaved work is kept.
fn recoveries() -> Option<PathBuf> {
    let base = etcetera::choose_base_strategy().ok()?;
    let state = base.state_dir().unwrap_or_else(|| base.data_dir());
    Some(state.join("orograph").join("unsaved"))
}

/// Hears in the log that there are no dialogs: the library for them says it there, and answers as if the user had
/// chosen nothing.
struct Ear(AtomicBool);

static EAR: Ear = Ear(AtomicBool::new(false));

impl log::Log for Ear {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() == log::Level::Error && metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            self.0.store(true, Ordering::Relaxed);
        }
    }

    fn flush(&self) {}
}

/// The system's own dialogs.
fn dialogs() -> Dialogs {
    if log::set_logger(&EAR).is_ok() {
        log::set_max_level(log::LevelFilter::Error);
    }
    Arc::new(|question, folder| {
        EAR.0.store(false, Ordering::Relaxed);
        let mut dialog = rfd::FileDialog::new();
        if let Ok(folder) = std::path::absolute(folder)
            && folder.is_dir()
        {
            dialog = dialog.set_directory(folder);
        }
        let chosen = match question {
            Question::Graph => dialog.add_filter("Graphs", &["ron"]).pick_file(),
            Question::Save => dialog.add_filter("Graphs", &["ron"]).save_file(),
            Question::Input => dialog.pick_file(),
            Question::Output => dialog.save_file(),
            Question::Folder => dialog.pick_folder(),
        };
        match chosen {
            None if EAR.0.load(Ordering::Relaxed) => Err(NoDialogs),
            chosen => Ok(chosen),
        }
    })
}
