//! Poisson's equation on any set of cells: conjugate gradients preconditioned by multigrid.
//!
//! At each free cell p `sum over neighbours q of w (u_p - u_q) = b_p`, with u = 0 at fixed cells and no flow to cells
//! outside; cells may be held, which adds `h u_p` on the left. Only the rectangle around the free cells is worked on.

use orograph_core::prelude::*;

use super::{floating::floating_parts, iteration::Iteration, network::Finest};

/// What a cell is to the equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Without value: nothing flows there.
    Outside,
    /// Its value stays.
    Fixed,
    /// To be found.
    Free,
}

/// The equation's domain.
#[derive(Clone, Copy, Debug)]
pub struct Domain<'a> {
    /// Number of columns.
    pub cols: usize,
    /// What each cell is, row by row.
    pub cells: &'a [Cell],
    /// Weights of the steps along a row and along a column: 1 and 1 on square cells.
    pub weights: [f64; 2],
}

/// Bytes for one cell, all levels together.
const BYTES: u64 = 80;

/// The solution for the right side `b`, 0 at all cells that are not free.
///
/// On a connected part without fixed neighbour, where only differences are determined, the solution has mean 0; there
/// `b` must add up to 0.
///
/// # Errors
/// [`Error::Invalid`] when lengths do not agree, [`Error::NotConverged`], [`Error::TooLarge`], or cancellation.
pub fn solve(domain: &Domain<'_>, b: &[f64], job: &Job<'_>) -> Result<Vec<f64>> {
    solve_held(domain, &[], b, job)
}

/// [`solve`] with cells held to 0 by springs: `holds` has the strength at each cell, not negative, or is empty. A part
/// that is held anywhere has a solution for any right side.
///
/// # Errors
/// Those of [`solve`].
pub fn solve_held(domain: &Domain<'_>, holds: &[f64], b: &[f64], job: &Job<'_>) -> Result<Vec<f64>> {
    let Domain { cols, cells, weights } = *domain;
    let n = cells.len();
    if n == 0 {
        return Ok(Vec::new());
    }
    if cols == 0 || !n.is_multiple_of(cols) || b.len() != n || !holds.is_empty() && holds.len() != n {
        return Err(Error::invalid(
            "a domain and its right side have different sizes",
            "give one number a cell",
        ));
    }
    job.admit(n as u64 * BYTES, || format!("the equations of {n} cells"))?;
    if !b.iter().chain(holds).all(|b| b.is_finite()) {
        return Err(Error::invalid("a height is infinite", "declare that value as nodata in the source"));
    }
    let Some(part) = Part::of(cols, cells) else { return Ok(vec![0.0; n]) };
    let mut framed = part.framed(cells, Cell::Outside);
    let mut right = part.framed(b, 0.0);
    right.iter_mut().zip(&framed).filter(|(_, cell)| **cell != Cell::Free).for_each(|(b, _)| *b = 0.0);
    let holds = if holds.is_empty() { Vec::new() } else { part.framed(holds, 0.0) };
    let floating = floating_parts(part.cols + 2, &framed, &holds);
    for cells in &floating {
        if cells.iter().all(|&i| right[i] == 0.0) {
            cells.iter().for_each(|&i| framed[i] = Cell::Outside);
            continue;
        }
        // Its equation follows from the others; where the part lies is settled below.
        framed[cells[0]] = Cell::Fixed;
        right[cells[0]] = 0.0;
    }
    let finest = Finest { stride: part.cols + 2, cells: &framed, holds: &holds, weights };
    let (mut solution, _) = Iteration::new(finest, right).run(job)?;
    for cells in &floating {
        let mean = cells.iter().map(|&i| solution[i]).sum::<f64>() / cells.len() as f64;
        cells.iter().for_each(|&i| solution[i] -= mean);
    }
    Ok(part.unframed(&solution, n))
}

/// The least rectangle of a domain that holds all free cells and their neighbours.
struct Part {
    top: usize,
    left: usize,
    rows: usize,
    cols: usize,
    all_cols: usize,
}

impl Part {
    /// `None` without a free cell.
    fn of(all_cols: usize, cells: &[Cell]) -> Option<Self> {
        let is_free = |cell: &Cell| *cell == Cell::Free;
        let (mut top, mut bottom, mut left, mut right) = (usize::MAX, 0, usize::MAX, 0);
        for (row, cells) in cells.chunks(all_cols).enumerate() {
            let Some(first) = cells.iter().position(is_free) else { continue };
            let last = cells.iter().rposition(is_free).unwrap_or(first);
            (top, bottom) = (top.min(row), row);
            (left, right) = (left.min(first), right.max(last));
        }
        if top > bottom {
            return None;
        }
        let (top, left) = (top.saturating_sub(1), left.saturating_sub(1));
        let rows = (bottom + 2).min(cells.len() / all_cols) - top;
        Some(Self { top, left, rows, cols: (right + 2).min(all_cols) - left, all_cols })
    }

