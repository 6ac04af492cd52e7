//! The one byte form of a value: what its digest is taken of, what the disk store holds, and what may
//! cross a process or an ABI.
//!
//! Layout: type tag (1 byte), length of the header (8 bytes), header (postcard), payload (little-endian
//! cells). Everything but the rasters is header alone.

use std::sync::Arc;

use serde::{Serialize, de::DeserializeOwned};

use crate::{Digest, Grid, Kind, Raster, Value};

/// Why bytes are no value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodecError {
    /// There are fewer or more bytes than the header says.
    #[error("truncated or overlong value")]
    Length,
    /// No type has this tag.
    #[error("unknown value tag {0}")]
    Tag(u8),
    /// The header cannot be read.
    #[error("malformed value header")]
    Header,
}

/// A value as bytes: `head`, then `payload`, which borrows the value's own cells.
#[derive(Debug)]
pub struct Encoded<'a> {
    /// Tag, header length and header.
    pub head: Vec<u8>,
    /// The cells of a raster; empty for everything else.
    pub payload: &'a [u8],
}

impl Encoded<'_> {
    /// The digest of head and payload.
    #[must_use]
    pub fn digest(&self) -> Digest {
        Digest::of_parts(&self.head, self.payload)
    }

    /// Bytes in all.
    #[must_use]
    pub fn len(&self) -> u64 {
        (self.head.len() + self.payload.len()) as u64
    }

    /// Never: a value has at least its tag.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }
}

impl Value {
    /// The value's byte form.
    #[must_use]
    pub fn encode(&self) -> Encoded<'_> {
        match self {
            Self::Heightfield(raster) => encode_raster(0, raster),
            Self::Mask(raster) => encode_raster(1, raster),
            Self::Texture(raster) => encode_raster(2, raster),
            Self::Features(value) => encode_plain(3, &**value),
            Self::Points(value) => encode_plain(4, &**value),
            Self::Placement(value) => encode_plain(5, &**value),
            Self::Table(value) => encode_plain(6, &**value),
            Self::Mesh(value) => encode_plain(7, &**value),
            Self::Number(value) => encode_plain(8, value),
            Self::Integer(value) => encode_plain(9, value),
            Self::Boolean(value) => encode_plain(10, value),
            Self::Text(value) => encode_plain(11, value),
        }
    }

    /// The value that `bytes` are the form of.
    ///
    /// # Errors
    /// [`CodecError`] when they are none; no memory is taken beyond the length of `bytes`.
    pub fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        let (tag, header, payload) = split(bytes)?;
        Self::of_parts(tag, header, Copied(payload))
    }

    /// As [`decode`](Self::decode), from a head and a payload that lie apart; the cells of a raster are read where they
    /// are.
    ///
    /// # Errors
    /// [`CodecError`]; also when the payload is not aligned for its cells.
    pub fn decode_lent(head: &[u8], payload: &'static [u8]) -> Result<Self, CodecError> {
        let (tag, header) = split_head(head)?;
        Self::of_parts(tag, header, Lent(payload))
    }

    /// As [`decode`](Self::decode), from a head and a payload of `len` bytes that `fill` brings.
    ///
    /// # Errors
    /// [`CodecError`]; also when there is no memory or `fill` gives `false`.
    pub fn decode_filled(
        head: &[u8],
        len: usize,
        fill: impl FnOnce(&mut [u8]) -> bool,
    ) -> Result<Self, CodecError> {
        let (tag, header) = split_head(head)?;
        Self::of_parts(tag, header, Filled { len, fill })
    }

    fn of_parts(tag: u8, header: &[u8], payload: impl Payload) -> Result<Self, CodecError> {
        Ok(match tag {
            0 => Self::Heightfield(raster(header, payload)?),
            1 => Self::Mask(raster(header, payload)?),
            2 => Self::Texture(raster(header, payload)?),
            _ if payload.len() > 0 => return Err(CodecError::Length),
            3 => Self::Features(Arc::new(plain(header)?)),
            4 => Self::Points(Arc::new(plain(header)?)),
            5 => Self::Placement(Arc::new(plain(header)?)),
            6 => Self::Table(Arc::new(plain(header)?)),
            7 => Self::Mesh(Arc::new(plain(header)?)),
            8 => Self::Number(plain(header)?),
            9 => Self::Integer(plain(header)?),
            10 => Self::Boolean(plain(header)?),
            11 => Self::Text(plain(header)?),
            other => return Err(CodecError::Tag(other)),
        })
    }

    /// The digest of the value's content.
    #[must_use]
    pub fn digest(&self) -> Digest {
        self.encode().digest()
    }

    /// About how many bytes the value takes in memory.
    #[must_use]
    pub fn size_in_memory(&self) -> u64 {
        fn cells<K: Kind>(raster: &Raster<K>) -> u64 {
            size_of_val(raster.cells()) as u64
        }
        const SMALL: u64 = 256;
        SMALL
            + match self {
                Self::Heightfield(raster) => cells(raster),
                Self::Mask(raster) => cells(raster),
                Self::Texture(raster) => cells(raster),
                Self::Features(features) => {
                    let line =
                        |line: &crate::Polyline| line.vertices.len() * 16 + line.profiles.len() * 4 + 64;
                    (features.points.len() * 24 + features.lines.iter().map(line).sum::<usize>()) as u64
                }
                Self::Points(points) => points.len() as u64 * 24,
                Self::Placement(placement) => {
                    (placement.labels.len() * 12 + placement.patches.len() * 128 + placement.seams.len() * 8)
                        as u64
                }
                Self::Table(table) => (table.rows() * table.columns().len() * 24) as u64,
                Self::Mesh(mesh) => (mesh.vertices.len() * 32 + mesh.triangles.len() * 12) as u64,
                Self::Text(text) => text.len() as u64,
                Self::Number(_) | Self::Integer(_) | Self::Boolean(_) => 0,
            }
    }
}

