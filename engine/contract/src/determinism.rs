//! Equal inputs give equal bits: on any number of threads, tile by tile, in any undeclared context.

use std::sync::LazyLock;

use orograph_core::{Context, ContextItem, Extent, Job, NodeType, Slot, Value};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{
    defaults,
    host::MemoryHost,
    inputs::{Cover, crop, digests, slots, terrain},
    needs_no_file,
};

/// Outputs at defaults, or the error's text; nothing for nodes that are tested elsewhere.
fn outputs(node: &NodeType, slots: &[Slot], context: Context) -> Option<Result<Vec<Value>, String>> {
    if node.spec().writes || !needs_no_file(node) {
        return None;
    }
    let host = MemoryHost::default();
    let ran =
        node.instantiate(&defaults(node)).and_then(|instance| instance.run(slots, &Job::new(&host, context)));
    Some(ran.map_err(|error| error.to_string()))
}

/// A preview's resolution keeps generators small.
pub(crate) const CONTEXT: Context = Context { seed: 5, resolution: Some(48) };

/// Pools of 1, 2 and 8 threads, as many as the system gives.
static POOLS: LazyLock<Vec<ThreadPool>> = LazyLock::new(|| {
    [1, 2, 8].map(|n| ThreadPoolBuilder::new().num_threads(n).build()).into_iter().flatten().collect()
});

/// Equal inputs give equal bits on 1, 2 and 8 threads.
#[must_use]
pub fn any_number_of_threads(node: &NodeType) -> Vec<String> {
    let slots = slots(node.spec(), &terrain(130, 117, Cover::Holes), true);
    let runs: Vec<_> = POOLS
        .iter()
        .filter_map(|pool| pool.install(|| outputs(node, &slots, CONTEXT)))
        .map(|run| run.map(|values| digests(&values)))
        .collect();
    let equal = runs.windows(2).all(|pair| pair[0] == pair[1]);
    if equal { vec![] } else { vec!["1, 2 and 8 threads differ".into()] }
}

/// Seed and resolution count where they are declared, and there alone.
#[must_use]
pub fn undeclared_context(node: &NodeType) -> Vec<String> {
    let slots = slots(node.spec(), &terrain(33, 29, Cover::Holes), false);
    let reads = |item| node.spec().reads.contains(&item);
    let run = |context| outputs(node, &slots, context).map(|run| run.map(|values| digests(&values)));
    let plain = run(CONTEXT);
    let mut complaints = Vec::new();
    if !reads(ContextItem::Seed) && run(Context { seed: 6, ..CONTEXT }) != plain {
        complaints.push("it reads the seed and does not say so".into());
    }
    if !reads(ContextItem::Resolution) && run(Context { resolution: Some(31), ..CONTEXT }) != plain {
        complaints.push("it reads the resolution and does not say so".into());
    }
    if reads(ContextItem::Resolution) && run(Context { resolution: Some(31), ..CONTEXT }) == plain {
        complaints.push("it says that it reads the resolution and does not".into());
    }
    complaints
}

/// A local node gives the same bits tile by tile, with its halo, as on the whole.
#[must_use]
pub fn tile_by_tile(node: &NodeType) -> Vec<String> {
    [Cover::Whole, Cover::Holes].into_iter().flat_map(|cover| tiles_differ(node, cover)).collect()
}

fn tiles_differ(node: &NodeType, cover: Cover) -> Vec<String> {
    let field = terrain(70, 53, cover);
    if node.spec().extent != Extent::Local || node.spec().inputs.is_empty() {
        return vec![];
    }
    let all = slots(node.spec(), &field, true);
    let Some(whole) = outputs(node, &all, CONTEXT) else {
        return vec![];
    };
    let whole = match whole {
        Ok(whole) => whole,
        Err(error) => return vec![format!("it fails on a plain terrain: {error}")],
    };
    if whole.iter().any(|value| value.grid().is_none_or(|grid| grid.size() != (70, 53))) {
        return vec!["it is local, but an output has another grid than the input".into()];
    }
    let Ok(instance) = node.instantiate(&defaults(node)) else {
        return vec![];
    };
    let halo = instance.halo(field.grid().cell);
    tiles(70, 53)
        .into_iter()
        .filter(|&tile| {
            let (outer, inner) = with_halo(tile, halo, 70, 53);
            let inputs: Vec<_> = all.iter().map(|slot| crop_slot(slot, outer)).collect();
            let parts = outputs(node, &inputs, CONTEXT).and_then(Result::ok).unwrap_or_default();
            let parts: Vec<_> = parts.iter().map(|part| crop(part, inner)).collect();
            let expected: Vec<_> = whole.iter().map(|value| crop(value, tile)).collect();
            digests(&parts) != digests(&expected)
        })
        .map(|tile| format!("tile {tile:?} with halo {halo} differs from the whole ({cover:?})"))
        .collect()
}

fn crop_slot(slot: &Slot, part: [usize; 4]) -> Slot {
    match slot {
        Slot::Empty => Slot::Empty,
        Slot::One(value) => Slot::One(crop(value, part)),
        Slot::Many(values) => Slot::Many(values.iter().map(|value| crop(value, part)).collect()),
    }
}

/// Tiles (row, column, rows, columns) of unequal size that cover the grid.
fn tiles(rows: usize, cols: usize) -> Vec<[usize; 4]> {
    let mut tiles = Vec::new();
    for row in (0..rows).step_by(32) {
        for col in (0..cols).step_by(19) {
            tiles.push([row, col, 32.min(rows - row), 19.min(cols - col)]);
        }
    }
    tiles
}

/// The tile with its halo, and the tile's place within that.
fn with_halo(
    [row, col, n_rows, n_cols]: [usize; 4],
    halo: usize,
    rows: usize,
    cols: usize,
) -> ([usize; 4], [usize; 4]) {
    let (top, left) = (row.saturating_sub(halo), col.saturating_sub(halo));
    let (bottom, right) =
        ((row + n_rows).saturating_add(halo).min(rows), (col + n_cols).saturating_add(halo).min(cols));
    ([top, left, bottom - top, right - left], [row - top, col - left, n_rows, n_cols])
}
