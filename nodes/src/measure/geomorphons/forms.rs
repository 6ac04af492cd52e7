//! The ten forms, and which pattern is which.

/// A form of the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Level all around.
    Flat,
    /// Falls all around.
    Peak,
    /// Falls to both sides.
    Ridge,
    /// Level ground above a slope.
    Shoulder,
    /// A slope that bulges.
    Spur,
    /// Falls on one side, rises on the other.
    Slope,
    /// A slope that is scooped out.
    Hollow,
    /// Level ground below a slope.
    Footslope,
    /// Rises to both sides.
    Valley,
    /// Rises all around.
    Pit,
}

use Form::{Flat, Footslope, Hollow, Peak, Pit, Ridge, Shoulder, Slope, Spur, Valley};

/// Forms by how many directions fall (row) and rise (column); the paper's table.
const TABLE: [&[Form]; 9] = [
    &[Flat, Flat, Flat, Footslope, Footslope, Valley, Valley, Valley, Pit],
    &[Flat, Flat, Footslope, Footslope, Footslope, Valley, Valley, Valley],
    &[Flat, Shoulder, Slope, Slope, Hollow, Hollow, Valley],
    &[Shoulder, Shoulder, Slope, Slope, Slope, Hollow],
    &[Shoulder, Shoulder, Spur, Slope, Slope],
    &[Ridge, Ridge, Spur, Spur],
    &[Ridge, Ridge, Ridge],
    &[Ridge, Ridge],
    &[Peak],
];

impl Form {
    /// All forms in the order of their codes.
    pub const ALL: [Self; 10] = [Flat, Peak, Ridge, Shoulder, Spur, Slope, Hollow, Footslope, Valley, Pit];

    /// The form where `falling` of the eight directions fall and `rising` rise.
    #[must_use]
    pub fn of_counts(falling: usize, rising: usize) -> Self {
        TABLE.get(falling).and_then(|row| row.get(rising)).copied().unwrap_or(Flat)
    }

    /// The form's code in rasters, 1 to 10.
    #[must_use]
    pub fn code(self) -> f32 {
        f32::from(self as u8 + 1)
    }

    /// The form of a code; `None` for anything else.
    #[must_use]
    pub fn of_code(code: f32) -> Option<Self> {
        let place = (code - 1.0) as usize;
        Self::ALL.get(place).copied().filter(|form| form.code() == code)
    }

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["flat", "peak", "ridge", "shoulder", "spur", "slope", "hollow", "footslope", "valley", "pit"]
            [self as usize]
    }

    /// Its short name on maps.
    #[must_use]
    pub fn short_name(self) -> &'static str {
        ["FL", "PK", "RI", "SH", "SP", "SL", "HL", "FS", "VL", "PT"][self as usize]
    }

    /// Its usual colour on maps.
    #[must_use]
    pub fn colour(self) -> [u8; 4] {
        [
            [220, 220, 220, 255],
            [56, 0, 0, 255],
            [200, 0, 0, 255],
            [255, 80, 20, 255],
            [250, 210, 60, 255],
            [255, 255, 60, 255],
            [180, 230, 20, 255],
            [60, 250, 150, 255],
            [0, 0, 255, 255],
            [0, 0, 56, 255],
        ][self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upside_down(form: Form) -> Form {
        let pairs = [(Peak, Pit), (Ridge, Valley), (Shoulder, Footslope), (Spur, Hollow)];
        let other = |(a, b)| {
            if form == a {
                Some(b)
            } else if form == b {
                Some(a)
            } else {
                None
            }
        };
        pairs.into_iter().find_map(other).unwrap_or(form)
    }

    #[test]
    fn the_table_turns_over_with_the_ground() {
        for falling in 0..=8 {
            for rising in 0..=8 - falling {
                let form = Form::of_counts(falling, rising);
                assert_eq!(Form::of_counts(rising, falling), upside_down(form), "{falling} {rising}");
            }
        }
    }

    #[test]
    fn codes_name_their_forms() {
        for form in Form::ALL {
            assert_eq!(Form::of_code(form.code()), Some(form));
        }
        for code in [0.0, 0.5, 1.5, 11.0, -3.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Form::of_code(code), None, "{code}");
        }
    }
}
