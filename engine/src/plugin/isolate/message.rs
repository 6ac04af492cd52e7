//! Messages between the host and a worker: a length, then postcard.

use std::{
    collections::BTreeMap,
    io::{self, Read, Write},
    path::PathBuf,
};

use orograph_core::{Error, ParamValue};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::shared::Span;

/// What a worker is to be.
#[derive(Serialize, Deserialize)]
pub(super) struct Hello {
    pub(super) library: PathBuf,
    pub(super) inputs: PathBuf,
    pub(super) outputs: PathBuf,
    pub(super) threads: usize,
}

/// What the host asks.
#[derive(Serialize, Deserialize)]
pub(super) enum Ask {
    Run(Task),
    Check {
        node: u32,
        params: Vec<ParamValue>,
    },
    Halo {
        node: u32,
        params: Vec<ParamValue>,
        cell: (f64, f64),
    },
    Cost {
        node: u32,
        params: Vec<ParamValue>,
    },
    Upgrade {
        node: u32,
        from: u32,
        params: BTreeMap<String, ParamValue>,
    },
    /// Stop that task, if it is still under way.
    Cancel {
        task: u64,
    },
}

/// One run of one node.
#[derive(Serialize, Deserialize)]
pub(super) struct Task {
    /// Its number, from 1.
    pub(super) number: u64,
    /// Whether it was cancelled before it began.
    pub(super) cancelled: bool,
    pub(super) node: u32,
    pub(super) params: Vec<ParamValue>,
    pub(super) ports: Vec<Port>,
    /// Length of the file of inputs.
    pub(super) bytes: u64,
    pub(super) seed: u64,
    pub(super) resolution: Option<u32>,
    /// Bytes that one value may take.
    pub(super) value_limit: u64,
    /// Bytes that the worker may take.
    pub(super) memory: u64,
    /// Where the files lie that the parameters name.
    pub(super) files: Vec<(String, Result<PathBuf, Fault>)>,
}

/// What is connected to a port.
#[derive(Serialize, Deserialize)]
pub(super) enum Port {
    Empty,
    One(Span),
    Many(Vec<Span>),
}

/// What a worker tells.
#[derive(Serialize, Deserialize)]
pub(super) enum Tell {
    Ready,
    Unloadable(String),
    Ran(Result<Vec<Span>, Fault>),
    Checked(Result<(), Fault>),
    Halo(u64),
    Cost(f64),
    Upgraded(Result<BTreeMap<String, ParamValue>, Fault>),
    Progress(f64),
    Warn(String),
    Note(String),
    /// The node asked whether to stop.
    Alive,
}

/// A node's error.
#[derive(Serialize, Deserialize)]
pub(super) enum Fault {
    Cancelled,
    Panicked(String),
    Other { message: String, hint: String },
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        match error {
            Error::Cancelled => Self::Cancelled,
            Error::Panicked { message } => Self::Panicked(message),
            other => Self::Other { message: other.to_string(), hint: other.hint().unwrap_or_default() },
        }
    }
}

impl Fault {
    pub(super) fn into_error(self) -> Error {
        match self {
            Self::Cancelled => Error::Cancelled,
            Self::Panicked(message) => Error::Panicked { message },
            Self::Other { message, hint } => Error::Invalid { message, hint },
        }
    }
}

/// A message longer than this is none.
const MOST: u32 = 1 << 30;

pub(super) fn send(to: &mut impl Write, message: &impl Serialize) -> io::Result<()> {
    let mut bytes = postcard::to_extend(message, vec![0; 4]).map_err(io::Error::other)?;
    let len = u32::try_from(bytes.len() - 4).ok().filter(|len| *len <= MOST);
    let len = len.ok_or_else(|| io::Error::from(io::ErrorKind::FileTooLarge))?;
    bytes[..4].copy_from_slice(&len.to_le_bytes());
    to.write_all(&bytes)
}

pub(super) fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut len = [0; 4];
    from.read_exact(&mut len)?;
    let len = u32::from_le_bytes(len);
    if len > MOST {
        return Err(io::ErrorKind::InvalidData.into());
    }
    // As much as comes, so that a false length takes no memory.
    let mut bytes = Vec::new();
    from.take(u64::from(len)).read_to_end(&mut bytes)?;
    if bytes.len() != len as usize {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    postcard::from_bytes(&bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}
