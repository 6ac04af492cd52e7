//! The one error type of nodes and data: what went wrong, where, and what would mend it.

use crate::Unit;

/// The result of anything in this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a node could not produce its outputs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The run was cancelled; nothing is wrong.
    #[error("cancelled")]
    Cancelled,
    /// An input holds no cells or no items.
    #[error("{what} is empty")]
    EmptyInput {
        /// The input's name.
        what: String,
    },
    /// An input is smaller than the algorithm needs.
    #[error("{what} has {rows} × {cols} cells, but at least {min} × {min} are needed")]
    BadSize {
        /// The input's name.
        what: String,
        /// Its rows.
        rows: usize,
        /// Its columns.
        cols: usize,
        /// The least rows and columns.
        min: usize,
    },
    /// Every cell of an input is a void.
    #[error("{what} has no measured cell: every one is a void")]
    AllVoid {
        /// The input's name.
        what: String,
    },
    /// An input holds an infinite height.
    #[error("{what} holds an infinite height at row {row}, column {col}")]
    NonFinite {
        /// The input's name.
        what: String,
        /// The offending row.
        row: usize,
        /// The offending column.
        col: usize,
    },
    /// A parameter lies outside its hard range.
    #[error("`{name}` is {value}{}, outside its range {low} to {high}", suffix(.unit))]
    OutOfRange {
        /// The parameter's name.
        name: String,
        /// The value given.
        value: f64,
        /// The least value allowed.
        low: f64,
        /// The greatest value allowed.
        high: f64,
        /// The parameter's unit.
        unit: Unit,
    },
    /// A parameter has a value of the wrong type.
    #[error("`{name}` has a value of the wrong type")]
    ParamType {
        /// The parameter's name.
        name: String,
    },
    /// An input has a value of the wrong type, or none although it is needed.
    #[error("input `{name}` is missing or of the wrong type")]
    InputType {
        /// The port's name.
        name: String,
    },
    /// A node was given the wrong number of parameters.
    #[error("expected {expected} parameters, found {found}")]
    ParamCount {
        /// How many the spec has.
        expected: usize,
        /// How many came.
        found: usize,
    },
    /// A node was given the wrong number of inputs.
    #[error("expected {expected} inputs, found {found}")]
    PortCount {
        /// How many the spec has.
        expected: usize,
        /// How many came.
        found: usize,
    },
    /// Two grids that must match do not.
    #[error("{first} has {} × {} cells but {second} has {} × {}", .first_size.0, .first_size.1, .second_size.0, .second_size.1)]
    DimensionMismatch {
        /// The first input's name.
        first: String,
        /// Its rows and columns.
        first_size: (usize, usize),
        /// The second input's name.
        second: String,
        /// Its rows and columns.
        second_size: (usize, usize),
    },
    /// An iteration did not settle.
    #[error("no convergence after {steps} steps: the residual is still {residual:e}")]
    NotConverged {
        /// Steps taken.
        steps: u64,
        /// What was left.
        residual: f64,
    },
    /// More memory is wanted than the run may use.
    #[error("{what} would take {bytes} bytes, more than the {limit} allowed")]
    TooLarge {
        /// What is to be stored.
        what: String,
        /// Bytes wanted.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// The operating system refused to read or write.
    #[error("{action} {path}: {reason}")]
    Io {
        /// `reading` or `writing`.
        action: &'static str,
        /// The file.
        path: String,
        /// The system's words.
        reason: String,
    },
    /// A file is not what it should be.
    #[error("{path}: {reason}")]
    Format {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Settings or inputs that do not go together.
    #[error("{message}")]
    Invalid {
        /// What is wrong.
        message: String,
        /// What would mend it.
        hint: String,
    },
    /// The node's code panicked: a defect in the node, fenced off from the run.
    #[error("the node panicked: {message}")]
    Panicked {
        /// The panic's message.
        message: String,
    },
    /// The process that ran the node ended: a defect in the node, and no other node suffers.
    #[error("the plugin's process ended: {how}")]
    Crashed {
        /// How it ended.
        how: String,
        /// What would mend it.
        hint: String,
    },
}

fn suffix(unit: &Unit) -> String {
    if matches!(unit, Unit::One | Unit::Seed) { String::new() } else { format!(" {}", unit.symbol()) }
}

impl Error {
    /// An [`Error::Invalid`] from its two sentences.
    pub fn invalid(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Invalid { message: message.into(), hint: hint.into() }
    }

    /// An [`Error::Format`] about the file at `path`.
    pub fn format(path: impl std::fmt::Display, reason: impl std::fmt::Display) -> Self {
        Self::Format { path: path.to_string(), reason: reason.to_string() }
    }

    /// An [`Error::Io`] met while reading `path`.
    pub fn reading(path: impl std::fmt::Display, reason: impl std::fmt::Display) -> Self {
        Self::Io { action: "reading", path: path.to_string(), reason: reason.to_string() }
    }

    /// An [`Error::Io`] met while writing `path`.
    pub fn writing(path: impl std::fmt::Display, reason: impl std::fmt::Display) -> Self {
        Self::Io { action: "writing", path: path.to_string(), reason: reason.to_string() }
    }

    /// What the user can do about it, where there is something to do.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Cancelled | Self::ParamCount { .. } | Self::PortCount { .. } => return None,
            Self::EmptyInput { .. } => "connect an input that holds data",
            Self::BadSize { .. } => "use a larger crop or a higher resolution",
            Self::AllVoid { .. } => "check the nodata value of the source, or fill the voids first",
            Self::NonFinite { .. } => "declare that value as nodata in the source",
            Self::OutOfRange { low, high, .. } => {
                return Some(format!("choose a value from {low} to {high}"));
            }
            Self::ParamType { .. } => "`orograph nodes ID` lists each parameter with its type",
            Self::InputType { .. } => {
                "connect the port; `orograph nodes ID` lists the ports with their types"
            }
            Self::DimensionMismatch { .. } => "resize or crop one of them to the other's grid",
            Self::NotConverged { .. } => "allow more steps or a larger tolerance",
            Self::TooLarge { .. } => "lower the resolution, crop, or raise `--memory`",
            Self::Io { action: "writing", .. } => "check that you may write there and that the disk has room",
            Self::Io { .. } => "check that the path exists and that you may use it",
            Self::Format { .. } => "export the file again, or choose the reader for its format",
            Self::Invalid { hint, .. } | Self::Crashed { hint, .. } => {
                return Some(hint.clone()).filter(|hint| !hint.is_empty());
            }
            Self::Panicked { .. } => "this is a defect of the node: please report it with the graph",
        };
        Some(hint.to_owned())
    }
}
