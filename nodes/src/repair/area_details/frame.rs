//! The box in which a void gets its details.

use orograph_core::CellSize;

use crate::{filter::chaikin::whole_len, repair::voids::Void};

/// A box of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::repair) struct Frame {
    pub(in crate::repair) first: [i64; 2],
    pub(in crate::repair) size: [usize; 2],
    /// Times that the box can be halved.
    pub(in crate::repair) levels: u32,
}

impl Frame {
    /// The box of a void with a margin, enlarged to a length that can be halved `levels` times; less often where the
    /// raster has not the room, and `None` where it has none for once.
    pub(in crate::repair) fn around(
        void: &Void,
        margin: usize,
        levels: u32,
        (rows, cols): (usize, usize),
    ) -> Option<Self> {
        let raster = [rows, cols];
        (1..=levels).rev().find_map(|levels| {
            let mut frame = Self { first: [0; 2], size: [0; 2], levels };
            for axis in [0, 1] {
                let wanted = void.size()[axis] + 2 * margin;
                let size = whole_len(wanted, levels);
                if size > raster[axis] {
                    return None;
                }
                // An odd cell more goes to the high side; at the border the box moves inward.
                let before = (margin + (size - wanted) / 2) as i64;
                let most = (raster[axis] - size) as i64;
                frame.first[axis] = (void.first[axis] as i64 - before).clamp(0, most);
                frame.size[axis] = size;
            }
            Some(frame)
        })
    }

    pub(in crate::repair) fn len(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Metres as cells down and across; at least twice the box.
    pub(in crate::repair) fn reach(&self, metres: f64, cell: CellSize) -> [f64; 2] {
        let reach = [cell.y, cell.x].map(|side| metres / side);
        [0, 1].map(|axis| reach[axis].max(2.0 * self.size[axis] as f64))
    }

    /// How far a box of `size` cells in a raster of `n` lies off this one along an axis, at a share of the way from as far
    /// before as it may lie to as far behind: no farther than it reaches, nor than the raster goes.
    pub(in crate::repair) fn offset(
        &self,
        axis: usize,
        size: usize,
        reach: f64,
        n: usize,
        share: f64,
    ) -> i64 {
        let first = self.first[axis];
        let most = n as i64 - size as i64 - first;
        let (low, high) = ((-first as f64).max(-reach), (most as f64).min(reach));
        (low + (high - low) * share).round() as i64
    }

    /// Row and column in the raster of a cell of the box.
    pub(in crate::repair) fn cell(&self, i: usize) -> [usize; 2] {
        let [row, col] = [i / self.size[1], i % self.size[1]];
        [self.first[0] as usize + row, self.first[1] as usize + col]
    }

    /// Number in the box of a cell of the raster, where it lies inside.
    pub(in crate::repair) fn find(&self, [row, col]: [usize; 2]) -> Option<usize> {
        let [row, col] = [row as i64 - self.first[0], col as i64 - self.first[1]];
        let inside = |at: i64, axis: usize| at >= 0 && at < self.size[axis] as i64;
        (inside(row, 0) && inside(col, 1)).then(|| row as usize * self.size[1] + col as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn void(first: [usize; 2], last: [usize; 2]) -> Void {
        Void { cells: Vec::new(), first, last, cols: 100 }
    }

    #[test]
    fn boxes_have_whole_lengths_and_stay_inside() {
        // Seven rows and a margin of two on each side: 11, which becomes 18 for three halvings.
        let frame = Frame::around(&void([40, 3], [46, 12]), 2, 3, (100, 100)).unwrap();
        assert_eq!(frame, Frame { first: [35, 0], size: [18, 18], levels: 3 });
        let frame = Frame::around(&void([90, 90], [99, 99]), 0, 3, (100, 100)).unwrap();
        assert_eq!((frame.first, frame.size), ([90, 90], [10, 10]));
        // Too small for three halvings, then for any.
        assert_eq!(Frame::around(&void([2, 2], [4, 4]), 2, 3, (9, 9)).unwrap().levels, 1);
        assert_eq!(Frame::around(&void([0, 0], [4, 4]), 2, 3, (5, 5)), None);
    }

    #[test]
    fn cells_are_found_again() {
        let frame = Frame { first: [5, 7], size: [10, 6], levels: 1 };
        assert!((0..frame.len()).all(|i| frame.find(frame.cell(i)) == Some(i)));
        assert_eq!(frame.find([5, 6]), None);
        assert_eq!(frame.find([15, 7]), None);
    }
}
