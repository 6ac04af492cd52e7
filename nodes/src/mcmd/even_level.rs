//! Levels of the triangle-edge scheme whose intervals are all alike: every level of 2^n + 1 columns.
//!
//! Nothing is looked up here, and the loops are such that the compiler works on several cells at once. Bits are
//! those of the general way in [`top_down`](super::top_down).

use pulp::{Arch, NullaryFnOnce};

use super::{settings::Falloff, top_down::Noise};

/// Columns of a coarser level worked out together; few enough for the nearest cache.
const CHUNK: usize = 128;

/// What the cells of the level have in common.
#[derive(Clone, Copy)]
pub(crate) struct EvenLevel<'a> {
    pub(crate) falloff: &'a Falloff,
    /// Weights by step along x (0 or 1) and step along y.
    pub(crate) factors: &'a [[f64; 3]; 3],
    pub(crate) noise: Noise,
    pub(crate) rt: f64,
    /// Displacement of edges and of centres per random number.
    pub(crate) amplitudes: [f64; 2],
    /// Columns from one line to the next: even, the new column halfway.
    pub(crate) stride: usize,
    /// Infinite where there are none.
    pub(crate) limits: (f64, f64),
    pub(crate) arch: Arch,
}

/// Columns from each line to the next, where that is the same everywhere and there is one halfway.
pub(crate) fn even_stride(lines: &[u32], cols: usize) -> Option<usize> {
    let intervals = lines.len().checked_sub(1).filter(|&intervals| intervals > 0)?;
    // Halving keeps intervals alike exactly as long as their number divides the whole.
    let stride = (cols - 1) / intervals;
    (stride * intervals == cols - 1 && stride.is_multiple_of(2) && stride > 0).then_some(stride)
}

impl EvenLevel<'_> {
    /// The unknown cells of a coarser level's row.
    pub(crate) fn edges<const FLAT: bool, const NOISY: bool>(&self, y: usize, row: &mut [f32]) {
        self.arch.dispatch(Edges::<FLAT, NOISY> { with: self, y, row });
    }

    /// The unknown cells of a new row between `above` and `below`, that many steps away.
    pub(crate) fn between<const FLAT: bool, const NOISY: bool>(
        &self,
        y: usize,
        row: &mut [f32],
        beside: [&[f32]; 2],
        steps: (usize, usize),
    ) {
        self.arch.dispatch(Rows::<FLAT, NOISY> { with: self, y, row, beside, steps });
    }

    #[inline(always)]
    fn height<const NOISY: bool>(&self, mean: f64, amplitude: f64, x: usize, y: usize) -> f32 {
        let shift = if NOISY { (self.noise.at(x, y) + self.rt) * amplitude } else { 0.0 };
        (mean + shift).clamp(self.limits.0, self.limits.1) as f32
    }

    /// The heights of `line` at the lines, weighed.
    #[inline(always)]
    fn weigh<const FLAT: bool>(&self, line: &[f32], factor: f64, out: &mut [f64]) {
        let of = |height| if FLAT { f64::from(height) } else { self.falloff.scale(height, factor) };
        if self.stride == 2 {
            // The same as below, in a shape that the compiler turns into wide loads; most cells go this way.
            out.iter_mut().zip(line.chunks(2)).for_each(|(out, pair)| *out = of(pair[0]));
        } else {
            out.iter_mut().zip(line.iter().step_by(self.stride)).for_each(|(out, &height)| *out = of(height));
        }
    }
}

#[inline(always)]
fn keep_known(out: &mut f32, height: f32) {
    *out = if out.is_nan() { height } else { *out };
}

struct Edges<'a, const FLAT: bool, const NOISY: bool> {
    with: &'a EvenLevel<'a>,
    y: usize,
    row: &'a mut [f32],
}

