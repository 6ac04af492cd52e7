//! MCMD once more, literally as the paper states it, and the oracles that hold the fast passes to it.

use std::collections::BTreeMap;

use orograph_core::prelude::*;
use orograph_core::{key, mix64, signed_unit};

use crate::Chance;
use crate::mcmd::{
    mcmd::{Mcmd, McmdIn},
    params::{Centers, Displacement, Flanks, LargeForms, Limits, Subdivision},
    settings::{Scheme, falloff},
};
use crate::test_fields::field;

type Cell = (usize, usize);
type Tree = (Vec<usize>, Vec<(usize, usize)>);

/// Levels and parent intervals, by a queue of intervals.
fn axis(n: usize) -> Tree {
    let (mut level, mut parent) = (vec![0; n], vec![(0, 0); n]);
    let mut current = vec![(0, n - 1)];
    let mut depth = 0;
    while !current.is_empty() {
        depth += 1;
        let mut next = Vec::new();
        for (a, b) in current {
            if b - a > 1 {
                let m = a + (b - a) / 2;
                level[m] = depth;
                parent[m] = (a, b);
                next.extend([(a, m), (m, b)]);
            }
        }
        current = next;
    }
    (level, parent)
}

/// Midpoints of `level` in the intervals beside line `at`, found among all lines of lower levels.
fn beside(tree: &Tree, at: usize, level: usize) -> Vec<usize> {
    let lines: Vec<usize> = (0..tree.0.len()).filter(|&i| tree.0[i] < level).collect();
    let k = lines.iter().position(|&line| line == at).unwrap();
    let mut out = Vec::new();
    if k > 0 && at - lines[k - 1] > 1 {
        out.push(lines[k - 1] + (at - lines[k - 1]) / 2);
    }
    if k + 1 < lines.len() && lines[k + 1] - at > 1 {
        out.push(at + (lines[k + 1] - at) / 2);
    }
    out
}

