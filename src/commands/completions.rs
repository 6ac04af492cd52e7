//! `orograph completions`.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use crate::{arguments::Arguments, console, failure::Failure};

pub(crate) fn run(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    generate(shell, &mut Arguments::command(), "orograph", &mut script);
    console::result(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}