impl<const FLAT: bool, const NOISY: bool> NullaryFnOnce for Edges<'_, FLAT, NOISY> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { with, y, row } = self;
        let mut ends = [0.0; CHUNK + 1];
        let mut new = [0.0; CHUNK];
        let (stride, half) = (with.stride, with.stride / 2);
        let count = row.len() / stride;
        for start in (0..count).step_by(CHUNK) {
            let n = CHUNK.min(count - start);
            let row = &mut row[stride * start..=stride * (start + n)];
            with.weigh::<FLAT>(row, with.factors[1][0], &mut ends[..=n]);
            for (i, (new, ends)) in new[..n].iter_mut().zip(ends.windows(2)).enumerate() {
                let x = stride * (start + i) + half;
                *new = with.height::<NOISY>((ends[0] + ends[1]) / 2.0, with.amplitudes[0], x, y);
            }
            for (interval, &new) in row.chunks_exact_mut(stride).zip(&new) {
                keep_known(&mut interval[half], new);
            }
        }
    }
}

struct Rows<'a, const FLAT: bool, const NOISY: bool> {
    with: &'a EvenLevel<'a>,
    y: usize,
    row: &'a mut [f32],
    beside: [&'a [f32]; 2],
    steps: (usize, usize),
}

impl<const FLAT: bool, const NOISY: bool> NullaryFnOnce for Rows<'_, FLAT, NOISY> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { with, y, row, beside: [above, below], steps: (up, down) } = self;
        let [edge_amplitude, center_amplitude] = with.amplitudes;
        // Weighed heights above and below, for edges straight between them and for centres askew.
        let [mut over, mut under, mut over_askew, mut under_askew] = [[0.0; CHUNK + 1]; 4];
        let (mut edges, mut centres) = ([0.0; CHUNK], [0.0; CHUNK]);
        let (stride, half) = (with.stride, with.stride / 2);
        let count = row.len() / stride;
        for start in (0..count).step_by(CHUNK) {
            let n = CHUNK.min(count - start);
            let span = stride * start..=stride * (start + n);
            let (above, below) = (&above[span.clone()], &below[span.clone()]);
            with.weigh::<FLAT>(above, with.factors[0][up], &mut over[..=n]);
            with.weigh::<FLAT>(below, with.factors[0][down], &mut under[..=n]);
            for (i, ((edge, &over), &under)) in edges[..n].iter_mut().zip(&over).zip(&under).enumerate() {
                *edge = with.height::<NOISY>((over + under) / 2.0, edge_amplitude, stride * (start + i), y);
            }
            with.weigh::<FLAT>(above, with.factors[1][up], &mut over_askew[..=n]);
            with.weigh::<FLAT>(below, with.factors[1][down], &mut under_askew[..=n]);
            let corners = over_askew.windows(2).zip(under_askew.windows(2));
            for (i, (centre, (over, under))) in centres[..n].iter_mut().zip(corners).enumerate() {
                let mean = (over[0] + over[1] + under[0] + under[1]) / 4.0;
                *centre = with.height::<NOISY>(mean, center_amplitude, stride * (start + i) + half, y);
            }
            let intervals = row[span].chunks_exact_mut(stride);
            for ((interval, &edge), &centre) in intervals.zip(&edges).zip(&centres) {
                keep_known(&mut interval[0], edge);
                keep_known(&mut interval[half], centre);
            }
        }
        let last = stride * count;
        let [mut over, mut under] = [[0.0]; 2];
        with.weigh::<FLAT>(&above[last..], with.factors[0][up], &mut over);
        with.weigh::<FLAT>(&below[last..], with.factors[0][down], &mut under);
        let height = with.height::<NOISY>((over[0] + under[0]) / 2.0, edge_amplitude, last, y);
        keep_known(&mut row[last], height);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_alike_as_long_as_the_columns_can_be_halved() {
        assert_eq!(even_stride(&[0, 2, 4], 5), Some(2));
        assert_eq!(even_stride(&[0, 12], 13), Some(12));
        assert_eq!(even_stride(&[0, 6, 12], 13), Some(6));
        assert_eq!(even_stride(&[0, 3, 6, 9, 12], 13), None);
        assert_eq!(even_stride(&[0, 2, 5], 6), None);
        assert_eq!(even_stride(&[0, 1, 2], 3), None);
        assert_eq!((even_stride(&[0], 1), even_stride(&[], 0)), (None, None));
    }
}
