//! Compression of strips and tiles: none, deflate (both codes), LZW and PackBits.

use std::{cell::RefCell, sync::LazyLock};

use flate2::{Compress, Decompress, FlushCompress, FlushDecompress, Status};
use weezl::{BitOrder, decode, encode};
use zune_inflate::{DeflateDecoder, DeflateOptions};

/// How a strip or tile is packed, by its number in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    None,
    Lzw,
    Deflate,
    PackBits,
}

impl Packing {
    /// The packing with that number, or the name of one that is not supported.
    pub(super) fn from_code(code: u64) -> Result<Self, String> {
        match code {
            1 => Ok(Self::None),
            5 => Ok(Self::Lzw),
            8 | 32946 => Ok(Self::Deflate),
            32773 => Ok(Self::PackBits),
            other => Err(match other {
                2 => "CCITT RLE",
                3 => "CCITT group 3 fax",
                4 => "CCITT group 4 fax",
                6 | 7 => "JPEG",
                34712 => "JPEG 2000",
                34887 => "LERC",
                34925 => "LZMA",
                34926 | 50000 => "Zstandard",
                34927 | 50001 => "WebP",
                50002 | 52546 => "JPEG XL",
                _ => return Err(format!("compression {other}")),
            }
            .to_owned()),
        }
    }

    /// The most bytes that `packed` bytes can unpack to: deflate codes at best 258 bytes in 2 bits, LZW a
    /// 4 KiB phrase in 9 bits, PackBits 128 bytes in two. A header that promises more lies, and no memory is taken for it.
    pub(super) fn most(self, packed: usize) -> usize {
        match self {
            Self::None => packed,
            Self::Lzw => packed.saturating_mul(4096),
            Self::Deflate => packed.saturating_mul(1032),
            Self::PackBits => packed.saturating_mul(64),
        }
    }

    /// Fills `out` from `packed`; what would not fit is never made. `false` when the bytes are corrupt or do
    /// not fill `out`.
    pub(super) fn unpack(self, packed: &[u8], out: &mut [u8]) -> bool {
        match self {
            Self::None => {
                let Some(exact) = packed.get(..out.len()) else { return false };
                out.copy_from_slice(exact);
                true
            }
            Self::Lzw => unpack_lzw(packed, out),
            Self::Deflate => inflate(packed, out),
            Self::PackBits => unpack_bits(packed, out),
        }
    }
}

/// The quickest decoder, and for what it refuses the most tolerant one: some writers leave out the checksum, or pack more
/// than the image needs.
fn inflate(packed: &[u8], out: &mut [u8]) -> bool {
    if packed.starts_with(&OWN_START) {
        match fdeflate::decompress_to_vec_bounded(packed, out.len()) {
            Ok(bytes) if bytes.len() == out.len() => {
                out.copy_from_slice(&bytes);
                return true;
            }
            _ => return inflate_tolerantly(packed, out),
        }
    }
    let options = DeflateOptions::default().set_size_hint(out.len()).set_limit(out.len());
    match DeflateDecoder::new_with_options(packed, options).decode_zlib() {
        Ok(bytes) if bytes.len() == out.len() => {
            out.copy_from_slice(&bytes);
            true
        }
        _ => inflate_tolerantly(packed, out),
    }
}

fn inflate_tolerantly(packed: &[u8], out: &mut [u8]) -> bool {
    thread_local! {
        static INFLATE: RefCell<Decompress> = RefCell::new(Decompress::new(true));
    }
    INFLATE.with_borrow_mut(|inflate| {
        inflate.reset(true);
        match inflate.decompress(packed, out, FlushDecompress::Finish) {
            // `BufError` and `Ok` also mean that the stream would go on: more than the image needs.
            Ok(Status::StreamEnd | Status::BufError | Status::Ok) => inflate.total_out() == out.len() as u64,
            Err(_) => false,
        }
    })
}

fn unpack_lzw(packed: &[u8], out: &mut [u8]) -> bool {
    // Files from before TIFF 6 count bits from the other end; they begin with a clear code of zero bits.
    let old = packed.first() == Some(&0) && packed.get(1).is_some_and(|byte| byte & 1 == 1);
    let mut decoder = if old {
        decode::Decoder::new(BitOrder::Lsb, 8)
    } else {
        decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8)
    };
    let (mut used, mut made) = (0, 0);
    while made < out.len() {
        let step = decoder.decode_bytes(&packed[used..], &mut out[made..]);
        used += step.consumed_in;
        made += step.consumed_out;
        match step.status {
            Ok(weezl::LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => {}
            Ok(_) => break,
            Err(_) => return false,
        }
    }
    made == out.len()
}

