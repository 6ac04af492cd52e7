//! The container: header, byte order, and the tags of the first image.

use std::borrow::Cow;

use orograph_core::prelude::*;

use super::bytes::Bytes;

/// A TIFF file's bytes with their byte order and the tags of the first image.
pub(super) struct Ifd<'a> {
    bytes: Bytes<'a>,
    name: String,
    /// Whether numbers are stored big-endian.
    pub(super) big_endian: bool,
    entries: Vec<Entry>,
}

/// One tag: `count` values of a type, at `start` in the file.
#[derive(Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u16,
    count: usize,
    start: usize,
}

impl<'a> Ifd<'a> {
    /// Parses the header and the first directory of a classic TIFF or BigTIFF.
    pub(super) fn parse(bytes: Bytes<'a>, name: &str) -> Result<Self> {
        let big_endian = match bytes.get(0, 2)?.as_deref() {
            Some(b"II") => false,
            Some(b"MM") => true,
            _ => return Err(Error::format(name, "this is no TIFF file")),
        };
        let mut ifd = Self { bytes, name: name.to_owned(), big_endian, entries: Vec::new() };
        let (entries, wide) = match ifd.unsigned(2, 2)? {
            42 => (ifd.unsigned(4, 4)?, false),
            43 if ifd.unsigned(4, 2)? == 8 => (ifd.unsigned(8, 8)?, true),
            other => return Err(Error::format(name, format!("TIFF version {other} is unknown"))),
        };
        let start = usize::try_from(entries).map_err(|_| ifd.truncated())?;
        let (count_len, word) = if wide { (8, 8) } else { (2, 4) };
        let entry_len = 4 + 2 * word;
        let count = ifd.unsigned(start, count_len)?;
        let room = usize::try_from(ifd.bytes.len()).unwrap_or(usize::MAX).saturating_sub(start) / entry_len;
        let count = usize::try_from(count).ok().filter(|&n| n <= room).ok_or_else(|| ifd.truncated())?;
        for i in 0..count {
            let at = start + count_len + i * entry_len;
            let (tag, kind) = (ifd.unsigned(at, 2)? as u16, ifd.unsigned(at + 2, 2)? as u16);
            let values = usize::try_from(ifd.unsigned(at + 4, word)?).map_err(|_| ifd.truncated())?;
            let inline = at + 4 + word;
            let len = size_of_kind(kind).and_then(|size| size.checked_mul(values));
            let Some(len) = len else { continue };
            let start = if len <= word {
                inline
            } else {
                usize::try_from(ifd.unsigned(inline, word)?).unwrap_or(usize::MAX)
            };
            ifd.entries.push(Entry { tag, kind, count: values, start });
        }
        Ok(ifd)
    }

    /// The unsigned integers of a tag; `None` when the file has no such tag.
    pub(super) fn integers(&self, tag: u16) -> Result<Option<Vec<u64>>> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        if !matches!(entry.kind, 1 | 3 | 4 | 13 | 16 | 18) {
            return Err(self.wrong_type(tag));
        }
        let raw = self.raw(entry)?;
        let size = raw.len() / entry.count.max(1);
        Ok(Some(raw.chunks_exact(size.max(1)).map(|value| self.number(value)).collect()))
    }

    /// The first integer of a tag.
    pub(super) fn integer(&self, tag: u16) -> Result<Option<u64>> {
        Ok(self.integers(tag)?.and_then(|values| values.first().copied()))
    }

    /// The floating-point numbers of a tag.
    pub(super) fn doubles(&self, tag: u16) -> Result<Option<Vec<f64>>> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        let raw = self.raw(entry)?;
        match entry.kind {
            12 => Ok(Some(raw.chunks_exact(8).map(|value| f64::from_bits(self.number(value))).collect())),
            11 => {
                let single = |value: &[u8]| f64::from(f32::from_bits(self.number(value) as u32));
                Ok(Some(raw.chunks_exact(4).map(single).collect()))
            }
            _ => Err(self.wrong_type(tag)),
        }
    }

    /// The text of a tag up to its end mark.
    pub(super) fn text(&self, tag: u16) -> Result<Option<String>> {
        let Some(entry) = self.entry(tag) else { return Ok(None) };
        let raw = self.raw(entry)?;
        let end = raw.iter().position(|&byte| byte == 0).unwrap_or(raw.len());
        Ok(Some(String::from_utf8_lossy(&raw[..end]).into_owned()))
    }

    /// `len` bytes of the file from `start` on; `None` where it ends before.
    pub(super) fn slice(&self, start: u64, len: u64) -> Result<Option<Cow<'_, [u8]>>> {
        self.bytes.get(start, len)
    }

    fn entry(&self, tag: u16) -> Option<Entry> {
        self.entries.iter().find(|entry| entry.tag == tag).copied()
    }

    fn raw(&self, entry: Entry) -> Result<Cow<'_, [u8]>> {
        let len = size_of_kind(entry.kind).and_then(|size| size.checked_mul(entry.count));
        let len = len.ok_or_else(|| self.truncated())?;
        self.bytes.get(entry.start as u64, len as u64)?.ok_or_else(|| self.truncated())
    }

    fn unsigned(&self, start: usize, len: usize) -> Result<u64> {
        let bytes = self.bytes.get(start as u64, len as u64)?;
        bytes.map(|bytes| self.number(&bytes)).ok_or_else(|| self.truncated())
    }

    fn number(&self, bytes: &[u8]) -> u64 {
        let join = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
        if self.big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }

    fn truncated(&self) -> Error {
        Error::format(&self.name, "the file is truncated: its header points beyond its end")
    }

    fn wrong_type(&self, tag: u16) -> Error {
        Error::format(&self.name, format!("tag {tag} has values of the wrong type"))
    }
}

/// Bytes of one value of a TIFF field type.
fn size_of_kind(kind: u16) -> Option<usize> {
    match kind {
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 9 | 11 | 13 => Some(4),
        5 | 10 | 12 | 16 | 17 | 18 => Some(8),
        _ => None,
    }
}
