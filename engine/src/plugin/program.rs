//! The program that looks at plugins and runs them apart: this one, started again.

use std::{
    ffi::{OsStr, OsString},
    io,
    path::{Path, PathBuf},
    process::{Command, ExitCode},
};

use super::scan;

/// How to start the program that [`serve`] is called in.
#[derive(Clone, Debug)]
pub struct Program {
    /// The executable.
    pub executable: PathBuf,
    /// What leads to [`serve`]; the request follows.
    pub arguments: Vec<OsString>,
}

impl Program {
    /// A command for one of the requests that [`serve`] knows.
    pub(super) fn command(&self, request: &str) -> Command {
        let mut command = Command::new(&self.executable);
        command.args(&self.arguments).arg(request);
        command
    }
}

/// Serves a request of a [`Program`]: what a front end does for the arguments that follow [`Program::arguments`].
#[must_use]
pub fn serve(arguments: &[OsString]) -> ExitCode {
    let request = arguments.first().map(OsString::as_os_str);
    let served = if request == Some(OsStr::new("scan")) {
        match arguments {
            [_, library, result] => scan::serve(Path::new(library), Path::new(result)),
            _ => Err(io::ErrorKind::InvalidInput.into()),
        }
    } else if request == Some(OsStr::new("work")) {
        super::isolate::serve()
    } else {
        Err(io::ErrorKind::InvalidInput.into())
    };
    if served.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
