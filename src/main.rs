//! `orograph`: the command line.
//!
//! Results go to standard output, everything else to standard error. Exit codes: 0 all outputs written, 1 a
//! node failed, 2 the graph or the command line is wrong, 3 cancelled.

mod arguments;
mod commands;
mod console;
mod failure;
mod manifest;
mod progress;
mod session;
mod trace;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};

fn main() -> ExitCode {
    // A panic inside a node becomes that node's error; its backtrace is nobody's reading.
    std::panic::set_hook(Box::new(|_| {}));
    orograph_session::outlive_file_size_limit();
    if let Some(code) = orograph_session::plugins::serve(std::env::args_os().skip(1)) {
        return code;
    }
    let arguments = Arguments::parse();
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
