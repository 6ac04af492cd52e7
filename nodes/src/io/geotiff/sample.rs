//! Samples: from the bytes of an unpacked row to heights, and back.
//!
//! Predictor 2 stores differences of neighbouring samples, predictor 3 the bytes of floating-point numbers
//! sorted by significance and then differenced. Both are undone row by row, while a row is close at hand.

use bytemuck::Pod;

/// The type of a sample, as the file declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Encoding {
    /// The encoding with that `SampleFormat` and `BitsPerSample`.
    pub(super) fn from_tags(format: u64, bits: u64) -> Option<Self> {
        Some(match (format, bits) {
            (1 | 4, 8) => Self::U8,
            (2, 8) => Self::I8,
            (1 | 4, 16) => Self::U16,
            (2, 16) => Self::I16,
            (1 | 4, 32) => Self::U32,
            (2, 32) => Self::I32,
            (1 | 4, 64) => Self::U64,
            (2, 64) => Self::I64,
            (3, 32) => Self::F32,
            (3, 64) => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one sample.
    pub(super) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// How the samples of a row lie, and what they mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) encoding: Encoding,
    pub(super) big_endian: bool,
    pub(super) predictor: u64,
    /// Samples per pixel in the row; the first is the height.
    pub(super) bands: usize,
    /// The value that means "no height".
    pub(super) nodata: Option<f64>,
    /// Metres per unit and metres at zero.
    pub(super) scale: Option<(f64, f64)>,
}

/// Samples as bit patterns, on which differences are taken.
pub(super) trait Bits: Pod + Default {
    fn from_le(bytes: &[u8]) -> Self;
    fn from_be(bytes: &[u8]) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    /// Whose bytes in memory are its own, the least significant first.
    fn little_endian(self) -> Self;
    /// One of its bytes, the most significant first.
    fn byte(self, plane: usize) -> u8;
}

macro_rules! bits {
    ($($ty:ty),*) => {$(
        impl Bits for $ty {
            fn from_le(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(0, |&bytes| <$ty>::from_le_bytes(bytes))
            }
            fn from_be(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(0, |&bytes| <$ty>::from_be_bytes(bytes))
            }
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            fn little_endian(self) -> Self {
                self.to_le()
            }
            fn byte(self, plane: usize) -> u8 {
                (self >> (8 * (size_of::<$ty>() - 1 - plane))) as u8
            }
        }
    )*};
}
bits!(u8, u16, u32, u64);

impl Row {
    /// Turns the unpacked bytes of a row into heights, as many as `out` holds; `bytes` is the whole row, which
    /// may be wider, and is scratch afterwards.
    pub(super) fn heights(&self, bytes: &mut [u8], out: &mut [f32]) {
        if self.predictor == 3 {
            return self.sorted(bytes, out);
        }
        // Integers are exact in f64, and a float is compared as the f32 that it becomes.
        match self.encoding {
            Encoding::U8 => self.each(bytes, out, |bits: u8| f64::from(bits)),
            Encoding::I8 => self.each(bytes, out, |bits: u8| f64::from(bits as i8)),
            Encoding::U16 => self.each_short(bytes, out, i32::from),
            Encoding::I16 => self.each_short(bytes, out, |bits| i32::from(bits as i16)),
            Encoding::U32 => self.each(bytes, out, |bits: u32| f64::from(bits)),
            Encoding::I32 => self.each(bytes, out, |bits: u32| f64::from(bits as i32)),
            Encoding::U64 => self.each(bytes, out, |bits: u64| bits as f64),
            Encoding::I64 => self.each(bytes, out, |bits: u64| bits as i64 as f64),
            Encoding::F32 => self.each(bytes, out, |bits: u32| f64::from(f32::from_bits(bits))),
            Encoding::F64 => self.each(bytes, out, f64::from_bits),
        }
    }

    fn each<B: Bits>(&self, bytes: &[u8], out: &mut [f32], value: impl Fn(B) -> f64) {
        let pixels = bytes.chunks_exact(size_of::<B>() * self.bands);
        let bits = |pixel| if self.big_endian { B::from_be(pixel) } else { B::from_le(pixel) };
        let mut sum = B::default();
        for (out, pixel) in out.iter_mut().zip(pixels) {
            sum = if self.predictor == 2 { sum.plus(bits(pixel)) } else { bits(pixel) };
            *out = self.height(value(sum));
        }
    }

    /// [`each`](Self::each) for the commonest case, which needs no f64.
    fn each_short(&self, bytes: &mut [u8], out: &mut [f32], value: impl Fn(u16) -> i32) {
        if self.scale.is_some() || self.bands != 1 {
            return self.each(bytes, out, |bits| f64::from(value(bits)));
        }
        let whole = |nodata: &f64| *nodata == f64::from(*nodata as i32);
        // No sample reaches beyond 16 bits, so this one never matches.
        let nodata = self.nodata.filter(whole).map_or(i32::MAX, |nodata| nodata as i32);
        let height = |bits| {
            let value = value(bits);
            if value == nodata { f32::NAN } else { value as f32 }
        };
        if self.predictor == 2 {
            // Sums wait for each other; what is made of them need not.
            let mut sum = 0u16;
            for pair in bytes.as_chunks_mut::<2>().0 {
                let step = u16::from_le_bytes(*pair);
                sum = sum.wrapping_add(if self.big_endian { step.swap_bytes() } else { step });
                *pair = sum.to_le_bytes();
            }
        }
        let pairs = out.iter_mut().zip(bytes.as_chunks::<2>().0);
        if self.big_endian && self.predictor != 2 {
            pairs.for_each(|(out, &pair)| *out = height(u16::from_be_bytes(pair)));
        } else {
            pairs.for_each(|(out, &pair)| *out = height(u16::from_le_bytes(pair)));
        }
    }

    /// Undoes predictor 3: sums bytes, then gathers each number from its planes, most significant first.
    fn sorted(&self, bytes: &mut [u8], out: &mut [f32]) {
        if let (Encoding::F32, 1, None) = (self.encoding, self.bands, self.scale) {
            return self.sorted_singles(bytes, out);
        }
        for i in self.bands..bytes.len() {
            bytes[i] = bytes[i].wrapping_add(bytes[i - self.bands]);
        }
        let plane = bytes.len() / self.encoding.size();
        if plane == 0 {
            return;
        }
        let bands = self.bands;
        for (i, out) in out.iter_mut().enumerate() {
            let bits = (0..self.encoding.size())
                .fold(0u64, |bits, byte| bits << 8 | u64::from(bytes[byte * plane + i * bands]));
            *out = self.height(match self.encoding {
                Encoding::F64 => f64::from_bits(bits),
                _ => f64::from(f32::from_bits(bits as u32)),
            });
        }
    }

    /// [`sorted`](Self::sorted) for the commonest case. The sums run through all four planes; each plane is
    /// begun where the whole of those before it ends, so that one walk sums and gathers all four.
    fn sorted_singles(&self, bytes: &[u8], out: &mut [f32]) {
        let plane = bytes.len() / 4;
        let (a, rest) = bytes.split_at(plane);
        let (b, rest) = rest.split_at(plane);
        let (c, d) = rest.split_at(plane);
        let total = |plane: &[u8]| plane.iter().fold(0u8, |sum, &byte| sum.wrapping_add(byte));
        let mut sums = [0, total(a), 0, 0];
        sums[2] = sums[1].wrapping_add(total(b));
        sums[3] = sums[2].wrapping_add(total(c));
        // Never equal to a height when there is no such value.
        let nodata = self.nodata.map_or(f32::NAN, |nodata| nodata as f32);
        for ((((out, &a), &b), &c), &d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            for (sum, step) in sums.iter_mut().zip([a, b, c, d]) {
                *sum = sum.wrapping_add(step);
            }
            let height = f32::from_be_bytes(sums);
            *out = if height == nodata { f32::NAN } else { height };
        }
    }

    /// A stored value in metres; NaN for "no height".
    fn height(&self, value: f64) -> f32 {
        let void = |nodata: f64| value == nodata || (self.is_float() && value as f32 == nodata as f32);
        if self.nodata.is_some_and(void) {
            return f32::NAN;
        }
        match self.scale {
            Some((factor, offset)) => (value * factor + offset) as f32,
            None => value as f32,
        }
    }

    /// Whether a row may hold an infinite height: whole numbers as they are hold none.
    pub(super) fn may_be_infinite(&self) -> bool {
        self.is_float() || self.scale.is_some()
    }

    fn is_float(&self) -> bool {
        matches!(self.encoding, Encoding::F32 | Encoding::F64)
    }
}

/// Turns the samples of a row into differences of neighbours (predictor 2).
pub(super) fn difference<B: Bits>(samples: &mut [B]) {
    let mut before = B::default();
    for sample in samples {
        (*sample, before) = (sample.minus(before), *sample);
    }
}

/// Appends the samples of a row as they are, the least significant byte of each first.
pub(super) fn plain<B: Bits>(samples: &mut [B], out: &mut Vec<u8>) {
    samples.iter_mut().for_each(|sample| *sample = sample.little_endian());
    out.extend_from_slice(bytemuck::cast_slice(samples));
}

/// Appends the samples of a row, the bits of floating-point numbers, with their bytes sorted and differenced (predictor 3).
pub(super) fn sort_bytes<B: Bits>(samples: &[B], out: &mut Vec<u8>) {
    let start = out.len();
    out.resize(start + size_of_val(samples), 0);
    let Some(last) = samples.last() else { return };
    for (plane, bytes) in out[start..].chunks_mut(samples.len()).enumerate() {
        let mut before = plane.checked_sub(1).map_or(0, |above| last.byte(above));
        for (out, sample) in bytes.iter_mut().zip(samples) {
            let byte = sample.byte(plane);
            *out = byte.wrapping_sub(before);
            before = byte;
        }
    }
}
