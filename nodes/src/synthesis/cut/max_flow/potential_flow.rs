//! A flow to begin with: on a plane, differences of potentials that stand where the cells' corners meet.
//!
//! After Hassin 1981. Any numbers at the corners of cells that differ along the side between two cells by no more than
//! can flow over that side make a flow that loses nothing anywhere; distances from where the seam begins are such
//! numbers. A strip with the source along one side and the sink along the other gets its maximal flow so, in the time of
//! one search for a shortest path; other shapes get a good part of theirs.
//!
//! Cells that nothing flows through belong to the pins that they lie next to. The seam begins and ends where the land of
//! the source meets that of the sink, on the left or on the right of those who look from one to the other.

use orograph_core::{Job, Result};

use super::{Cell, EAST, FREE, NORTH, SOURCE, SOUTH, WEST};

/// Cells or corners between two looks at whether to stop.
const CHECK_EVERY: usize = 1 << 16;

/// Sets a flow in `cells`, rows of `stride` with a frame that nothing flows into, which carry none yet.
///
/// # Errors
/// Cancellation.
pub(super) fn set(cells: &mut [Cell], stride: usize, job: &Job<'_>) -> Result<()> {
    let land = land(cells, stride, job)?;
    let (begins, ends) = tips(&land, stride, job)?;
    if begins.is_empty() || ends.is_empty() {
        return Ok(());
    }
    job.check()?;
    let potential = distances(cells, &land, stride, &begins, &ends, job)?;
    let mut flow = |from: usize, to: usize, direction: usize, most: u64, least: u64| {
        if land[from] == FREE || land[to] == FREE {
            // As large as what either can carry, and so are these sums.
            let flow = (most as i64 - least as i64) as i32;
            cells[from].rest[direction] = cells[from].rest[direction].wrapping_sub_signed(flow);
            cells[to].rest[direction ^ 2] = cells[to].rest[direction ^ 2].wrapping_add_signed(flow);
        }
    };
    for i in 0..land.len() - stride {
        if i.is_multiple_of(CHECK_EVERY) {
            job.check()?;
        }
        flow(i, i + 1, EAST, potential[i], potential[i + stride]);
        flow(i, i + stride, SOUTH, potential[i + stride], potential[i + stride - 1]);
    }
    Ok(())
}

/// Whose land each cell is: that of pins, and of cells that nothing flows through.
fn land(cells: &[Cell], stride: usize, job: &Job<'_>) -> Result<Vec<u8>> {
    let mut land: Vec<u8> = cells.iter().map(|cell| cell.tree).collect();
    let mut reached: Vec<u32> = Vec::new();
    let mut next = 0;
    let mut spread = |i: usize, reached: &mut Vec<u32>| {
        for j in [i.wrapping_sub(1), i.wrapping_sub(stride), i + 1, i + stride] {
            if land.get(j) == Some(&FREE) && cells[j].rest == [0; 4] {
                land[j] = land[i];
                reached.push(j as u32);
            }
        }
    };
    job.check()?;
    for (i, cell) in cells.iter().enumerate() {
        if i.is_multiple_of(CHECK_EVERY) {
            job.check()?;
        }
        if cell.tree != FREE {
            spread(i, &mut reached);
        }
    }
    while let Some(&i) = reached.get(next) {
        next += 1;
        if next.is_multiple_of(CHECK_EVERY) {
            job.check()?;
        }
        spread(i as usize, &mut reached);
    }
    Ok(land)
}

