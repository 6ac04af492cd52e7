//! Filling what features left open, window by window, outwards from what is known.
//!
//! Zhou 2007 §5.5. Of the windows that hold both known and unknown cells the one with most known cells comes next; the
//! exemplar is searched for the best places, a cut decides among them. Departure of the default rules: only a band of
//! known ground beside the gap is compared and may be replaced, a third of a patch wide, so that what features put in
//! place stays.

use std::cmp::Reverse;

use orograph_core::prelude::*;
use orograph_core::{Patch, key, unit};
use rayon::prelude::*;

use super::{
    canvas::{Canvas, Piece, Sheet, Window},
    cut::Seam,
    exemplar::Exemplar,
    matching::Uses,
    poisson::masked::{self, Cell, Domain},
    settings::Rules,
    ssd::{Found, Query, Searcher},
};

/// Draws of the very first window, when nothing is known.
const STREAM: u64 = 0x7365_6564;
/// Uses of a window that do not strike the eye.
const SHOWN: usize = 2;
/// Places drawn for it.
const N_SEEDS: i64 = 64;
/// Windows that are filled together. A number of its own, so that no result depends on that of threads.
const AT_ONCE: usize = 4;
/// Share of the next window's known cells that another must have to be filled together with it.
const BEHIND: f64 = 0.8;

/// What to fill from: an exemplar and its search, by style.
pub struct Sources<'a> {
    /// The exemplars.
    pub exemplars: &'a [Exemplar],
    /// A search of each.
    pub searchers: &'a [Searcher<'a>],
}

/// How windows lie and follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Side of a window.
    pub side: usize,
    /// Distance between windows.
    pub step: usize,
    /// From top to bottom instead of outwards from what is known.
    pub raster: bool,
    /// Most length of line in what a window fills, in cells; infinite to let features in.
    pub most_lines: f64,
    /// Whether windows smoother than the exemplar usually is count as worse.
    pub balanced: bool,
}

/// What happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Windows pasted.
    pub pasted: usize,
    /// Cells left to the smooth fill.
    pub smoothed: usize,
}

struct Place {
    window: Window,
    known: usize,
    tried: bool,
}

