//! The bytes of a file: all of them in memory, or each read when it is needed.

use std::{
    borrow::Cow,
    fs::File,
    io::{Read, Seek, SeekFrom},
    sync::{Mutex, PoisonError},
};

use orograph_core::prelude::*;

/// A file's bytes.
pub(super) enum Bytes<'a> {
    /// In memory.
    Memory(&'a [u8]),
    /// In an open file.
    File {
        /// The file; where it stands means nothing.
        file: Mutex<File>,
        /// Its length.
        len: u64,
        /// How the user knows it.
        shown: String,
    },
}

impl Bytes<'static> {
    /// The bytes of an open file that the user knows as `shown`.
    pub(super) fn of_file(file: File, shown: &str) -> Result<Self> {
        let len = file.metadata().map_err(|reason| Error::reading(shown, reason))?.len();
        Ok(Self::File { file: Mutex::new(file), len, shown: shown.to_owned() })
    }
}

impl Bytes<'_> {
    pub(super) fn len(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::File { len, .. } => *len,
        }
    }

    /// `len` bytes from `start` on; `None` where the file ends before.
    pub(super) fn get(&self, start: u64, len: u64) -> Result<Option<Cow<'_, [u8]>>> {
        let Some(end) = start.checked_add(len).filter(|&end| end <= self.len()) else { return Ok(None) };
        match self {
            Self::Memory(bytes) => Ok(bytes.get(start as usize..end as usize).map(Cow::Borrowed)),
            Self::File { file, shown, .. } => {
                let mut bytes = vec![0; len as usize];
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                let read = file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes));
                read.map_err(|reason| Error::reading(shown, reason))?;
                Ok(Some(Cow::Owned(bytes)))
            }
        }
    }
}