/// The corners where seams begin and those where they end. A corner has the number of the cell south-west of it.
fn tips(land: &[u8], stride: usize, job: &Job<'_>) -> Result<(Vec<u32>, Vec<u32>)> {
    // Where both lands touch, what flowed through comes back: of each such side the corner on the left of who goes from
    // the sink to the source counts up, that on the right down, and what is left over are the tips.
    let mut count = vec![0_i8; land.len() + stride];
    let mut touch = |from: usize, to: usize, left: usize, right: usize| {
        if land[from] != FREE && land[to] != FREE && land[from] != land[to] {
            let back = if land[from] == SOURCE { -1 } else { 1 };
            count[left] += back;
            count[right] -= back;
        }
    };
    for i in 0..land.len() {
        if i.is_multiple_of(CHECK_EVERY) {
            job.check()?;
        }
        // The frame's last cell of a row does not touch the first of the next.
        if (i + 1) % stride != 0 {
            touch(i, i + 1, i, i + stride);
        }
        if i + stride < land.len() {
            touch(i, i + stride, i + stride, i + stride - 1);
        }
    }
    // Tips on the outermost corners are no part of the plane that is searched.
    let inner = stride..land.len();
    let with = |sign: i8| {
        let is_tip = |&corner: &usize| count[corner].signum() == sign && (corner + 1) % stride != 0;
        inner.clone().filter(is_tip).map(|corner| corner as u32).collect()
    };
    Ok((with(-1), with(1)))
}

/// How far each corner is from where seams begin, up to the farthest of those where they end. A step along the side
/// between two cells is as long as what can still flow from the one on its left to the one on its right.
fn distances(
    cells: &[Cell],
    land: &[u8],
    stride: usize,
    begins: &[u32],
    ends: &[u32],
    job: &Job<'_>,
) -> Result<Vec<u64>> {
    let mut taken = 0_usize;
    let mut distance = vec![u64::MAX; land.len() + stride];
    // No step leads to corners of the outermost cells.
    distance[..stride].fill(0);
    distance[land.len()..].fill(0);
    distance.iter_mut().skip(stride - 1).step_by(stride).for_each(|distance| *distance = 0);
    let mut to_go = vec![false; distance.len()];
    ends.iter().for_each(|&end| to_go[end as usize] = true);
    let mut n_to_go = ends.len();
    let mut queue = Queue::new(begins);
    begins.iter().for_each(|&begin| distance[begin as usize] = 0);
    while n_to_go > 0 {
        let Some((now, corner)) = queue.pop() else { break };
        taken += 1;
        if taken.is_multiple_of(CHECK_EVERY) {
            job.check()?;
        }
        let k = corner as usize;
        if distance[k] != now {
            continue;
        }
        n_to_go -= usize::from(std::mem::take(&mut to_go[k]));
        let [north_west, north_east, south_west, south_east] = [k - stride, k - stride + 1, k, k + 1];
        let steps = [
            (k + 1, north_east, south_east, SOUTH),
            (k - 1, south_west, north_west, NORTH),
            (k + stride, south_east, south_west, WEST),
            (k - stride, north_west, north_east, EAST),
        ];
        for (to, from_cell, to_cell, direction) in steps {
            let there = now + u64::from(cells[from_cell].rest[direction]);
            if there < distance[to] && (land[from_cell] == FREE || land[to_cell] == FREE) {
                distance[to] = there;
                queue.push(there, to as u32);
            }
        }
    }
    let farthest = queue.last;
    distance.iter_mut().for_each(|distance| *distance = farthest.min(*distance));
    Ok(distance)
}

/// Corners by distance, none of which comes in nearer than what was last taken out (a radix heap): each lies in the
/// bucket of the highest bit in which it differs from that.
struct Queue {
    last: u64,
    buckets: [Vec<(u64, u32)>; 65],
}

impl Queue {
    /// All at distance 0.
    fn new(corners: &[u32]) -> Self {
        let mut buckets = [const { Vec::new() }; 65];
        buckets[0] = corners.iter().map(|&corner| (0, corner)).collect();
        Self { last: 0, buckets }
    }

    fn push(&mut self, distance: u64, corner: u32) {
        let bucket = u64::BITS - (distance ^ self.last).leading_zeros();
        self.buckets[bucket as usize].push((distance, corner));
    }

    /// One of the nearest.
    fn pop(&mut self) -> Option<(u64, u32)> {
        if self.buckets[0].is_empty() {
            let first = self.buckets.iter().position(|bucket| !bucket.is_empty())?;
            let mut bucket = std::mem::take(&mut self.buckets[first]);
            self.last = bucket.iter().map(|&(distance, _)| distance).min()?;
            bucket.iter().for_each(|&(distance, corner)| self.push(distance, corner));
            bucket.clear();
            self.buckets[first] = bucket;
        }
        self.buckets[0].pop()
    }
}