fn head_of(tag: u8, header: &impl Serialize) -> Vec<u8> {
    let mut head = vec![tag, 0, 0, 0, 0, 0, 0, 0, 0];
    // Writing plain data to a growing vector cannot fail; an empty header would be caught by `decode`.
    head = postcard::to_extend(header, head).unwrap_or_default();
    let len = head.len().saturating_sub(9) as u64;
    if let Some(slot) = head.get_mut(1..9) {
        slot.copy_from_slice(&len.to_le_bytes());
    }
    head
}

fn encode_plain<'a>(tag: u8, value: &impl Serialize) -> Encoded<'a> {
    Encoded { head: head_of(tag, value), payload: &[] }
}

fn encode_raster<K: Kind>(tag: u8, raster: &Raster<K>) -> Encoded<'_> {
    Encoded { head: head_of(tag, raster.grid()), payload: bytemuck::cast_slice(raster.cells()) }
}

fn plain<T: DeserializeOwned>(header: &[u8]) -> Result<T, CodecError> {
    match postcard::take_from_bytes(header) {
        Ok((value, [])) => Ok(value),
        _ => Err(CodecError::Header),
    }
}

/// Tag, header, and what follows them.
fn split(bytes: &[u8]) -> Result<(u8, &[u8], &[u8]), CodecError> {
    let (&tag, rest) = bytes.split_first().ok_or(CodecError::Length)?;
    let (len, rest) = rest.split_first_chunk::<8>().ok_or(CodecError::Length)?;
    let len = usize::try_from(u64::from_le_bytes(*len)).map_err(|_| CodecError::Length)?;
    let (header, payload) = rest.split_at_checked(len).ok_or(CodecError::Length)?;
    Ok((tag, header, payload))
}

/// Tag and header of a head that nothing follows.
fn split_head(head: &[u8]) -> Result<(u8, &[u8]), CodecError> {
    match split(head)? {
        (tag, header, []) => Ok((tag, header)),
        _ => Err(CodecError::Length),
    }
}

/// Where the cells of a raster come from.
trait Payload {
    /// How many bytes they are.
    fn len(&self) -> usize;
    /// The raster of a grid that has as many.
    fn raster<K: Kind>(self, grid: Grid) -> Option<Raster<K>>;
}

struct Copied<'a>(&'a [u8]);
struct Lent(&'static [u8]);
struct Filled<F> {
    len: usize,
    fill: F,
}

impl Payload for Copied<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn raster<K: Kind>(self, grid: Grid) -> Option<Raster<K>> {
        Raster::of_bytes(grid, self.0)
    }
}