    /// Its values, with a frame one cell wide.
    fn framed<T: Copy>(&self, values: &[T], frame: T) -> Vec<T> {
        let stride = self.cols + 2;
        let mut out = vec![frame; (self.rows + 2) * stride];
        for (row, out) in out.chunks_mut(stride).skip(1).take(self.rows).enumerate() {
            out[1..=self.cols]
                .copy_from_slice(&values[(self.top + row) * self.all_cols + self.left..][..self.cols]);
        }
        out
    }

    /// `n` values, 0 outside it.
    fn unframed(&self, framed: &[f64], n: usize) -> Vec<f64> {
        let mut out = vec![0.0; n];
        for (row, values) in framed.chunks(self.cols + 2).skip(1).take(self.rows).enumerate() {
            out[(self.top + row) * self.all_cols + self.left..][..self.cols]
                .copy_from_slice(&values[1..=self.cols]);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use orograph_core::{key, signed_unit};

    use super::*;

    /// What solutions are to be off by at most, in metres.
    const ACCURACY: f64 = 2e-5;

    fn residual(domain: &Domain<'_>, b: &[f64], u: &[f64]) -> f64 {
        let (cols, n) = (domain.cols, domain.cells.len());
        let at = |i: usize| {
            if domain.cells[i] != Cell::Free {
                return 0.0;
            }
            let col = i % cols;
            let near = [
                (col > 0).then(|| (i - 1, 0)),
                (i >= cols).then(|| (i - cols, 1)),
                (col + 1 < cols).then(|| (i + 1, 0)),
                (i + cols < n).then(|| (i + cols, 1)),
            ];
            let flow = near.into_iter().flatten().filter(|&(j, _)| domain.cells[j] != Cell::Outside);
            let sum: f64 = flow.map(|(j, axis)| domain.weights[axis] * (u[i] - u[j])).sum();
            (sum - b[i]).abs()
        };
        (0..n).map(at).fold(0.0, f64::max)
    }

    /// [`floating_parts`] of arrays without a frame.
    fn floating(cols: usize, cells: &[Cell], holds: &[f64]) -> Vec<Vec<usize>> {
        let part = Part { top: 0, left: 0, rows: cells.len() / cols, cols, all_cols: cols };
        let holds = if holds.is_empty() { Vec::new() } else { part.framed(holds, 0.0) };
        let found = floating_parts(cols + 2, &part.framed(cells, Cell::Outside), &holds);
        let unframed = |i: usize| (i / (cols + 2) - 1) * cols + i % (cols + 2) - 1;
        found.into_iter().map(|part| part.into_iter().map(unframed).collect()).collect()
    }

    #[test]
    fn ragged_regions_are_solved_to_the_accuracy() {
        for (seed, rows, cols, share, weights) in [
            (1, 40, 57, 0.9, [1.0, 1.0]),
            (2, 1, 30, 0.8, [1.0, 1.0]),
            (3, 130, 71, 0.97, [1.0, 0.4]),
            (4, 9, 9, 0.5, [2.0, 1.0]),
        ] {
            let draw = |stream: u64, i: usize| signed_unit(key(seed, stream, i as i64, 0));
            let kind = |i: usize| match draw(1, i) {
                u if u < 2.0 * share - 1.0 => Cell::Free,
                u if u < share => Cell::Fixed,
                _ => Cell::Outside,
            };
            let mut cells: Vec<Cell> = (0..rows * cols).map(kind).collect();
            // Isolated free cells without fixed neighbour have no equation of their own.
            let b: Vec<f64> = (0..rows * cols).map(|i| 100.0 * draw(2, i)).collect();
            cells.iter_mut().step_by(7).for_each(|cell| *cell = Cell::Fixed);
            let floating: Vec<usize> = floating(cols, &cells, &[]).into_iter().flatten().collect();
            floating.iter().for_each(|&i| cells[i] = Cell::Outside);
            let domain = Domain { cols, cells: &cells, weights };
            let u = solve(&domain, &b, &Job::detached()).unwrap();
            assert!(residual(&domain, &b, &u) < 4.0 * ACCURACY, "{seed}: {}", residual(&domain, &b, &u));
        }
    }

    #[test]
    fn large_regions_take_few_steps() {
        // Discs, every cell driven: the multigrid must carry the long waves, past edges that hold and that do not.
        let side = 301;
        let inside = |i: usize| libm::hypot((i / side) as f64 - 150.0, (i % side) as f64 - 150.0) < 140.0;
        let slit = |i: usize| (i / side).abs_diff(150) < 2 && i % side > 90;
        let disc = |rim: Cell, slit_is: Cell| -> Vec<Cell> {
            let kind = |i: usize| match inside(i) {
                true if slit(i) => slit_is,
                true => Cell::Free,
                false => rim,
            };
            (0..side * side).map(kind).collect()
        };
        let held =
            |each: usize| (0..side * side).map(|i| if i.is_multiple_of(each) { 1e4 } else { 0.0 }).collect();
        for (name, cells, holds, most) in [
            ("fixed", disc(Cell::Fixed, Cell::Free), Vec::new(), 6),
            ("fixed, with a slit", disc(Cell::Fixed, Cell::Fixed), Vec::new(), 7),
            ("open, held at points", disc(Cell::Outside, Cell::Free), held(997), 12),
            ("open, with a slit, held at points", disc(Cell::Outside, Cell::Outside), held(997), 12),
        ] {
            let b: Vec<f64> = (0..side * side).map(|i| signed_unit(key(5, 1, i as i64, 0))).collect();
            let domain = Domain { cols: side, cells: &cells, weights: [1.0; 2] };
            let u = solve_held(&domain, &holds, &b, &Job::detached()).unwrap();
            let rest: Vec<f64> = match &holds[..] {
                [] => b.clone(),
                holds => (0..b.len()).map(|i| b[i] - holds[i] * u[i]).collect(),
            };
            let off = residual(&domain, &rest, &u);
            assert!(off < if holds.is_empty() { 4.0 * ACCURACY } else { 1e-2 }, "{name}: {off}");
            let part = Part { top: 0, left: 0, rows: side, cols: side, all_cols: side };
            let (framed, mut right) = (part.framed(&cells, Cell::Outside), part.framed(&b, 0.0));
            right
                .iter_mut()
                .zip(&framed)
                .filter(|(_, cell)| **cell != Cell::Free)
                .for_each(|(b, _)| *b = 0.0);
            let holds = if holds.is_empty() { holds } else { part.framed(&holds, 0.0) };
            let finest = Finest { stride: side + 2, cells: &framed, holds: &holds, weights: [1.0; 2] };
            let (_, steps) = Iteration::new(finest, right).run(&Job::detached()).unwrap();
            assert!(steps <= most, "{name}: {steps}");
        }
    }

    #[test]
    fn floating_parts_are_those_that_a_flood_finds() {
        for seed in 0..60 {
            let (rows, cols) = (11, 13);
            let draw = |stream: u64, i: usize| signed_unit(key(seed, stream, i as i64, 0));
            let cells: Vec<Cell> = (0..rows * cols)
                .map(|i| match draw(1, i) {
                    u if u < 0.15 => Cell::Free,
                    u if u < 0.97 => Cell::Outside,
                    _ => Cell::Fixed,
                })
                .collect();
            let some = |stream: u64, i: usize| if draw(stream, i) > 0.9 { 1.0 } else { 0.0 };
            let holds: Vec<f64> = (0..rows * cols).map(|i| some(3, i) * some(4, i)).collect();
            let mut found = Vec::new();
            let mut seen = vec![false; rows * cols];
            for first in 0..rows * cols {
                let (mut part, mut next, mut anchored) = (vec![first], 0, false);
                if cells[first] != Cell::Free || std::mem::replace(&mut seen[first], true) {
                    continue;
                }
                while let Some(&i) = part.get(next) {
                    next += 1;
                    let near = [
                        (i % cols > 0).then(|| i - 1),
                        (i % cols + 1 < cols).then(|| i + 1),
                        i.checked_sub(cols),
                        (i + cols < rows * cols).then(|| i + cols),
                    ];
                    for j in near.into_iter().flatten() {
                        anchored |= cells[j] == Cell::Fixed;
                        if cells[j] == Cell::Free && !std::mem::replace(&mut seen[j], true) {
                            part.push(j);
                        }
                    }
                }
                part.sort_unstable();
                if !anchored && part.iter().all(|&i| holds[i] == 0.0) {
                    found.push(part);
                }
            }
            assert_eq!(floating(cols, &cells, &holds), found, "{seed}");
        }
    }

    #[test]
    fn a_part_without_fixed_neighbour_keeps_its_mean() {
        // One row of five cells between cells outside; a step is asked for between the second and the third.
        let mut cells = vec![Cell::Outside; 7];
        cells[1..6].fill(Cell::Free);
        let b = [0.0, 0.0, -5.0, 5.0, 0.0, 0.0, 0.0];
        let domain = Domain { cols: 7, cells: &cells, weights: [1.0; 2] };
        let u = solve(&domain, &b, &Job::detached()).unwrap();
        for (u, truth) in u[1..6].iter().zip([-3.0, -3.0, 2.0, 2.0, 2.0]) {
            assert!((u - truth).abs() < ACCURACY, "{u} {truth}");
        }
    }

    #[test]
    fn a_part_that_nothing_holds_or_drives_stays_where_it_is() {
        // Two halves, a column outside between them; the left one is driven and held, the right one neither.
        let (rows, cols) = (40, 41);
        let kind = |i: usize| match i % cols {
            0 => Cell::Fixed,
            20 => Cell::Outside,
            _ => Cell::Free,
        };
        let cells: Vec<Cell> = (0..rows * cols).map(kind).collect();
        let b: Vec<f64> = (0..rows * cols).map(|i| if i % cols < 20 { 1.0 } else { 0.0 }).collect();
        let u = solve(&Domain { cols, cells: &cells, weights: [1.0; 2] }, &b, &Job::detached()).unwrap();
        assert!((0..rows * cols).all(|i| (u[i] != 0.0) == (1..20).contains(&(i % cols))));
    }

    #[test]
    fn held_cells_pull_with_their_strength() {
        // One row of three cells, the last held by 2: b = 6 at the first flows down to the hold, where u = 6 / 2.
        let free = [Cell::Free; 3];
        let domain = Domain { cols: 3, cells: &free, weights: [1.0; 2] };
        let u = solve_held(&domain, &[0.0, 0.0, 2.0], &[6.0, 0.0, 0.0], &Job::detached()).unwrap();
        for (u, truth) in u.iter().zip([15.0, 9.0, 3.0]) {
            assert!((u - truth).abs() < ACCURACY, "{u} {truth}");
        }
        // On ragged ground, with holds of any strength anywhere, the equations are met.
        let (rows, cols) = (70, 53);
        let draw = |stream: u64, i: usize| signed_unit(key(8, stream, i as i64, 0));
        let kind = |i: usize| if draw(1, i) < 0.8 { Cell::Free } else { Cell::Outside };
        let cells: Vec<Cell> = (0..rows * cols).map(kind).collect();
        let hold = |i: usize| if draw(3, i) > 0.9 { libm::pow(10.0, 5.0 * draw(4, i)) } else { 0.0 };
        let mut holds: Vec<f64> = (0..rows * cols).map(hold).collect();
        let b: Vec<f64> = (0..rows * cols).map(|i| 100.0 * draw(2, i)).collect();
        for part in floating(cols, &cells, &holds) {
            holds[part[0]] = 1.0;
        }
        let domain = Domain { cols, cells: &cells, weights: [1.0, 0.6] };
        let u = solve_held(&domain, &holds, &b, &Job::detached()).unwrap();
        // Of a right side as much larger the solution is that much more exact, as strong holds need to be seen.
        let large: Vec<f64> = b.iter().map(|b| 1e5 * b).collect();
        let exact: Vec<f64> =
            solve_held(&domain, &holds, &large, &Job::detached()).unwrap().iter().map(|u| u / 1e5).collect();
        let rest: Vec<f64> = (0..rows * cols).map(|i| b[i] - holds[i] * exact[i]).collect();
        assert!(residual(&domain, &rest, &exact) < 1e-2, "{}", residual(&domain, &rest, &exact));
        for (u, exact) in u.iter().zip(exact) {
            assert!((u - exact).abs() < 5.0 * ACCURACY, "{u} {exact}");
        }
        assert!(solve_held(&domain, &[1.0], &b, &Job::detached()).is_err());
    }

    #[test]
    fn nothing_free_is_nothing_to_do() {
        let domain = Domain { cols: 2, cells: &[Cell::Fixed; 4], weights: [1.0; 2] };
        assert_eq!(solve(&domain, &[3.0; 4], &Job::detached()).unwrap(), [0.0; 4]);
        assert!(solve(&domain, &[3.0; 3], &Job::detached()).is_err());
        let free = Domain { cells: &[Cell::Free; 4], ..domain };
        assert!(solve(&free, &[f64::INFINITY; 4], &Job::detached()).is_err());
    }
}
