//! Read tile: one tile of a folder, with ground from the tiles around it.
//!
//! Tiles are told apart by the corner in their names, as SRTM's are. What lies beyond an edge comes from the file that is named
//! after the neighbour and lies beside the tile's own, where there is one.

use orograph_core::prelude::*;

use super::{file, hgt, read_dem};

/// Reads a tile and the ground around it from its neighbours' files.
///
/// The tile is named after its south-west corner, such as `N46E008.hgt.zip`.
/// Neighbours are files in the same folder, named alike (`N46E009.hgt.zip`) or `.hgt` or `.hgt.zip`; east of `E179` lies
/// `W180`. Those that are not there are left out. Tiles share the samples on their common edge: where such a sample is a void
/// here and measured there, it is taken from there. Samples measured here are never changed.
#[derive(Params, Clone, Debug)]
pub struct ReadTile {
    /// The file to read.
    #[param(default = "")]
    pub file: InputPath,
    /// How much ground beyond each edge is read.
    #[param(default = 0.1, range = 0.0..=1.0, slider = 0.0..=0.5, unit = "deg")]
    pub margin: f64,
}

/// Outputs of [`ReadTile`].
#[derive(Outputs)]
pub struct ReadTileOut {
    /// The tile.
    pub terrain: Heightfield,
    /// The tile and the ground around, void where nothing is known. It reaches beyond the edges that have a neighbour. On
    /// shared edges it has the samples of the southern and then of the western tile first, so that it is the same for
    /// both.
    pub around: Heightfield,
}

impl Node for ReadTile {
    const ID: &'static str = "io.read_tile";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = ();
    type Outputs = ReadTileOut;

    fn companions(&self, file: &str) -> Vec<String> {
        hgt::neighbours(file).into_iter().flat_map(|(_, names)| names).collect()
    }

    fn run(&self, (): (), job: &Job) -> Result<ReadTileOut> {
        let (bytes, name) = file::load(&self.file, job)?;
        let own = read_dem::read(&bytes, &name, job)?;
        drop(bytes);
        let margin = self.margin_cells(own.grid());
        let mut tiles = Vec::new();
        for ([north, east], names) in hgt::neighbours(&name) {
            let Some((tile, name)) = self.neighbour(&names, job)? else { continue };
            match offset(own.grid(), tile.grid()) {
                Some(first) => {
                    tiles.push(Tile { first, side: [-north, east], terrain: tile }.near(&own, margin, job)?)
                }
                None => job.warn(format!("{name} has cells of another kind and is left out")),
            }
        }
        if tiles.is_empty() {
            return Ok(ReadTileOut { around: own.clone(), terrain: own });
        }
        let around = widened(&own, &tiles, margin, job)?;
        let (grid, wide) = (own.grid(), around.grid());
        let first = [grid.row0 - wide.row0, grid.col0 - wide.col0].map(|cells| cells as usize);
        let middle = around.crop(first[0], first[1], grid.rows, grid.cols, job)?;
        let terrain = own.map_with(&middle, job, |own, shared| if own.is_nan() { shared } else { own })?;
        Ok(ReadTileOut { terrain, around })
    }
}

impl ReadTile {
    /// Rows and columns of the margin; less than a tile, so that no ground is needed of the neighbours' neighbours.
    fn margin_cells(&self, own: &Grid) -> [usize; 2] {
        let Some(Georef { transform, .. }) = own.georef_here() else { return [0; 2] };
        let cells = |step: f64, most: usize| {
            ((self.margin / step.abs()).round() as usize).min(most.saturating_sub(1))
        };
        [cells(transform[5], own.rows), cells(transform[1], own.cols)]
    }

    /// The first of the files that is there, with its name.
    fn neighbour<'a>(&self, names: &'a [String], job: &Job) -> Result<Option<(Heightfield, &'a str)>> {
        for name in names {
            if let Some(path) = job.companion(&self.file, name)? {
                let bytes = file::load_whole(&path, &path.display().to_string(), name, job)?;
                return Ok(Some((read_dem::read(&bytes, name, job)?, name)));
            }
        }
        Ok(None)
    }
}

/// A neighbour: where its first cell lies in the tile's rows and columns, and on which side it is, south and east.
struct Tile {
    first: [i64; 2],
    side: [i32; 2],
    terrain: Heightfield,
}

