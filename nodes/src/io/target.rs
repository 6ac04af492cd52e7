//! Game engines' landscapes: which sizes they take, and what their import dialogues must be told.
//!
//! Unreal: *Landscape Technical Guide* of its documentation. A level l of 16 bits lies (l − 32768) / 128 m above the
//! landscape at its default scale of 100; sides and heights are in cm. Unity: *Terrain* in its manual.

use orograph_core::prelude::*;

/// The program that a file is for.
#[derive(Choice, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Any: no size is refused.
    Any,
    /// Unreal landscapes: the size is checked and the scale told.
    Unreal,
    /// Unity terrains: the size is checked and the scale told.
    Unity,
}

impl Target {
    /// Refuses a size that the program does not take, naming the nearest that it does.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub(crate) fn check_size(self, grid: &Grid) -> Result<()> {
        let (rows, cols) = grid.size();
        let (fits, side, whose, common): (_, fn(usize) -> bool, _, _) = match self {
            Self::Any => return Ok(()),
            Self::Unreal => (
                is_unreal_size(rows, cols),
                is_unreal_side,
                "an Unreal landscape",
                "505, 1009, 2017, 4033 and 8129 are usual",
            ),
            Self::Unity => (
                rows == cols && is_unity_side(rows),
                is_unity_side,
                "a Unity terrain",
                "513, 1025, 2049 and 4097 are usual",
            ),
        };
        if fits {
            return Ok(());
        }
        let nearest: Vec<String> = nearest(rows.max(cols), side).iter().map(ToString::to_string).collect();
        let nearest = nearest.join(" or ");
        Err(Error::invalid(
            format!("{rows} × {cols} is no size of {whose}"),
            format!("resize the terrain to {nearest} cells in both directions; {common}"),
        ))
    }

    /// Tells what the program's import dialogue asks for; the heights are those of the lowest and highest 16-bit level.
    pub(crate) fn tell_scale(self, grid: &Grid, (lowest, highest): (f64, f64), job: &Job) {
        let range = highest - lowest;
        match self {
            Self::Any => {}
            Self::Unreal => {
                let [x, y, z] = unreal_scale(grid.cell, range).map(short);
                // Level 32768 lies where the landscape does.
                let middle = short((lowest + range * 32768.0 / 65535.0) * 100.0);
                job.warn(format!(
                    "Unreal: set the landscape's scale to {x}, {y}, {z} and the z of its location to {middle}"
                ));
            }
            Self::Unity => {
                let (rows, cols) = (grid.rows as f64 - 1.0, grid.cols as f64 - 1.0);
                let [x, y, height, lowest] =
                    [grid.cell.x * cols, grid.cell.y * rows, range, lowest].map(short);
                job.warn(format!(
                    "Unity: resolution {}, width {x}, length {y}, height {height}; the terrain's y is {lowest}",
                    grid.cols
                ));
            }
        }
    }
}

/// Unreal's scale along x, y and z for cells of a size and a range of heights between the outermost levels, in m.
fn unreal_scale(cell: CellSize, range: f64) -> [f64; 3] {
    // At a scale of 1 a cell has 1 cm, and 65535 levels 65535 / 128 cm.
    [cell.x * 100.0, cell.y * 100.0, range * 100.0 * 128.0 / 65535.0]
}

/// A number without the digits that no dialogue takes.
fn short(number: f64) -> f64 {
    libm::round(number * 1e6) / 1e6
}

/// Quads along a component of an Unreal landscape: one or two sections of 7, 15, 31, 63, 127 or 255.
const COMPONENTS: [usize; 12] = [7, 15, 31, 63, 127, 255, 14, 30, 62, 126, 254, 510];

/// Whether Unreal can make a landscape of so many vertices: 1 to 32 components in either direction, all alike, and one
/// vertex more.
#[must_use]
pub fn is_unreal_size(rows: usize, cols: usize) -> bool {
    let fits = |side: usize, component: usize| {
        let quads = side.saturating_sub(1);
        quads > 0 && quads.is_multiple_of(component) && quads / component <= 32
    };
    COMPONENTS.iter().any(|&component| fits(rows, component) && fits(cols, component))
}

fn is_unreal_side(side: usize) -> bool {
    is_unreal_size(side, side)
}

/// Whether Unity can make a terrain of that many samples a side: one more than a power of two, 33 to 4097.
#[must_use]
pub fn is_unity_side(side: usize) -> bool {
    (33..=4097).contains(&side) && (side - 1).is_power_of_two()
}

/// The nearest sides that fit, below and above.
fn nearest(side: usize, fits: impl Fn(usize) -> bool) -> Vec<usize> {
    /// Unreal's largest: 32 components of 510 quads.
    const MOST: usize = 16321;
    let below = (1..side.min(MOST + 1)).rev().find(|&side| fits(side));
    let above = (side.max(1)..=MOST).find(|&side| fits(side));
    let mut found: Vec<usize> = below.into_iter().chain(above).collect();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_engines_own_sizes_are_known() {
        // Epic's list of recommended sizes, and Unity's manual.
        for side in [8129, 4033, 2017, 1009, 505, 253, 127] {
            assert!(is_unreal_side(side), "{side}");
        }
        for side in [33, 65, 129, 257, 513, 1025, 2049, 4097] {
            assert!(is_unity_side(side), "{side}");
        }
        for side in [0, 1, 2, 4096, 1000, 8193] {
            assert!(!is_unity_side(side) && !is_unreal_side(side), "{side}");
        }
        assert!(is_unreal_size(127, 253) && is_unreal_size(1009, 2017));
        // One side of 7 quads and one of 15 have no component in common.
        assert!(is_unreal_side(8) && is_unreal_side(16) && !is_unreal_size(8, 16));
    }

    #[test]
    fn a_wrong_size_names_the_nearest_right_ones() {
        for (side, target, words) in [
            (1000, Target::Unreal, "to 993 or 1009 cells"),
            (1024, Target::Unity, "to 513 or 1025 cells"),
            (2, Target::Unity, "to 33 cells"),
            (5000, Target::Unity, "to 4097 cells"),
            (100_000, Target::Unreal, "to 16321 cells"),
        ] {
            let grid = Grid::new(side, side, CellSize::square(1.0)).unwrap();
            let error = target.check_size(&grid).unwrap_err();
            assert!(error.hint().unwrap().contains(words), "{:?}", error.hint());
        }
        let oblong = Grid::new(513, 1025, CellSize::square(1.0)).unwrap();
        assert!(Target::Unity.check_size(&oblong).unwrap_err().hint().unwrap().contains("to 513 or 1025"));
    }

    #[test]
    fn unreal_s_default_scale_spans_its_stated_range() {
        // The guide: at 100 heights run from −256 to 255.992 m.
        let [_, _, z] = unreal_scale(CellSize::square(1.0), 255.9921875 + 256.0);
        assert!((z - 100.0).abs() < 1e-9, "{z}");
    }
}
