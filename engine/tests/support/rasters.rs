//! Nodes that make, turn and write rasters row by row, and one that needs the whole.

use std::io::Write as _;

use orograph_core::{BandSink, BandSource, OutputStream, Wire, prelude::*};

use super::{FieldOut, RaiseIn};

/// Ground of which no two cells are alike.
#[derive(Params, Clone)]
pub struct Hills {
    /// Rows.
    #[param(default = 100, range = 1..=4096, unit = "cells")]
    pub rows: u32,
    /// Columns.
    #[param(default = 7, range = 1..=4096, unit = "cells")]
    pub cols: u32,
    /// How many rows come together.
    #[param(default = 1, range = 1..=4096, unit = "cells")]
    pub step: u32,
    /// The row that it fails at.
    #[param(default = 100_000, range = 0..=100_000, unit = "cells")]
    pub fails: u32,
}

impl Hills {
    fn grid(&self) -> Result<Grid> {
        Grid::new(self.rows as usize, self.cols as usize, CellSize::square(2.0))
    }

    fn on(&self, grid: Grid, job: &Job) -> Result<Heightfield> {
        let (place, seed) = (grid.clone(), job.seed());
        Heightfield::build(grid, job, |row, out| {
            for (col, height) in out.iter_mut().enumerate() {
                let (row, col) = place.base(row, col);
                if row >= i64::from(self.fails) {
                    return Err(Error::NonFinite {
                        what: "hills".into(),
                        row: row as usize,
                        col: col as usize,
                    });
                }
                *height = orograph_core::unit(orograph_core::key(seed, 0, row, col)) as f32;
            }
            Ok(())
        })
    }
}

struct HillsOn(Hills, Grid);

impl BandSource for HillsOn {
    fn grid(&self) -> &Grid {
        &self.1
    }
    fn step(&self) -> usize {
        self.0.step as usize
    }
    fn band(&self, first: usize, rows: usize, job: &Job) -> Result<Value> {
        Ok(self.0.on(self.1.crop(first, 0, rows, self.1.cols)?, job)?.into_value())
    }
}

impl Node for Hills {
    const ID: &'static str = "test.hills";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const READS: &'static [ContextItem] = &[ContextItem::Seed];
    type Inputs<'a> = ();
    type Outputs = FieldOut;
    fn source(&self, _: &Job) -> Result<Option<Box<dyn BandSource>>> {
        Ok(Some(Box::new(HillsOn(self.clone(), self.grid()?))))
    }
    fn run(&self, (): (), job: &Job) -> Result<FieldOut> {
        Ok(FieldOut { terrain: self.on(self.grid()?, job)? })
    }
}

/// Each cell becomes the sum of a column of cells around it, in an order that matters.
#[derive(Params)]
pub struct Spread {
    /// Cells above and below.
    #[param(default = 1, range = 0..=64, unit = "cells")]
    pub reach: u32,
    /// Says something of each row whose first cell is this high.
    #[param(default = 1e9, range = -1e9..=1e9, unit = "m")]
    pub remarkable: f64,
}

impl Node for Spread {
    const ID: &'static str = "test.spread";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = RaiseIn<'a>;
    type Outputs = FieldOut;
    fn halo(&self, _: CellSize) -> usize {
        self.reach as usize
    }
    fn run(&self, inputs: RaiseIn<'_>, job: &Job) -> Result<FieldOut> {
        let (terrain, reach) = (inputs.terrain, self.reach as usize);
        if terrain.cells().iter().any(|&height| f64::from(height) > self.remarkable) {
            job.warn("it is high");
        }
        let terrain = Heightfield::build(terrain.grid().clone(), job, |row, out| {
            let rows = row.saturating_sub(reach)..(row + reach + 1).min(terrain.rows());
            for (col, sum) in out.iter_mut().enumerate() {
                *sum = rows.clone().fold(0.0, |sum, row| sum * 0.7 + terrain.at(row, col));
            }
            Ok(())
        })?;
        Ok(FieldOut { terrain })
    }
}

/// Fields to join.
#[derive(Inputs)]
pub struct JoinIn<'a> {
    /// The fields.
    pub terrains: Vec<&'a Heightfield>,
    /// Added to each cell.
    pub more: Option<&'a f64>,
}

/// Two fields.
#[derive(Outputs)]
pub struct JoinOut {
    /// The sum of the fields.
    pub terrain: Heightfield,
    /// The last of them.
    pub last: Heightfield,
}

/// Adds fields.
#[derive(Params)]
pub struct Join {}

impl Node for Join {
    const ID: &'static str = "test.join";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Local;
    type Inputs<'a> = JoinIn<'a>;
    type Outputs = JoinOut;
    fn run(&self, inputs: JoinIn<'_>, job: &Job) -> Result<JoinOut> {
        let more = inputs.more.map_or(0.0, |more| *more as f32);
        let Some(&first) = inputs.terrains.first() else {
            return Err(Error::EmptyInput { what: "it".into() });
        };
        for other in &inputs.terrains {
            first.grid().match_size("the first", other.grid(), "another")?;
        }
        let terrain = Heightfield::build(first.grid().clone(), job, |row, out| {
            for (col, sum) in out.iter_mut().enumerate() {
                *sum = inputs.terrains.iter().fold(more, |sum, terrain| sum * 0.9 + terrain.at(row, col));
            }
            Ok(())
        })?;
        let last = inputs.terrains.last().copied().unwrap_or(first).clone();
        Ok(JoinOut { terrain, last })
    }
}

/// Heights above the lowest one.
#[derive(Params)]
pub struct Top {}

impl Node for Top {
    const ID: &'static str = "test.top";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = RaiseIn<'a>;
    type Outputs = FieldOut;
    fn run(&self, inputs: RaiseIn<'_>, job: &Job) -> Result<FieldOut> {
        let (low, _) = inputs.terrain.known_range("terrain")?;
        Ok(FieldOut { terrain: inputs.terrain.map(job, |height| height - low)? })
    }
}

/// Writes a field's cells, row by row.
#[derive(Params)]
pub struct WriteRows {
    /// The file.
    #[param(default = "rows.bin")]
    pub file: OutputPath,
}

struct Rows(Box<dyn OutputStream>, OutputPath);

impl BandSink for Rows {
    fn take(&mut self, band: &Value, _: &Job) -> Result<()> {
        let band = Heightfield::borrow(band).ok_or_else(|| Error::EmptyInput { what: "it".into() })?;
        for height in band.cells() {
            self.0.write_all(&height.to_le_bytes()).map_err(|error| Error::writing(&self.1.0, error))?;
        }
        Ok(())
    }
    fn finish(self: Box<Self>, _: &Job) -> Result<()> {
        self.0.finish()
    }
}

impl Node for WriteRows {
    const ID: &'static str = "test.write_rows";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    const WRITES: bool = true;
    type Inputs<'a> = RaiseIn<'a>;
    type Outputs = ();
    fn takes_bands(&self) -> bool {
        true
    }
    fn sink(&self, _: &Grid, job: &Job) -> Result<Box<dyn BandSink>> {
        Ok(Box::new(Rows(job.create(&self.file)?, self.file.clone())))
    }
    fn run(&self, inputs: RaiseIn<'_>, job: &Job) -> Result<()> {
        let mut rows = Box::new(Rows(job.create(&self.file)?, self.file.clone()));
        rows.take(&inputs.terrain.clone().into_value(), job)?;
        rows.finish(job)
    }
}