impl Tile {
    /// What of it lies in the margin around `own`, so that the rest takes no memory.
    fn near(self, own: &Heightfield, margin: [usize; 2], job: &Job) -> Result<Self> {
        let size = [own.rows(), own.cols()];
        let all = [self.terrain.rows(), self.terrain.cols()];
        let (mut first, mut skip, mut keep) = (self.first, [0; 2], [0; 2]);
        for axis in [0, 1] {
            let (low, high) = (-(margin[axis] as i64), (size[axis] + margin[axis]) as i64);
            first[axis] = first[axis].max(low);
            skip[axis] = (first[axis] - self.first[axis]) as usize;
            let end = (self.first[axis] + all[axis] as i64).min(high);
            keep[axis] = usize::try_from(end - first[axis]).unwrap_or(0);
            skip[axis] = skip[axis].min(all[axis] - keep[axis]);
        }
        let terrain = self.terrain.crop(skip[0], skip[1], keep[0], keep[1], job)?;
        Ok(Self { first, terrain, ..self })
    }
}

/// The tile with the ground around, on the sides that have a neighbour.
fn widened(own: &Heightfield, tiles: &[Tile], margin: [usize; 2], job: &Job) -> Result<Heightfield> {
    let grid = own.grid();
    let beyond = |side: [i32; 2]| {
        let is_there = tiles.iter().any(|tile| tile.side == side);
        if is_there { margin[usize::from(side[0] == 0)] } else { 0 }
    };
    let [north, south, west, east] = [[-1, 0], [1, 0], [0, -1], [0, 1]].map(beyond);
    let grid = Grid {
        rows: grid.rows + north + south,
        cols: grid.cols + west + east,
        row0: grid.row0 - north as i64,
        col0: grid.col0 - west as i64,
        ..grid.clone()
    };
    let mut parts: Vec<([i64; 2], &Heightfield)> =
        tiles.iter().map(|tile| (tile.first, &tile.terrain)).chain([([0, 0], own)]).collect();
    // The southern sides come first, then the western: the order is the same whichever of the tiles is in the middle.
    let south_west = |&([row, col], part): &([i64; 2], &Heightfield)| (-(row + part.rows() as i64), col);
    parts.sort_by_key(south_west);
    Heightfield::build(grid, job, |row, out| {
        let row = row as i64 - north as i64;
        for ([first, start], part) in &parts {
            let Some(row) = usize::try_from(row - first).ok().filter(|&row| row < part.rows()) else {
                continue;
            };
            let start = start + west as i64;
            let [skip, start] = [(-start).max(0), start.max(0)].map(|cells| cells as usize);
            for (out, height) in out.iter_mut().skip(start).zip(part.row(row).iter().skip(skip)) {
                if out.is_nan() {
                    *out = *height;
                }
            }
        }
        Ok(())
    })
}

/// Row and column of `own` at which the first cell of `other` lies; `None` unless its cells lie on the same lattice, at most a
/// tile away.
fn offset(own: &Grid, other: &Grid) -> Option<[i64; 2]> {
    /// The globe, in degrees: a neighbour across the date line has longitudes of the other sign.
    const ROUND: f64 = 360.0;
    let (own_place, other_place) = (own.georef_here()?, other.georef_here()?);
    let (a, b) = (own_place.transform, other_place.transform);
    let alike = [1, 2, 4, 5].iter().all(|&k| (a[k] - b[k]).abs() <= 1e-6 * (a[1].abs() + a[5].abs()));
    if own_place.crs != other_place.crs || !alike || a[2] != 0.0 || a[4] != 0.0 {
        return None;
    }
    let whole = |cells: f64, sizes: [usize; 2]| {
        let near = cells.abs() <= sizes[0].max(sizes[1]) as f64 + 0.5;
        (near && (cells - cells.round()).abs() < 1e-2).then_some(cells.round() as i64)
    };
    let row = whole((b[3] - a[3]) / a[5], [own.rows, other.rows])?;
    let east = [0.0, ROUND, -ROUND].map(|round| (b[0] - a[0] + round) / a[1]);
    let col = east.into_iter().find_map(|cells| whole(cells, [own.cols, other.cols]))?;
    Some([row, col])
}

#[cfg(test)]
mod tests;