/// Fills every unknown cell of `canvas`; `style` gives the exemplar for a window and its unknown cells.
///
/// # Errors
/// Those of search, cut and seam removal, and cancellation.
pub fn fill(
    canvas: &mut Canvas,
    sources: &Sources<'_>,
    layout: &Layout,
    style: &(dyn Fn(&Canvas, &Window) -> usize + Sync),
    uses: &mut Uses,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<Counts> {
    let mut places = places(canvas.size, layout);
    let mut counts = Counts::default();
    for place in &mut places {
        place.known = known(canvas, &place.window);
    }
    let at_once = if layout.raster || rules.strict() { 1 } else { AT_ONCE };
    let reach = rules.patch as f64;
    let stage = job.stage(places.len() as u64);
    loop {
        job.check()?;
        let round = round(&places, layout, at_once, |window| window.grown(rules.margin + 1, canvas.size));
        if round.is_empty() {
            break;
        }
        let ground = &*canvas;
        let found: Vec<Option<(Piece, Vec<f64>)>> = round
            .par_iter()
            .map(|&at| {
                let window = &places[at].window;
                let which = style(ground, window);
                let piece = if known(ground, &window.grown(rules.margin, ground.size)) == 0 {
                    plant(ground, &sources.exemplars[which], which, window, rules, job)?
                } else {
                    grow(ground, sources, which, window, layout, uses, rules, job)?
                };
                piece.map(|piece| ground.fit(&piece, rules, job).map(|added| (piece, added))).transpose()
            })
            .collect::<Result<_>>()?;
        let mut taken = Uses::default();
        for (&at, found) in round.iter().zip(found) {
            let source =
                found.as_ref().map(|(piece, _)| (piece.patch.exemplar as usize, piece.patch.source_center));
            if source.is_some_and(|(which, center)| taken.near(which, center, reach) > 0) {
                // Another of the round has the same ground: this one chooses again, knowing that.
                continue;
            }
            let window = places[at].window;
            places[at].tried = true;
            stage.advance(1);
            let (Some((piece, added)), Some((which, center))) = (found, source) else { continue };
            uses.add(which, center);
            taken.add(which, center);
            if canvas.paste(piece, &added) > 0 {
                counts.pasted += 1;
                for place in places.iter_mut().filter(|place| place.window.touches(&window)) {
                    place.known = known(canvas, &place.window);
                }
            }
        }
    }
    counts.smoothed = smooth(canvas, sources.exemplars, job)?;
    Ok(counts)
}

fn places(size: (usize, usize), layout: &Layout) -> Vec<Place> {
    let axis = |n: usize| {
        let step = layout.step.max(1);
        let mut centers: Vec<usize> = (0..).map(|i| step / 2 + i * step).take_while(|&at| at < n).collect();
        let last = n.saturating_sub(step / 2).min(n.saturating_sub(1));
        if centers.last().is_none_or(|&at| at + layout.side / 2 < n) {
            centers.push(last);
        }
        centers
    };
    let (rows, cols) = (axis(size.0), axis(size.1));
    let place = |row: usize, col: usize| {
        let window = Window::around(row as i64, col as i64, layout.side, size);
        Place { window, known: 0, tried: false }
    };
    rows.iter()
        .flat_map(|&row| cols.iter().map(move |&col| (row, col)))
        .map(|(row, col)| place(row, col))
        .collect()
}

fn known(canvas: &Canvas, window: &Window) -> usize {
    let of_row = |row: usize| {
        let cells = &canvas.heights[(window.top + row) * canvas.size.1 + window.left..][..window.cols];
        cells.iter().filter(|height| !height.is_nan()).count()
    };
    (0..window.rows).map(of_row).sum()
}

/// The window to go on with.
fn next(places: &[Place], layout: &Layout) -> Option<usize> {
    let open = |place: &Place| !place.tried && place.known < place.window.len();
    if layout.raster {
        return places.iter().position(open);
    }
    let mut best: Option<usize> = None;
    for (i, place) in places.iter().enumerate().filter(|(_, place)| open(place)) {
        if best.is_none_or(|best| place.known > places[best].known) {
            best = Some(i);
        }
    }
    let best = best?;
    // Nothing known anywhere: begin in the middle.
    let middle = places.len() / 2;
    Some(if places[best].known == 0 && open(&places[middle]) { middle } else { best })
}

/// The windows to go on with together: the next one, and others not far behind it that share no cell with it or with
/// each other, so that none needs to know of the rest.
fn round(
    places: &[Place],
    layout: &Layout,
    at_once: usize,
    touched: impl Fn(&Window) -> Window,
) -> Vec<usize> {
    let Some(first) = next(places, layout) else { return Vec::new() };
    let mut round = vec![first];
    let least = places[first].known as f64 * BEHIND;
    if at_once > 1 && least > 0.0 {
        let follows =
            |place: &Place| !place.tried && place.known < place.window.len() && place.known as f64 >= least;
        let mut others: Vec<usize> = (0..places.len()).filter(|&i| follows(&places[i])).collect();
        others.sort_by_key(|&i| (Reverse(places[i].known), i));
        for other in others {
            let window = touched(&places[other].window);
            if round.len() < at_once && round.iter().all(|&i| !touched(&places[i].window).touches(&window)) {
                round.push(other);
            }
        }
    }
    round
}

/// A window drawn by the seed where nothing is known.
fn plant(
    canvas: &Canvas,
    exemplar: &Exemplar,
    which: usize,
    window: &Window,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<Option<Piece>> {
    let (rows, cols) = exemplar.terrain.grid().size();
    if window.rows > rows || window.cols > cols {
        return Ok(None);
    }
    for i in 0..N_SEEDS {
        let draw = |axis: i64, n: usize| (unit(key(rules.seed, STREAM, i, axis)) * (n + 1) as f64) as usize;
        let (row, col) = (draw(0, rows - window.rows), draw(1, cols - window.cols));
        if exemplar.voids.is_whole(row as i64, col as i64, window.rows, window.cols) {
            let found = Found { row, col, mismatch: 0.0, lift: 0.0, weight: 1.0 };
            let open = vec![true; window.len()];
            let (sheet, old) = sheet(canvas, exemplar, window, &found, &open);
            let seam = canvas.seam(&sheet.window, &sheet.heights, &[], &old, [0.0; 2], rules, job)?;
            return Ok(Some(piece(which, window, &found, sheet, old, seam)));
        }
    }
    Ok(None)
}

/// Continues known ground into a window.
#[expect(clippy::too_many_arguments, reason = "one step of a loop, whose state it takes apart")]
fn grow(
    canvas: &Canvas,
    sources: &Sources<'_>,
    which: usize,
    window: &Window,
    layout: &Layout,
    uses: &Uses,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<Option<Piece>> {
    let exemplar = &sources.exemplars[which];
    let (inner, window) = (window, &window.grown(rules.margin, canvas.size));
    let old = canvas.part(window);
    let band = if rules.strict() { window.len() } else { rules.patch / 3 };
    let (open, near) = canvas.reached(window, inner, &old, band);
    let compared: Vec<f32> =
        old.iter().zip(&near).map(|(&height, &near)| if near { height } else { f32::NAN }).collect();
    let query = Query {
        cols: window.cols,
        heights: &compared,
        open: &open,
        lift: rules.lift.map(|share| share * exemplar.range),
        most_lines: layout.most_lines,
        usual_lines: if rules.strict() { 0.0 } else { 0.7 },
        balanced: layout.balanced,
        n: rules.n_fill.max(1),
    };
    let reach = rules.patch as f64 / 2.0;
    // What was shown twice waits until nothing else fits: the eye finds a third time at once.
    let shown = if rules.strict() { usize::MAX } else { SHOWN.min(rules.max_uses) };
    let most = [shown, rules.max_uses, usize::MAX];
    let served = |center: [f64; 2]| uses.near(which, center, reach);
    let mut found = sources.searchers[which].search(&query, &most, served, job)?;
    found.truncate(rules.n_cut);
    let judged: Vec<(f64, Piece)> = found
        .par_iter()
        .map(|found| {
            let (sheet, old) = sheet(canvas, exemplar, window, found, &near);
            let seam = canvas.seam(&sheet.window, &sheet.heights, &[], &old, [0.0; 2], rules, job)?;
            let piece = piece(which, window, found, sheet, old, seam);
            let (seam, center) = (&piece.seam, piece.patch.source_center);
            let n_compared = compared.iter().filter(|height| !height.is_nan()).count() as f64;
            let cost = if rules.strict() {
                found.mismatch * n_compared + seam.cost
            } else {
                let step = exemplar.step.max(f64::MIN_POSITIVE);
                let cost = found.weighed().sqrt() / step + seam.mean_cost() / step;
                cost * (1.0 + 2.0 * rules.repetition * uses.near(which, center, 2.0 * reach) as f64)
            };
            Ok((cost, piece))
        })
        .collect::<Result<_>>()?;
    // The first of equals, which fits better before the cut.
    Ok(judged
        .into_iter()
        .reduce(|best, next| if next.0.total_cmp(&best.0).is_lt() { next } else { best })
        .map(|(_, piece)| piece))
}

/// The exemplar's window in the canvas's, framed; only cells that are open or `near` have heights.
fn sheet(
    canvas: &Canvas,
    exemplar: &Exemplar,
    window: &Window,
    found: &Found,
    near: &[bool],
) -> (Sheet, Vec<f32>) {
    let framed = window.framed(canvas.size);
    let old = canvas.part(&framed);
    let mut heights = vec![f32::NAN; framed.len()];
    let (down, across) = (window.top - framed.top, window.left - framed.left);
    for row in 0..window.rows {
        let source = &exemplar.terrain.row(found.row + row)[found.col..][..window.cols];
        let start = (row + down) * framed.cols + across;
        for (col, &height) in source.iter().enumerate() {
            if near[row * window.cols + col] {
                heights[start + col] = height + found.lift as f32;
            }
        }
    }
    (Sheet { window: framed, heights, core: Vec::new() }, old)
}

/// A window of the exemplar and where it comes from.
fn piece(which: usize, window: &Window, found: &Found, sheet: Sheet, old: Vec<f32>, seam: Seam) -> Piece {
    let half = [window.rows as f64 / 2.0, window.cols as f64 / 2.0];
    let patch = Patch {
        exemplar: which as u32,
        source_center: [found.row as f64 + half[0], found.col as f64 + half[1]],
        target_center: [window.top as f64 + half[0], window.left as f64 + half[1]],
        size: window.rows.max(window.cols) as u32,
        mirrored: false,
        controls: Vec::new(),
        offset: found.lift,
    };
    let source = |i: usize| {
        let (row, col) = sheet.window.cell(i);
        [(found.row + row) as f64 - window.top as f64, (found.col + col) as f64 - window.left as f64]
    };
    let sources = (0..sheet.window.len()).map(source).collect();
    Piece { sheet, old, seam, patch, sources }
}

/// Fills what is still unknown with the smoothest surface, or a plain level when nothing is known. How many cells.
fn smooth(canvas: &mut Canvas, exemplars: &[Exemplar], job: &Job<'_>) -> Result<usize> {
    let left = canvas.heights.iter().filter(|height| height.is_nan()).count();
    if left == 0 {
        return Ok(0);
    }
    let (cols, n) = (canvas.size.1, canvas.heights.len());
    let known = canvas.heights.iter().filter(|height| !height.is_nan());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, n), &height| (sum + f64::from(height), n + 1.0));
    let level = if count > 0.0 {
        sum / count
    } else {
        let cells = exemplars.first().map_or(&[][..], |exemplar| exemplar.terrain.cells());
        let (sum, n) = cells
            .iter()
            .filter(|h| !h.is_nan())
            .fold((0.0, 0.0_f64), |(s, n), &h| (s + f64::from(h), n + 1.0));
        sum / n.max(1.0)
    };
    let cells: Vec<Cell> =
        canvas.heights.iter().map(|height| if height.is_nan() { Cell::Free } else { Cell::Fixed }).collect();
    // Heights above the level: at a free cell the flow from known neighbours is the right side.
    let mut right = vec![0.0; n];
    for i in (0..n).filter(|&i| cells[i] == Cell::Free) {
        let near = [
            (i % cols > 0).then(|| i - 1),
            i.checked_sub(cols),
            ((i + 1) % cols > 0).then_some(i + 1),
            (i + cols < n).then_some(i + cols),
        ];
        let known = near.into_iter().flatten().filter(|&j| cells[j] == Cell::Fixed);
        right[i] = known.map(|j| f64::from(canvas.heights[j]) - level).sum();
    }
    let above = masked::solve(&Domain { cols, cells: &cells, weights: [1.0; 2] }, &right, job)?;
    for i in (0..n).filter(|&i| cells[i] == Cell::Free) {
        canvas.heights[i] = (level + above[i]) as f32;
    }
    Ok(left)
}
