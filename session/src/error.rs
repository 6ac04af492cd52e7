//! Why something cannot be had, and what would mend it.

use orograph_engine::{DocumentError, DocumentErrors};

/// Why something cannot be had. Its text says what is wrong, [`help`](Self::help) what would mend it.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Error {
    /// The graph is wrong.
    #[error("{0}")]
    Graph(DocumentErrors),
    /// What the user asked for, or wrote into the settings, cannot be done.
    #[error("{message}")]
    Refused {
        /// What is wrong.
        message: String,
        /// What would mend it.
        help: String,
    },
    /// The machine did not do its part.
    #[error("{0}")]
    Failed(String),
}

impl Error {
    /// What is wrong and what would mend it, in a line.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.help() {
            Some(help) => format!("{self}: {help}"),
            None => self.to_string(),
        }
    }

    pub(crate) fn refused(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Refused { message: message.into(), help: help.into() }
    }

    /// What would mend it; of a graph's errors the first one's.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        match self {
            Self::Graph(errors) => errors.errors().first()?.help_text(),
            Self::Refused { help, .. } => Some(help),
            Self::Failed(_) => None,
        }
    }
}

impl From<DocumentErrors> for Error {
    fn from(errors: DocumentErrors) -> Self {
        Self::Graph(errors)
    }
}

impl From<DocumentError> for Error {
    fn from(error: DocumentError) -> Self {
        DocumentErrors::from(error).into()
    }
}
