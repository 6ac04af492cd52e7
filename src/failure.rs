//! Why a command ends without success, and with which exit code.

use std::process::ExitCode;

use orograph_engine::{DocumentError, DocumentErrors};
use orograph_session::Error;

use crate::console;

/// The end of a command that did not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A node failed; it was told already.
    Node,
    /// The graph is wrong.
    Graph(Box<DocumentErrors>),
    /// The command line is wrong, or what it needs is not to be had.
    Usage {
        /// What is wrong.
        message: String,
        /// What would mend it.
        hint: String,
    },
    /// Something beside the graph failed.
    Other(String),
    /// The user stopped it.
    Cancelled,
}

impl Failure {
    pub(crate) fn usage(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Usage { message: message.into(), hint: hint.into() }
    }

    /// Tells the user, whose command goes on.
    pub(crate) fn tell(self) {
        self.report();
    }

    /// Tells the user and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::Node => ExitCode::from(1),
            Self::Other(message) => {
                console::error(&message);
                ExitCode::from(1)
            }
            Self::Graph(errors) => {
                console::document_errors(&errors);
                ExitCode::from(2)
            }
            Self::Usage { message, hint } => {
                console::error(&message);
                console::hint(&hint);
                ExitCode::from(2)
            }
            Self::Cancelled => {
                console::error("cancelled");
                ExitCode::from(3)
            }
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Graph(errors) => errors.into(),
            Error::Refused { message, help } => Self::Usage { message, hint: help },
            Error::Failed(message) => Self::Other(message),
        }
    }
}

impl From<DocumentErrors> for Failure {
    fn from(errors: DocumentErrors) -> Self {
        Self::Graph(Box::new(errors))
    }
}

impl From<DocumentError> for Failure {
    fn from(error: DocumentError) -> Self {
        DocumentErrors::from(error).into()
    }
}
