//! Where a void's details are taken from: which box, and turned how.

use orograph_core::prelude::*;

use super::frame::Frame;

/// One of the eight ways to lay a box over another: a quarter turn is a mirroring and an exchange of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::repair) struct Turn {
    pub(in crate::repair) down_mirrored: bool,
    pub(in crate::repair) across_mirrored: bool,
    /// Whether rows become columns.
    pub(in crate::repair) exchanged: bool,
}

impl Turn {
    pub(in crate::repair) const NONE: Self =
        Self { down_mirrored: false, across_mirrored: false, exchanged: false };

    /// All eight, or the four without exchange where cells are far from square.
    pub(in crate::repair) fn all(cell: CellSize) -> Vec<Self> {
        let is_square = (0.8..=1.25).contains(&(cell.x / cell.y));
        let mut all = Vec::with_capacity(8);
        for exchanged in [false, true] {
            for (down_mirrored, across_mirrored) in
                [(false, false), (false, true), (true, false), (true, true)]
            {
                if !exchanged || is_square {
                    all.push(Self { down_mirrored, across_mirrored, exchanged });
                }
            }
        }
        all
    }

    /// What a report says.
    pub(in crate::repair) fn name(self) -> &'static str {
        match (self.exchanged, self.down_mirrored, self.across_mirrored) {
            (false, false, false) => "as it lies",
            (false, false, true) => "mirrored east-west",
            (false, true, false) => "mirrored north-south",
            (false, true, true) => "turned by 180°",
            (true, false, false) => "mirrored along the falling diagonal",
            (true, false, true) => "turned by a quarter",
            (true, true, false) => "turned by three quarters",
            (true, true, true) => "mirrored along the rising diagonal",
        }
    }

    /// Size of the box that is laid over one of `size`.
    pub(in crate::repair) fn size(self, [rows, cols]: [usize; 2]) -> [usize; 2] {
        if self.exchanged { [cols, rows] } else { [rows, cols] }
    }

    /// The cell of the source box that lies over a cell of a box of `size`.
    fn cell(self, [row, col]: [usize; 2], [rows, cols]: [usize; 2]) -> [usize; 2] {
        let row = if self.down_mirrored { rows - 1 - row } else { row };
        let col = if self.across_mirrored { cols - 1 - col } else { col };
        if self.exchanged { [col, row] } else { [row, col] }
    }
}

/// A box of the terrain, laid over a void's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::repair) struct Source {
    pub(in crate::repair) first: [usize; 2],
    pub(in crate::repair) turn: Turn,
}

impl Source {
    /// The terrain's cell over number `i` of the void's box.
    pub(in crate::repair) fn over(&self, i: usize, frame: &Frame) -> [usize; 2] {
        let at = self.turn.cell([i / frame.size[1], i % frame.size[1]], frame.size);
        [self.first[0] + at[0], self.first[1] + at[1]]
    }

    /// The box at rows and columns beside the void's, where the raster has it.
    pub(in crate::repair) fn beside(
        frame: &Frame,
        by: [i64; 2],
        turn: Turn,
        (rows, cols): (usize, usize),
    ) -> Option<Self> {
        let size = turn.size(frame.size);
        let raster = [rows, cols];
        let mut first = [0; 2];
        for axis in [0, 1] {
            let at = frame.first[axis] + by[axis];
            if at < 0 || at as usize + size[axis] > raster[axis] {
                return None;
            }
            first[axis] = at as usize;
        }
        Some(Self { first, turn })
    }

    /// Cells of the box that are not known.
    pub(in crate::repair) fn missing(&self, terrain: &Heightfield, frame: &Frame) -> usize {
        let [rows, cols] = self.turn.size(frame.size);
        let lines =
            (self.first[0]..self.first[0] + rows).map(|row| &terrain.row(row)[self.first[1]..][..cols]);
        lines.map(|line| line.iter().filter(|height| height.is_nan()).count()).sum()
    }
}