/// Level and ascendants, as (x, y).
fn ascendants(scheme: Scheme, xs: &Tree, ys: &Tree, (x, y): Cell) -> (usize, Vec<Cell>) {
    let (lx, ly) = (xs.0[x], ys.0[y]);
    let level = lx.max(ly);
    if level == 0 {
        return (0, vec![]);
    }
    let ((x0, x1), (y0, y1)) = (xs.1[x], ys.1[y]);
    let mut out;
    if lx < level {
        out = vec![(x, y0), (x, y1)];
        if scheme == Scheme::DiamondSquare {
            out.extend(beside(xs, x, level).into_iter().map(|m| (m, y)));
        }
    } else if ly < level {
        out = vec![(x0, y), (x1, y)];
        if scheme == Scheme::DiamondSquare {
            out.extend(beside(ys, y, level).into_iter().map(|m| (x, m)));
        }
    } else {
        out = vec![(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
    }
    (level, out)
}

/// Both passes, and the number of rounds and of cells known between them. `order` permutes every queue.
fn brute_force(
    constraints: &Heightfield,
    node: &Mcmd,
    order: impl Fn(&mut Vec<Cell>),
) -> (Vec<f32>, u64, usize) {
    let (rows, cols) = constraints.grid().size();
    let (xs, ys) = (axis(cols), axis(rows));
    let shape = node.displacement.shape(node.flanks, node.large_forms);
    let range = constraints.range();
    let datum = range.map_or(0.0, |range| f64::from(range.0));
    let relief = range.map_or(1.0, |(low, high)| f64::from(high) - f64::from(low));
    let relief = if relief > 0.0 { relief } else { 1.0 };
    let diagonal = libm::hypot((cols - 1) as f64, (rows - 1) as f64);
    let alpha = |height: f32, (x, y): Cell, (cx, cy): Cell, l: f64| {
        let distance = libm::hypot(x.abs_diff(cx) as f64, y.abs_diff(cy) as f64);
        let height = f64::from(height);
        if l == 0.0 { height } else { datum + (height - datum) * falloff(distance / diagonal, l) }
    };
    let mut heights = constraints.cells().to_vec();
    let index = |(x, y): Cell| y * cols + x;

    let all: Vec<Cell> = (0..rows * cols).map(|i| (i % cols, i / cols)).collect();
    let mut queue: Vec<Cell> = all.iter().copied().filter(|&cell| !heights[index(cell)].is_nan()).collect();
    let mut rounds = 0;
    while !queue.is_empty() {
        rounds += 1;
        order(&mut queue);
        let mut told: BTreeMap<(usize, usize), Vec<Cell>> = BTreeMap::new();
        for &cell in &queue {
            for (x, y) in ascendants(node.subdivision.scheme, &xs, &ys, cell).1 {
                if heights[index((x, y))].is_nan() {
                    told.entry((y, x)).or_default().push(cell);
                }
            }
        }
        queue = told.keys().map(|&(y, x)| (x, y)).collect();
        for ((y, x), mut children) in told {
            children.sort_by_key(|&(x, y)| (y, x));
            let terms = children.iter().map(|&child| alpha(heights[index(child)], (x, y), child, shape.l_bu));
            heights[index((x, y))] = (terms.sum::<f64>() / children.len() as f64) as f32;
        }
    }
    let known: Vec<f32> = heights.iter().copied().filter(|height| !height.is_nan()).collect();

    // One node seed of 0 and a run seed of 0: what the tests below run with.
    let noise = |(x, y): Cell| signed_unit(key(mix64(node.chance.seed), 0x6D63_6D64, x as i64, y as i64));
    let by_row: Vec<f64> = heights
        .chunks(cols)
        .map(|row| row.iter().filter(|height| !height.is_nan()).fold(0.0, |sum, &h| sum + f64::from(h)))
        .collect();
    let mean =
        if known.is_empty() { datum } else { by_row.iter().fold(0.0, |a, b| a + b) / known.len() as f64 };
    for cell in [(0, 0), (cols - 1, 0), (0, rows - 1), (cols - 1, rows - 1)] {
        if heights[index(cell)].is_nan() {
            let shift = if rows * cols > 1 { noise(cell) * shape.rs * relief / 2.0 } else { 0.0 };
            heights[index(cell)] = (mean + shift) as f32;
        }
    }
    let mut cells: Vec<(usize, bool, Cell)> = all
        .iter()
        .map(|&cell| {
            (ascendants(node.subdivision.scheme, &xs, &ys, cell).0, xs.0[cell.0] != ys.0[cell.1], cell)
        })
        .collect();
    cells.sort_by_key(|&(level, edge, (x, y))| (level, edge, y, x));
    for (level, edge, cell) in cells {
        if heights[index(cell)].is_nan() {
            let (_, from) = ascendants(node.subdivision.scheme, &xs, &ys, cell);
            let sum: f64 = from.iter().map(|&other| alpha(heights[index(other)], other, cell, shape.l)).sum();
            let gain = if edge { 1.0 } else { node.centers.center_gain };
            let unit = shape.rs * relief * libm::pow(2.0, -(level as f64) * 2.0 * shape.hurst) * gain;
            let shift = if shape.rs == 0.0 { 0.0 } else { (noise(cell) + shape.rt) * unit };
            heights[index(cell)] = (sum / from.len() as f64 + shift) as f32;
        }
    }
    (heights, rounds, known.len())
}

const SIZES: [(usize, usize); 13] = [
    (5, 513),
    (33, 33),
    (33, 17),
    (31, 20),
    (9, 2),
    (7, 1),
    (64, 64),
    (1, 1),
    (1, 2),
    (2, 2),
    (1, 50),
    (5, 90),
    (130, 3),
];

/// About one cell in 40 known, at least one.
fn scattered(rows: usize, cols: usize, seed: u64) -> Heightfield {
    field(rows, cols, |row, col| {
        let bits = key(seed, 1, col as i64, row as i64);
        let lone = (row, col) == (rows / 2, cols / 3);
        if lone || bits.is_multiple_of(40) { 1000.0 * signed_unit(mix64(bits)) } else { f64::NAN }
    })
}

fn rough(rs: f64) -> Displacement {
    Displacement { rs, ..Displacement::default() }
}

fn settings() -> Vec<Mcmd> {
    let mut all = Vec::new();
    for scheme in [Scheme::TriangleEdge, Scheme::DiamondSquare] {
        for (l, l_bu, rt, rs) in
            [(0.0, 0.0, 0.0, 0.0), (-0.4, 6.0, 0.0, 0.25), (1.0, 0.0, -0.9, 0.0), (0.0, -1.0, 1.0, 1.0)]
        {
            let center_gain = if rs > 0.5 { 1.5 } else { 1.0 };
            all.push(Mcmd {
                subdivision: Subdivision { scheme },
                flanks: Flanks { l },
                large_forms: LargeForms { l_bu },
                displacement: Displacement { rt, rs, ..Displacement::default() },
                centers: Centers { center_gain },
                chance: Chance { seed: 7 },
                ..Mcmd::default()
            });
        }
    }
    all
}

fn run(node: &Mcmd, constraints: &Heightfield) -> (Vec<f32>, Table) {
    let out = node.run(McmdIn { constraints }, &Job::detached()).unwrap();
    (out.terrain.into_cells(), out.report)
}

fn bits(heights: &[f32]) -> Vec<u32> {
    heights.iter().map(|height| height.to_bits()).collect()
}

#[test]
fn the_fast_passes_equal_brute_force_to_the_bit_and_keep_every_constraint() {
    for (rows, cols) in SIZES {
        let constraints = scattered(rows, cols, 3);
        for node in settings() {
            let (heights, report) = run(&node, &constraints);
            let (expected, rounds, known) = brute_force(&constraints, &node, |_| {});
            assert_eq!(bits(&heights), bits(&expected), "{rows} × {cols}, {node:?}");
            assert_eq!(report.metric("mdbu_rounds"), Some(rounds as f64));
            assert_eq!(report.metric("known_after_mdbu"), Some(known as f64));
            for (&height, &known) in heights.iter().zip(constraints.cells()) {
                assert!(height.is_finite());
                assert!(known.is_nan() || known.to_bits() == height.to_bits());
            }
        }
    }
}

#[test]
fn the_order_of_the_queue_does_not_matter() {
    let constraints = scattered(33, 20, 5);
    for node in settings() {
        let plain = brute_force(&constraints, &node, |_| {});
        let shuffled = brute_force(&constraints, &node, |queue| {
            queue.sort_by_key(|&(x, y)| key(9, 9, x as i64, y as i64))
        });
        assert_eq!(bits(&plain.0), bits(&shuffled.0));
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let constraints = scattered(200, 333, 5);
    for node in settings() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            bits(&pool.install(|| run(&node, &constraints)).0)
        };
        let one = on(1);
        assert!(one == on(2) && one == on(8));
    }
}

#[test]
fn corners_on_a_plane_give_the_plane_exactly() {
    for side in [2, 3, 5, 17, 129] {
        let plane = |row: usize, col: usize| 100.0 + col as f64 + 2.0 * row as f64;
        let last = side - 1;
        let corners =
            field(
                side,
                side,
                |row, col| if row % last == 0 && col % last == 0 { plane(row, col) } else { f64::NAN },
            );
        let (heights, _) = run(&Mcmd::default(), &corners);
        assert_eq!(bits(&heights), bits(field(side, side, plane).cells()), "{side}");
    }
}

#[test]
fn empty_infinite_and_unconstrained_inputs_are_met() {
    let job = Job::detached();
    let node = Mcmd { displacement: rough(0.5), ..Mcmd::default() };
    let none = field(0, 0, |_, _| 0.0);
    assert!(matches!(node.run(McmdIn { constraints: &none }, &job), Err(Error::EmptyInput { .. })));
    let infinite = field(2, 3, |row, _| if row == 1 { f64::INFINITY } else { 0.0 });
    let error = node.run(McmdIn { constraints: &infinite }, &job).err();
    assert!(matches!(error, Some(Error::NonFinite { row: 1, col: 0, .. })), "{error:?}");
    let (heights, report) = run(&node, &field(9, 9, |_, _| f64::NAN));
    assert!(heights.iter().all(|height| height.is_finite() && height.abs() < 2.0));
    assert_eq!(report.metric("mdbu_rounds"), Some(0.0));
    assert_eq!(run(&node, &field(1, 1, |_, _| f64::NAN)).0, [0.0]);
    assert_eq!(run(&node, &field(1, 1, |_, _| 42.0)).0, [42.0]);
}

#[test]
fn a_clamp_holds_computed_heights_alone() {
    use crate::mcmd::settings::Clamp;
    let constraints = scattered(64, 64, 8);
    let node = Mcmd {
        flanks: Flanks { l: -1.0 },
        displacement: rough(2.0),
        limits: Limits { clamp: Clamp::Levels, lowest: -1.0, highest: 1.0 },
        ..Mcmd::default()
    };
    let (heights, _) = run(&node, &constraints);
    for (&height, &known) in heights.iter().zip(constraints.cells()) {
        assert!(if known.is_nan() { height.abs() <= 1.0 } else { known.to_bits() == height.to_bits() });
    }
}
