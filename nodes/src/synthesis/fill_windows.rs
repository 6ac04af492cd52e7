//! Filling what features left open, window by window, outwards from what is known.
//!
//! Zhou 2007 §5.5. Of the windows that hold both known and unknown cells the one with most known cells comes next; the
//! exemplar is searched for the best places, a cut decides among them. Departure of the default rules: only a band of
//! known ground beside the gap is compared and may be replaced, a third of a patch wide, so that what features put in
//! place stays.

use orograph_core::prelude::*;
use orograph_core::{Patch, key, unit};
use rayon::prelude::*;

use super::{
    canvas::{Canvas, Sheet, Window},
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
    let stage = job.stage(places.len() as u64);
    while let Some(next) = next(&places, layout) {
        job.check()?;
        let window = places[next].window;
        let which = style(canvas, &window);
        let pasted = if places[next].known == 0 {
            plant(canvas, &sources.exemplars[which], which, &window, uses, rules, job)?
        } else {
            grow(canvas, sources, which, &window, layout, uses, rules, job)?
        };
        places[next].tried = true;
        stage.advance(1);
        if pasted {
            counts.pasted += 1;
            for place in places.iter_mut().filter(|place| place.window.touches(&window)) {
                place.known = known(canvas, &place.window);
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

/// Pastes a window drawn by the seed where nothing is known.
fn plant(
    canvas: &mut Canvas,
    exemplar: &Exemplar,
    which: usize,
    window: &Window,
    uses: &mut Uses,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<bool> {
    let (rows, cols) = exemplar.terrain.grid().size();
    if window.rows > rows || window.cols > cols {
        return Ok(false);
    }
    for i in 0..N_SEEDS {
        let draw = |axis: i64, n: usize| (unit(key(rules.seed, STREAM, i, axis)) * (n + 1) as f64) as usize;
        let (row, col) = (draw(0, rows - window.rows), draw(1, cols - window.cols));
        if exemplar.voids.is_whole(row as i64, col as i64, window.rows, window.cols) {
            let found = Found { row, col, mismatch: 0.0, lift: 0.0 };
            let open = vec![true; window.len()];
            let (sheet, old) = sheet(canvas, exemplar, window, &found, &open);
            let seam = canvas.seam(&sheet.window, &sheet.heights, &[], &old, [0.0; 2], rules, job)?;
            paste(canvas, exemplar, which, window, &found, (&sheet, &old, &seam), uses, rules, job)?;
            return Ok(true);
        }
    }
    Ok(false)
}

/// Continues known ground into a window.
#[expect(clippy::too_many_arguments, reason = "one step of a loop, whose state it takes apart")]
fn grow(
    canvas: &mut Canvas,
    sources: &Sources<'_>,
    which: usize,
    window: &Window,
    layout: &Layout,
    uses: &mut Uses,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<bool> {
    let exemplar = &sources.exemplars[which];
    let old = canvas.part(window);
    let open: Vec<bool> = old.iter().map(|height| height.is_nan()).collect();
    let band = if rules.strict() { window.len() } else { rules.patch / 3 };
    let near = near_open(&open, window.cols, band);
    let compared: Vec<f32> =
        old.iter().zip(&near).map(|(&height, &near)| if near { height } else { f32::NAN }).collect();
    let query = Query {
        cols: window.cols,
        heights: &compared,
        open: &open,
        lift: rules.lift.map(|share| share * exemplar.range),
        most_lines: layout.most_lines,
        usual_lines: if rules.strict() { 0.0 } else { 0.7 },
        n: rules.n_fill.max(1),
    };
    let reach = rules.patch as f64 / 2.0;
    // What was shown twice waits until nothing else fits: the eye finds a third time at once.
    let mut found = Vec::new();
    let shown = if rules.strict() { usize::MAX } else { SHOWN.min(rules.max_uses) };
    for most in [shown, rules.max_uses, usize::MAX] {
        if found.is_empty() {
            let spent = |center: [f64; 2]| uses.near(which, center, reach) >= most;
            found = sources.searchers[which].search(&query, spent, job)?;
        }
    }
    found.truncate(rules.n_cut);
    let judged: Vec<(f64, Sheet, Vec<f32>, Seam)> = found
        .par_iter()
        .map(|found| {
            let (sheet, old) = sheet(canvas, exemplar, window, found, &near);
            let seam = canvas.seam(&sheet.window, &sheet.heights, &[], &old, [0.0; 2], rules, job)?;
            let center =
                [found.row as f64 + window.rows as f64 / 2.0, found.col as f64 + window.cols as f64 / 2.0];
            let n_compared = compared.iter().filter(|height| !height.is_nan()).count() as f64;
            let cost = if rules.strict() {
                found.mismatch * n_compared + seam.cost
            } else {
                let step = exemplar.step.max(f64::MIN_POSITIVE);
                let cost = found.mismatch.sqrt() / step + seam.mean_cost() / step;
                cost * (1.0 + 2.0 * rules.repetition * uses.near(which, center, 2.0 * reach) as f64)
            };
            Ok((cost, sheet, old, seam))
        })
        .collect::<Result<_>>()?;
    let Some(best) = (0..judged.len()).min_by(|&a, &b| judged[a].0.total_cmp(&judged[b].0)) else {
        return Ok(false);
    };
    let (_, sheet, old, seam) = &judged[best];
    paste(canvas, exemplar, which, window, &found[best], (sheet, old, seam), uses, rules, job)
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

#[expect(clippy::too_many_arguments, reason = "one step of a loop, whose state it takes apart")]
fn paste(
    canvas: &mut Canvas,
    _exemplar: &Exemplar,
    which: usize,
    window: &Window,
    found: &Found,
    (sheet, old, seam): (&Sheet, &[f32], &Seam),
    uses: &mut Uses,
    rules: &Rules,
    job: &Job<'_>,
) -> Result<bool> {
    let half = [window.rows as f64 / 2.0, window.cols as f64 / 2.0];
    let source_center = [found.row as f64 + half[0], found.col as f64 + half[1]];
    let patch = Patch {
        exemplar: which as u32,
        source_center,
        target_center: [window.top as f64 + half[0], window.left as f64 + half[1]],
        size: window.rows.max(window.cols) as u32,
        mirrored: false,
        controls: Vec::new(),
        offset: found.lift,
    };
    let framed = sheet.window;
    let source = |i: usize| {
        let (row, col) = framed.cell(i);
        [(found.row + row) as f64 - window.top as f64, (found.col + col) as f64 - window.left as f64]
    };
    uses.add(which, source_center);
    Ok(canvas.paste(sheet, old, seam, patch, source, rules, job)? > 0)
}

/// Cells within `band` cells, along rows and columns added up, of an open one, open ones included.
fn near_open(open: &[bool], cols: usize, band: usize) -> Vec<bool> {
    let far = u32::MAX / 2;
    let mut distance: Vec<u32> = open.iter().map(|&open| if open { 0 } else { far }).collect();
    let n = distance.len();
    for i in 0..n {
        let west = if i % cols > 0 { distance[i - 1] } else { far };
        let north = if i >= cols { distance[i - cols] } else { far };
        distance[i] = distance[i].min(west.min(north) + 1);
    }
    for i in (0..n).rev() {
        let east = if (i + 1) % cols > 0 { distance[i + 1] } else { far };
        let south = if i + cols < n { distance[i + cols] } else { far };
        distance[i] = distance[i].min(east.min(south) + 1);
    }
    distance.into_iter().map(|distance| distance as usize <= band).collect()
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