/// The paper's choice: of the eight boxes beside the void's the one that misses least, and of such the one whose normal is
/// nearest to the void's.
pub(in crate::repair) fn neighbour(
    terrain: &Heightfield,
    base: &Heightfield,
    frame: &Frame,
) -> Option<Source> {
    let [h, w] = frame.size.map(|n| n as i64);
    // East and on, against the clock.
    let ways = [[0, w], [-h, w], [-h, 0], [-h, -w], [0, -w], [h, -w], [h, 0], [h, w]];
    let own = normal(base, [frame.first[0] as usize, frame.first[1] as usize], frame.size);
    let mut best: Option<(usize, f64, Source)> = None;
    for by in ways {
        let Some(source) = Source::beside(frame, by, Turn::NONE, terrain.grid().size()) else { continue };
        let missing = source.missing(terrain, frame);
        let other = normal(base, source.first, frame.size);
        // The larger the cosine, the smaller the angle.
        let angle = -(0..3).map(|k| own[k] * other[k]).sum::<f64>();
        let is_better = best.as_ref().is_none_or(|(least, smallest, _)| {
            missing < *least || missing == *least && angle < *smallest - 1e-12
        });
        if is_better {
            best = Some((missing, angle, source));
        }
    }
    best.map(|(_, _, source)| source)
}

/// Unit normal of a box, from its diagonals.
fn normal(base: &Heightfield, [row, col]: [usize; 2], [rows, cols]: [usize; 2]) -> [f64; 3] {
    let cell = base.grid().cell;
    let at = |down: bool, right: bool| {
        f64::from(base.at(row + if down { rows - 1 } else { 0 }, col + if right { cols - 1 } else { 0 }))
    };
    let (width, height) = ((cols - 1) as f64 * cell.x, (rows - 1) as f64 * cell.y);
    let a = [width, height, at(true, true) - at(false, false)];
    let b = [-width, height, at(true, false) - at(false, true)];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let length = libm::sqrt(cross.iter().map(|part| part * part).sum());
    cross.map(|part| part / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    const FRAME: Frame = Frame { first: [20, 30], size: [6, 10], levels: 1 };

    #[test]
    fn turns_cover_the_source_box_once() {
        let turns = Turn::all(CellSize::square(5.0));
        assert_eq!(turns.len(), 8);
        assert_eq!(Turn::all(CellSize { x: 1.0, y: 2.0 }).len(), 4);
        let mut seen = Vec::new();
        for turn in turns {
            let source = Source { first: [3, 4], turn };
            let over: Vec<[usize; 2]> = (0..FRAME.len()).map(|i| source.over(i, &FRAME)).collect();
            let [rows, cols] = turn.size(FRAME.size);
            let mut sorted = over.clone();
            sorted.sort_unstable();
            let all: Vec<[usize; 2]> = (0..rows * cols).map(|i| [3 + i / cols, 4 + i % cols]).collect();
            assert_eq!(sorted, all);
            assert!(!seen.contains(&over));
            seen.push(over);
        }
    }

    #[test]
    fn the_neighbour_is_whole_and_leans_alike() {
        // Ground that falls to the east in the east and to the south elsewhere; the void lies where it falls south.
        let height =
            |row: usize, col: usize| if col >= 40 { -(col as f64) * 9.0 } else { -(row as f64) * 9.0 };
        let base = field(60, 60, height);
        let neighbour_of = |hole: &dyn Fn(usize, usize) -> bool| {
            let terrain = field(60, 60, |row, col| if hole(row, col) { f64::NAN } else { height(row, col) });
            neighbour(&terrain, &base, &FRAME).unwrap().first
        };
        // All but the east lean alike: the first of them in order is to the north.
        assert_eq!(neighbour_of(&|_, _| false), [14, 30]);
        assert_eq!(neighbour_of(&|row, _| row == 15), [20, 20]);
        // Nothing whole: the one that misses least.
        assert_eq!(neighbour_of(&|row, col| !(26..32).contains(&row) || col < 40), [26, 40]);
    }

    #[test]
    fn boxes_outside_are_no_sources() {
        let frame = Frame { first: [0, 0], size: [10, 10], levels: 1 };
        let terrain = field(10, 10, |_, _| 1.0);
        assert!(neighbour(&terrain, &terrain, &frame).is_none());
    }
}