/// Runs after TIFF 6, section 9: a count n of 0..=127 is followed by n + 1 bytes as they are, one of -127..=-1 by a
/// byte that stands 1 - n times; -128 means nothing.
fn unpack_bits(packed: &[u8], out: &mut [u8]) -> bool {
    let (mut packed, mut out) = (packed, out);
    while !out.is_empty() {
        let Some((&count, rest)) = packed.split_first() else { return false };
        let (len, used) = match count as i8 {
            count @ 0.. => (count as usize + 1, count as usize + 1),
            -128 => (0, 0),
            count => (1 + usize::from(count.unsigned_abs()), 1),
        };
        let Some(bytes) = rest.get(..used) else { return false };
        // The last run may go beyond what the image needs.
        let (run, beyond) = out.split_at_mut(len.min(out.len()));
        match bytes {
            [byte] => run.fill(*byte),
            bytes => run.copy_from_slice(&bytes[..run.len()]),
        }
        (packed, out) = (&rest[used..], beyond);
    }
    true
}

/// How all that [`deflate_differences`] packs begins: with its table of codes, which [`fdeflate`] reads best.
static OWN_START: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let (one, other) = (deflate_differences(&[1; 64]), deflate_differences(&[200; 64]));
    let alike = one.iter().zip(&other).take_while(|(one, other)| one == other).count();
    one[..alike].to_vec()
});

/// Deflates the differences of whole numbers, which lie about zero as those of pictures do, with a zlib header: twice as
/// quickly as [`deflate`] at level 1, and smaller.
pub(super) fn deflate_differences(bytes: &[u8]) -> Vec<u8> {
    fdeflate::compress_to_vec(bytes)
}

/// Deflates `bytes` with a zlib header.
pub(super) fn deflate(bytes: &[u8], level: u32) -> Vec<u8> {
    thread_local! {
        static DEFLATE: RefCell<Option<(u32, Compress)>> = const { RefCell::new(None) };
    }
    DEFLATE.with_borrow_mut(|slot| {
        let fresh = || (level, Compress::new(flate2::Compression::new(level), true));
        let (held, deflate) = slot.get_or_insert_with(fresh);
        if *held == level {
            deflate.reset();
        } else {
            (*held, *deflate) = fresh();
        }
        let mut out = Vec::with_capacity(bytes.len() / 2 + 64);
        loop {
            let used = deflate.total_in() as usize;
            match deflate.compress_vec(&bytes[used..], &mut out, FlushCompress::Finish) {
                Ok(Status::StreamEnd) => return out,
                // Deflating into a growing vector has nothing else to report.
                _ => out.reserve(bytes.len() / 2 + 64),
            }
        }
    })
}

/// Packs `bytes` with LZW as TIFF 6 has it.
pub(super) fn lzw(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len() / 2 + 64);
    let mut encoder = encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8);
    // Encoding eight-bit bytes to memory cannot fail.
    let _ = encoder.into_vec(&mut out).encode_all(bytes);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_begin_alike_and_come_back_by_every_decoder() {
        assert!(OWN_START.len() > 30, "{}", OWN_START.len());
        let noise = |i: usize| (orograph_core::key(7, 1, i as i64, 0) % 9) as u8;
        for bytes in [Vec::new(), vec![0; 70_000], (0..70_000).map(|i| noise(i).wrapping_sub(4)).collect()] {
            let packed = deflate_differences(&bytes);
            assert!(packed.starts_with(&OWN_START));
            let mut out = vec![1; bytes.len()];
            assert!(Packing::Deflate.unpack(&packed, &mut out) && out == bytes);
            let mut tolerant = vec![1; bytes.len()];
            assert!(inflate_tolerantly(&packed, &mut tolerant) && tolerant == bytes);
            // More than the image needs, and less.
            if let Some(shorter) = bytes.len().checked_sub(100) {
                assert!(Packing::Deflate.unpack(&packed, &mut out[..shorter]));
                assert!(!Packing::Deflate.unpack(&packed[..packed.len() / 2], &mut out));
            }
        }
    }

    /// The example of Apple's Technical Note 1023, which introduced the scheme.
    #[test]
    fn packbits_unpack_as_their_inventor_says() {
        let packed =
            [0xFE, 0xAA, 0x02, 0x80, 0x00, 0x2A, 0xFD, 0xAA, 0x03, 0x80, 0x00, 0x2A, 0x22, 0xF7, 0xAA];
        let expected = [
            0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0xAA, 0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0x22, 0xAA, 0xAA,
            0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA,
        ];
        let mut out = [0; 24];
        assert!(Packing::PackBits.unpack(&packed, &mut out));
        assert_eq!(out, expected);
        let mut short = [0; 20];
        assert!(Packing::PackBits.unpack(&packed, &mut short));
        assert_eq!(short, expected[..20]);
        for end in 0..packed.len() {
            assert!(!Packing::PackBits.unpack(&packed[..end], &mut out), "cut at {end}");
        }
        assert!(Packing::PackBits.unpack(&[0x80, 0x00, 7], &mut out[..1]) && out[0] == 7);
    }
}