impl Payload for Lent {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn raster<K: Kind>(self, grid: Grid) -> Option<Raster<K>> {
        Raster::lent(grid, bytemuck::try_cast_slice(self.0).ok()?).ok()
    }
}

impl<F: FnOnce(&mut [u8]) -> bool> Payload for Filled<F> {
    fn len(&self) -> usize {
        self.len
    }
    fn raster<K: Kind>(self, grid: Grid) -> Option<Raster<K>> {
        Raster::of_filled(grid, self.fill)
    }
}

fn raster<K: Kind>(header: &[u8], payload: impl Payload) -> Result<Arc<Raster<K>>, CodecError> {
    let grid: Grid = plain(header)?;
    if !Raster::<K>::takes(&grid, payload.len()) {
        return Err(CodecError::Length);
    }
    payload.raster(grid).map(Arc::new).ok_or(CodecError::Length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CellSize, Heightfield, Table, Unit};

    fn bytes(value: &Value) -> Vec<u8> {
        let encoded = value.encode();
        [&encoded.head, encoded.payload].concat()
    }

    fn samples() -> Vec<Value> {
        let grid = Grid::new(2, 3, CellSize::square(5.0)).unwrap();
        let field = Heightfield::new(grid, vec![1.0, f32::NAN, -0.0, 4.0, 5.0, 6.0]).unwrap();
        let table = Table::metrics([("rmse", Unit::Metre, 1.5)]).unwrap();
        vec![
            Value::Heightfield(Arc::new(field)),
            Value::Table(Arc::new(table)),
            Value::Number(0.1),
            Value::Integer(-7),
            Value::Boolean(true),
            Value::Text("Grüß Gott".into()),
        ]
    }

    #[test]
    fn values_survive_their_bytes() {
        for value in samples() {
            let back = Value::decode(&bytes(&value)).unwrap();
            assert_eq!(back.digest(), value.digest(), "{value:?}");
            assert_eq!(back.value_type(), value.value_type());
        }
    }

    #[test]
    fn heads_and_payloads_may_lie_apart() {
        for value in samples() {
            let encoded = value.encode();
            let filled = Value::decode_filled(&encoded.head, encoded.payload.len(), |bytes| {
                bytes.copy_from_slice(encoded.payload);
                true
            });
            assert_eq!(filled.unwrap().digest(), value.digest());
            if !encoded.payload.is_empty() {
                assert!(Value::decode_filled(&encoded.head, encoded.payload.len() - 4, |_| true).is_err());
                assert!(Value::decode_filled(&encoded.head, encoded.payload.len(), |_| false).is_err());
            }
        }
        static CELLS: [u32; 6] = [0x3f80_0000; 6];
        let head = samples().swap_remove(0).encode().head;
        let lent = Value::decode_lent(&head, bytemuck::cast_slice(&CELLS)).unwrap();
        let Value::Heightfield(lent) = lent else { panic!("another type") };
        assert_eq!(lent.cells().as_ptr().cast::<u32>(), CELLS.as_ptr());
        assert!(Value::decode_lent(&head, &bytemuck::cast_slice(&CELLS)[..20]).is_err());
    }

    #[test]
    fn no_truncation_or_bit_flip_panics_and_no_truncation_is_accepted() {
        for value in samples() {
            let whole = bytes(&value);
            for end in 0..whole.len() {
                assert!(Value::decode(&whole[..end]).is_err(), "{value:?} cut at {end}");
            }
            for i in 0..whole.len() * 8 {
                let mut flipped = whole.clone();
                flipped[i / 8] ^= 1 << (i % 8);
                let _ = Value::decode(&flipped);
            }
        }
    }

    #[test]
    fn equal_cells_of_another_type_have_another_digest() {
        let grid = Grid::new(1, 1, CellSize::square(5.0)).unwrap();
        let height = Value::Heightfield(Arc::new(Raster::new(grid.clone(), vec![0.5]).unwrap()));
        let share = Value::Mask(Arc::new(Raster::new(grid, vec![0.5]).unwrap()));
        assert_ne!(height.digest(), share.digest());
    }
}
