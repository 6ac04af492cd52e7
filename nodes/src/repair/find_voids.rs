//! Find voids: how many there are, how large, and where.

use orograph_core::{Cells, Column, Unit, prelude::*};

use super::voids;

/// Lists the voids of a terrain with their boxes, and masks those of the sizes asked for.
///
/// Cells that touch along a side hang together.
#[derive(Params, Clone, Debug)]
pub struct FindVoids {
    /// Fewest cells of the voids that are listed and masked.
    #[param(default = 1u32, range = 1..=4_294_967_295u32, slider = 1..=1000, unit = "cells")]
    pub smallest: u32,
    /// Most cells of the voids that are listed and masked.
    #[param(default = 4_294_967_295u32, range = 1..=4_294_967_295u32, slider = 1..=100_000, unit = "cells")]
    pub largest: u32,
}

/// Inputs of [`FindVoids`].
#[derive(Inputs)]
pub struct FindVoidsIn<'a> {
    /// Terrain with voids.
    pub terrain: &'a Heightfield,
}

/// Outputs of [`FindVoids`].
#[derive(Outputs)]
pub struct FindVoidsOut {
    /// 1 in the voids listed, 0 elsewhere.
    pub mask: Mask,
    /// One row for each void: its cells, the first row and column of its box, its rows and columns, and whether it touches
    /// the border.
    pub voids: Table,
    /// Number of voids listed, their cells, the share of all cells, and the cells of the largest.
    pub report: Table,
}

impl Node for FindVoids {
    const ID: &'static str = "repair.find_voids";
    const VERSION: u32 = 1;
    const EXTENT: Extent = Extent::Global;
    type Inputs<'a> = FindVoidsIn<'a>;
    type Outputs = FindVoidsOut;

    fn check(&self) -> Result<()> {
        if self.smallest <= self.largest {
            return Ok(());
        }
        Err(Error::invalid(
            format!("`smallest` ({}) lies above `largest` ({})", self.smallest, self.largest),
            "swap them",
        ))
    }

    fn run(&self, inputs: FindVoidsIn<'_>, job: &Job) -> Result<FindVoidsOut> {
        let terrain = inputs.terrain;
        let (rows, cols) = terrain.grid().size();
        let mut found = voids::find((rows, cols), 0, |i| terrain.cells()[i].is_nan(), job)?;
        let wanted = self.smallest as usize..=self.largest as usize;
        found.retain(|void| wanted.contains(&void.cells.len()));
        let mut mask: Mask = terrain.map(job, |_| 0.0)?;
        found.iter().flat_map(|void| &void.cells).for_each(|&cell| mask.cells_mut()[cell] = 1.0);
        let column = |name: &str, unit, of: &dyn Fn(&voids::Void) -> usize| Column {
            name: name.into(),
            unit,
            cells: Cells::Numbers(found.iter().map(|void| of(void) as f64).collect()),
        };
        let voids = Table::new(vec![
            column("cells", Unit::Cell, &|void| void.cells.len()),
            column("row", Unit::Cell, &|void| void.first[0]),
            column("col", Unit::Cell, &|void| void.first[1]),
            column("rows", Unit::Cell, &|void| void.size()[0]),
            column("cols", Unit::Cell, &|void| void.size()[1]),
            column("at_border", Unit::One, &|void| {
                let inside = void.first[0] > 0
                    && void.first[1] > 0
                    && void.last[0] + 1 < rows
                    && void.last[1] + 1 < cols;
                usize::from(!inside)
            }),
        ])?;
        let cells: usize = found.iter().map(|void| void.cells.len()).sum();
        let largest = found.iter().map(|void| void.cells.len()).max().unwrap_or(0);
        let report = Table::metrics([
            ("voids", Unit::One, found.len() as f64),
            ("cells", Unit::Cell, cells as f64),
            ("share", Unit::Percent, 100.0 * cells as f64 / (rows * cols) as f64),
            ("largest", Unit::Cell, largest as f64),
        ])?;
        Ok(FindVoidsOut { mask, voids, report })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    #[test]
    fn voids_are_counted_boxed_and_masked_by_size() {
        let hole =
            |row: usize, col: usize| (2..4).contains(&row) && (1..6).contains(&col) || row == 5 && col > 7;
        let terrain = field(6, 9, |row, col| if hole(row, col) { f64::NAN } else { 1.0 });
        let run = |smallest| {
            let node = FindVoids { smallest, ..FindVoids::default() };
            node.run(FindVoidsIn { terrain: &terrain }, &Job::detached()).unwrap()
        };
        let out = run(1);
        let numbers = |table: &Table, name: &str| match &table.column(name).unwrap().cells {
            Cells::Numbers(numbers) => numbers.clone(),
            Cells::Texts(_) => panic!("numbers expected"),
        };
        assert_eq!(numbers(&out.voids, "cells"), [10.0, 1.0]);
        assert_eq!(numbers(&out.voids, "row"), [2.0, 5.0]);
        assert_eq!(numbers(&out.voids, "cols"), [5.0, 1.0]);
        assert_eq!(numbers(&out.voids, "at_border"), [0.0, 1.0]);
        assert_eq!(numbers(&out.report, "largest"), [10.0]);
        let out = run(2);
        assert_eq!(out.mask.cells().iter().sum::<f32>(), 10.0);
        assert_eq!(numbers(&out.report, "voids"), [1.0]);
        assert!(FindVoids { smallest: 5, largest: 4 }.check().is_err());
    }
}
