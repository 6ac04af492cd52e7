//! Content digests and the hasher that keys are made with.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A 256-bit BLAKE3 digest: the name of a content or of a computation.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// The digest of some bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// The digest of some bytes, with the help of the current thread pool where there are many.
    #[must_use]
    pub fn of_large(bytes: &[u8]) -> Self {
        Self::of_parts(&[], bytes)
    }

    /// The digest of `head` and `payload`, one after the other.
    pub(crate) fn of_parts(head: &[u8], payload: &[u8]) -> Self {
        /// Below this, handing out the work costs more than it saves.
        const PARALLEL: usize = 1 << 18;
        let mut hasher = blake3::Hasher::new();
        hasher.update(head);
        if payload.len() >= PARALLEL {
            hasher.update_rayon(payload);
        } else {
            hasher.update(payload);
        }
        Self(*hasher.finalize().as_bytes())
    }

    /// The digest written as [`Display`](fmt::Display) writes it.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        blake3::Hash::from_hex(text).ok().map(|hash| Self(*hash.as_bytes()))
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", &blake3::Hash::from_bytes(self.0).to_hex()[..12])
    }
}

/// Hashes a sequence of fields such that no two different sequences read the same.
#[derive(Clone, Default)]
pub struct Hasher(Vec<u8>);

impl Hasher {
    /// A hasher for one kind of key; `purpose` keeps kinds apart.
    #[must_use]
    pub fn new(purpose: &str) -> Self {
        let mut hasher = Self(Vec::with_capacity(256));
        hasher.text(purpose);
        hasher
    }

    /// Adds a text with its length.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Adds bytes with their number.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.number(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
        self
    }

    /// Adds a number.
    pub fn number(&mut self, number: u64) -> &mut Self {
        self.0.extend_from_slice(&number.to_le_bytes());
        self
    }

    /// Adds a digest.
    pub fn digest(&mut self, digest: &Digest) -> &mut Self {
        self.0.extend_from_slice(&digest.0);
        self
    }

    /// The digest of everything added.
    #[must_use]
    pub fn finish(&self) -> Digest {
        Digest::of(&self.0)
    }
}
