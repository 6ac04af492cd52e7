//! `orograph`: the command line.
//!
//! Results go to standard output, everything else to standard error. Exit codes: 0 all outputs written, 1 a
//! node failed, 2 the graph or the command line is wrong, 3 cancelled.

mod arguments;
mod commands;
mod console;
mod failure;
mod manifest;
mod plugins;
mod progress;
mod session;
mod size;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};

fn main() -> ExitCode {
    // A panic inside a node becomes that node's error; its backtrace is nobody's reading.
    std::panic::set_hook(Box::new(|_| {}));
    outlive_file_size_limit();
    let arguments = Arguments::parse();
    if let Command::PluginHost { request } = &arguments.command {
        return orograph_engine::plugin::serve(request);
    }
    let result = std::panic::catch_unwind(|| match arguments.command {
        Command::Run(options) => commands::run::run(&options),
        Command::Check(options) => commands::check::run(&options),
        Command::Nodes(options) => commands::nodes::run(&options),
        Command::Sweep(options) => commands::sweep::run(&options),
        Command::Graph(options) => commands::graph::run(&options),
        Command::Cache(options) => commands::cache::run(&options),
        Command::Plugin(options) => commands::plugin::run(&options.action),
        Command::Manual(options) => commands::manual::run(&options),
        Command::Completions { shell } => commands::completions::run(shell),
        Command::PluginHost { .. } => Ok(()),
    });
    match result {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(failure)) => failure.report(),
        Err(_) => {
            console::error("orograph met a defect of its own and stopped; please report it with the graph");
            ExitCode::FAILURE
        }
    }
}

/// Makes a write beyond the limit on file sizes an error, as on a full disk, instead of the process's end.
#[cfg(unix)]
fn outlive_file_size_limit() {
    // Whoever handles the signal lives; that it came, the failing write tells.
    let came = std::sync::Arc::default();
    // Failing that, the limit ends the process, as it does by default.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, came);
}

#[cfg(not(unix))]
fn outlive_file_size_limit() {}
