//! Patches that go on across the edges of tiles.
//!
//! A tile is patched with the ground around it. Near an edge this passes into the patch of a strip on both sides of the edge,
//! and near a corner into that of a square around the corner: both tiles see the same strip, and all four the same square, so
//! that they fill what they share with equal bits.

use orograph_core::prelude::*;

use super::{VoidPatchOut, offsets};
use crate::io::ground::own_cell_size;

/// The sides of a raster along one axis.
const LOW: usize = 0;
const HIGH: usize = 1;

/// Patches `terrain`, which lies in `around`, by what `patch` makes of any terrain.
///
/// # Errors
/// [`Error::Invalid`] when it does not lie there, and those of `patch`.
pub(super) fn patch_within(
    terrain: &Heightfield,
    around: &Heightfield,
    patch: impl Fn(&Heightfield, &Job<'_>) -> Result<VoidPatchOut>,
    job: &Job<'_>,
) -> Result<VoidPatchOut> {
    let place = Place::of(terrain.grid(), around.grid())?;
    if place.margin == [[0; 2]; 2] {
        return patch(terrain, job);
    }
    let whole = patch(around, job)?;
    let [first, size] = [place.first, place.size];
    let tile = whole.terrain.crop(first[0], first[1], size[0], size[1], job)?;
    let smooth = whole.smooth.crop(first[0], first[1], size[0], size[1], job)?;
    let quiet = job.silent();
    let patched = |piece: Option<Piece>| match piece {
        Some(piece) => piece.filled(around, |ground| Ok(patch(ground, &quiet)?.terrain), &quiet).map(Some),
        None => Ok(None),
    };
    let mut strips = [[None, None], [None, None]];
    let mut corners = [[None, None], [None, None]];
    for side in [LOW, HIGH] {
        for axis in [0, 1] {
            strips[axis][side] = patched(place.strip(axis, side, around))?;
        }
        for across in [LOW, HIGH] {
            corners[side][across] = patched(place.corner([side, across], around))?;
        }
    }
    let fades = [0, 1].map(|axis| place.fades(axis));
    let terrain = Heightfield::build(terrain.grid().clone(), job, |row, out| {
        let (row_side, a) = fades[0][row];
        for (col, (out, &known)) in out.iter_mut().zip(terrain.row(row)).enumerate() {
            *out = known;
            if !known.is_nan() {
                continue;
            }
            let (col_side, b) = fades[1][col];
            let own = tile.at(row, col);
            if own.is_nan() || a == 0.0 && b == 0.0 {
                *out = own;
                continue;
            }
            let at = [row, col];
            let piece = |of: &Option<Filled>| of.as_ref().and_then(|piece| piece.at(at));
            let corner = piece(&corners[row_side][col_side]);
            let (mut across, mut along) = (a * (1.0 - b), b * (1.0 - a));
            if corner.is_none() {
                // Each edge is wholly its own strip's; between two edges the nearer counts more.
                let far = [0, 1].map(|axis| {
                    let far = place.distance(axis, [row_side, col_side][axis], at[axis]) as f64;
                    far * far
                });
                let share = if far[0] + far[1] > 0.0 { far[1] / (far[0] + far[1]) } else { 1.0 };
                across += a * b * share;
                along += a * b * (1.0 - share);
            }
            let pieces = [
                (a * b, corner),
                (across, piece(&strips[0][row_side])),
                (along, piece(&strips[1][col_side])),
                ((1.0 - a) * (1.0 - b), Some(own)),
            ];
            let known = pieces.iter().filter_map(|&(weight, height)| Some((weight, f64::from(height?))));
            let (sum, weights) = known
                .filter(|(weight, _)| *weight > 0.0)
                .fold((0.0, 0.0), |(sum, weights), (weight, height)| {
                    (sum + weight * height, weights + weight)
                });
            *out = if weights > 0.0 { (sum / weights) as f32 } else { own };
        }
        Ok(())
    })?;
    let report = offsets::in_tile(&whole.report, first, size)?;
    Ok(VoidPatchOut { terrain, smooth, report })
}

/// Where a tile lies in the ground around it.
struct Place {
    first: [usize; 2],
    size: [usize; 2],
    /// Cells beyond the tile: along rows before and after it, then along columns.
    margin: [[usize; 2]; 2],
}

impl Place {
    fn of(tile: &Grid, around: &Grid) -> Result<Self> {
        let first = [tile.row0 - around.row0, tile.col0 - around.col0];
        let size = [tile.rows, tile.cols];
        let all = [around.rows, around.cols];
        let is_inside =
            (0..2).all(|axis| first[axis] >= 0 && first[axis] as u64 + size[axis] as u64 <= all[axis] as u64);
        if !is_inside
            || tile.cell != around.cell
            || tile.origin != around.origin
            || tile.georef != around.georef
        {
            return Err(Error::invalid(
                "`around` is not the ground around `terrain`",
                "connect both to the same `io.read_tile`, or a terrain and its crop",
            ));
        }
        let first = first.map(|cells| cells as usize);
        let margin = [0, 1].map(|axis| [first[axis], all[axis] - size[axis] - first[axis]]);
        Ok(Self { first, size, margin })
    }

    /// The tile's first or last line, in the ground around.
    fn line(&self, axis: usize, side: usize) -> usize {
        if side == LOW { self.first[axis] } else { self.first[axis] + self.size[axis] - 1 }
    }

    /// Cells from an edge.
    fn distance(&self, axis: usize, side: usize, at: usize) -> usize {
        if side == LOW { at } else { self.size[axis] - 1 - at }
    }

    /// For each row, or column, the side that it is nearer to and how much the strip there counts.
    fn fades(&self, axis: usize) -> Vec<(usize, f64)> {
        let n = self.size[axis];
        let fade = |at: usize| {
            let side = if 2 * at < n { LOW } else { HIGH };
            let reach = (self.margin[axis][side] as f64 / 2.0).min((n - 1) as f64 / 2.0);
            let x = self.distance(axis, side, at) as f64 / reach;
            // Without margin there is no strip; with one its weight is 1 on the edge and 0 in the middle of the tile.
            let is_near = reach > 0.0 && x < 1.0;
            (side, if is_near { 1.0 - x * x * (3.0 - 2.0 * x) } else { 0.0 })
        };
        (0..n).map(fade).collect()
    }

    /// First cell and length of what lies on both sides of an edge.
    fn both_sides(&self, axis: usize, side: usize) -> (usize, usize) {
        let (line, margin) = (self.line(axis, side), self.margin[axis][side]);
        let all = self.margin[axis][LOW] + self.size[axis] + self.margin[axis][HIGH];
        let first = line.saturating_sub(margin);
        (first, (line + margin + 1).min(all) - first)
    }

    /// The strip along an edge, where that has voids.
    fn strip(&self, axis: usize, side: usize, around: &Heightfield) -> Option<Piece> {
        if self.margin[axis][side] == 0 {
            return None;
        }
        let mut piece = Piece { tile: self.first, first: self.first, size: self.size };
        let line = self.line(axis, side);
        let is_void = |at: usize| match axis {
            0 => around.at(line, self.first[1] + at).is_nan(),
            _ => around.at(self.first[0] + at, line).is_nan(),
        };
        (piece.first[axis], piece.size[axis]) = self.both_sides(axis, side);
        (0..self.size[1 - axis]).any(is_void).then_some(piece)
    }

    /// The square around a corner, where edges have voids near it. Where the tile across the corner is missing there is none,
    /// for any of the others.
    fn corner(&self, sides: [usize; 2], around: &Heightfield) -> Option<Piece> {
        if (0..2).any(|axis| self.margin[axis][sides[axis]] == 0) {
            return None;
        }
        let [(row, rows), (col, cols)] = [0, 1].map(|axis| self.both_sides(axis, sides[axis]));
        let line = [0, 1].map(|axis| self.line(axis, sides[axis]));
        let beyond =
            [(row, rows), (col, cols)].into_iter().zip(line).zip(sides).map(|(((first, n), line), side)| {
                if side == LOW { first..line } else { line + 1..first + n }
            });
        let [beyond_rows, beyond_cols]: [_; 2] = beyond.collect::<Vec<_>>().try_into().ok()?;
        let is_there = beyond_rows
            .clone()
            .any(|row| around.row(row)[beyond_cols.clone()].iter().any(|height| !height.is_nan()));
        let has_voids = (row..row + rows).any(|row| around.at(row, line[1]).is_nan())
            || around.row(line[0])[col..col + cols].iter().any(|height| height.is_nan());
        (is_there && has_voids).then_some(Piece { tile: self.first, first: [row, col], size: [rows, cols] })
    }
}

/// A part of the ground around the tile.
struct Piece {
    /// The tile's first cell.
    tile: [usize; 2],
    first: [usize; 2],
    size: [usize; 2],
}

/// Such a part without voids.
struct Filled {
    piece: Piece,
    terrain: Heightfield,
}

impl Piece {
    fn filled(
        self,
        around: &Heightfield,
        patch: impl Fn(&Heightfield) -> Result<Heightfield>,
        job: &Job<'_>,
    ) -> Result<Filled> {
        let [rows, cols] = self.size;
        let part = around.crop(self.first[0], self.first[1], rows, cols, job)?;
        // Nothing is left of the tile that it was cut for.
        let grid = Grid::new(rows, cols, own_cell_size(part.grid()))?;
        Ok(Filled { terrain: patch(&part.with_grid(grid)?)?, piece: self })
    }
}

impl Filled {
    /// The height at a row and column of the tile, where the part reaches and is filled.
    fn at(&self, at: [usize; 2]) -> Option<f32> {
        let [row, col] =
            [0, 1].map(|axis| (self.piece.tile[axis] + at[axis]).wrapping_sub(self.piece.first[axis]));
        let is_inside = row < self.terrain.rows() && col < self.terrain.cols();
        is_inside.then(|| self.terrain.at(row, col)).filter(|height| !height.is_nan())
    }
}

#[cfg(test)]
mod tests;
