//! Highest and lowest elevation angles along eight rays, a row of cells at a time.
//!
//! Of angles only the order and one comparison count, so slopes do: a + b > t for the angles of slopes p and q
//! is p + q > tan t · (1 − p q), unless q falls so steeply that no p makes up for it.

use orograph_core::prelude::*;
use pulp::{Arch, NullaryFnOnce};

use super::Form;

/// How far and how finely to look.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Cells to look at in each direction.
    pub radius: usize,
    /// Cells of those next to the middle that do not count.
    pub skip: usize,
    /// Degrees below which ground counts as level: 0 to 45.
    pub flatness: f64,
}

const DIRECTIONS: [(isize, isize); 8] =
    [(0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1)];

/// Code of each cell's form, 1 to 10; voids and infinite heights become voids.
///
/// # Errors
/// [`Error::TooLarge`] when `job` does not admit the memory, [`Error::Cancelled`].
pub fn classify(terrain: &Heightfield, search: Search, job: &Job) -> Result<Heightfield> {
    let (rows, cols) = terrain.grid().size();
    let CellSize { x, y } = terrain.grid().cell;
    let level = libm::tan(search.flatness.to_radians()) as f32;
    let arch = Arch::new();
    Heightfield::build(terrain.grid().clone(), job, |row, out| {
        let mut falling = vec![0u8; cols];
        let mut rising = vec![0u8; cols];
        let (mut highest, mut lowest) = (vec![0f32; cols], vec![0f32; cols]);
        for (down, right) in DIRECTIONS {
            job.check()?;
            highest.fill(f32::NEG_INFINITY);
            lowest.fill(f32::INFINITY);
            let (across, along) = (down as f64 * y, right as f64 * x);
            let apart = (across * across + along * along).sqrt();
            for step in search.skip + 1..=search.radius {
                let reach = step as isize;
                let Some(far) = row.checked_add_signed(down * reach).filter(|&far| far < rows) else { break };
                let shift = (right * reach).unsigned_abs();
                if shift >= cols {
                    break;
                }
                // Cells whose sample lies inside the grid, and those samples.
                let (near, samples) = if right >= 0 {
                    (0..cols - shift, (right * reach) as usize..cols)
                } else {
                    (shift..cols, 0..cols - shift)
                };
                arch.dispatch(Sample {
                    own: &terrain.row(row)[near.clone()],
                    far: &terrain.row(far)[samples],
                    per_metre: (1.0 / (step as f64 * apart)) as f32,
                    highest: &mut highest[near.clone()],
                    lowest: &mut lowest[near],
                });
            }
            arch.dispatch(Digits {
                level,
                highest: &highest,
                lowest: &lowest,
                falling: &mut falling,
                rising: &mut rising,
            });
        }
        for (((out, height), &falling), &rising) in
            out.iter_mut().zip(terrain.row(row)).zip(&falling).zip(&rising)
        {
            if height.is_finite() {
                *out = Form::of_counts(falling.into(), rising.into()).code();
            }
        }
        Ok(())
    })
}

/// One sample for each of some neighbouring cells.
struct Sample<'a> {
    own: &'a [f32],
    far: &'a [f32],
    per_metre: f32,
    highest: &'a mut [f32],
    lowest: &'a mut [f32],
}

impl NullaryFnOnce for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let ends = self.highest.iter_mut().zip(self.lowest);
        for ((&own, &far), (highest, lowest)) in self.own.iter().zip(self.far).zip(ends) {
            let slope = (far - own) * self.per_metre;
            // A void or an infinite height compares as neither.
            let slope = if slope.abs() <= f32::MAX { slope } else { f32::NAN };
            *highest = if slope > *highest { slope } else { *highest };
            *lowest = if slope < *lowest { slope } else { *lowest };
        }
    }
}

/// Whether the ground rises or falls in one direction, for a row of cells.
struct Digits<'a> {
    level: f32,
    highest: &'a [f32],
    lowest: &'a [f32],
    falling: &'a mut [u8],
    rising: &'a mut [u8],
}

impl NullaryFnOnce for Digits<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let counts = self.falling.iter_mut().zip(self.rising);
        for ((&p, &q), (falling, rising)) in self.highest.iter().zip(self.lowest).zip(counts) {
            let seen = p >= q;
            let least = self.level * (1.0 - p * q);
            // The angles' sum leaves a quarter turn only where one of them is nearly upright.
            *rising += u8::from(seen & (1.0 + self.level * q > 0.0) & (p + q > least));
            *falling += u8::from(seen & (1.0 - self.level * p > 0.0) & (-(p + q) > least));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_fields::field;

    const SEARCH: Search = Search { radius: 5, skip: 0, flatness: 1.0 };

    fn forms(terrain: &Heightfield, search: Search) -> Vec<Option<Form>> {
        let forms = classify(terrain, search, &Job::detached()).unwrap();
        forms.cells().iter().map(|&code| Form::of_code(code)).collect()
    }

    #[test]
    fn planes_are_slopes_level_ground_is_flat() {
        let tilted = field(21, 25, |row, _| row as f64 * 10.0 * libm::tan(10f64.to_radians()));
        let found = forms(&tilted, SEARCH);
        for row in 5..16 {
            assert!(found[row * 25 + 5..row * 25 + 20].iter().all(|form| *form == Some(Form::Slope)));
        }
        assert!(forms(&field(9, 9, |_, _| 4.0), SEARCH).iter().all(|form| *form == Some(Form::Flat)));
    }

    #[test]
    fn cones_have_a_peak_or_a_pit() {
        let cone = |sign: f64| {
            field(15, 15, move |row, col| sign * 5.0 * libm::hypot(row as f64 - 7.0, col as f64 - 7.0))
        };
        assert_eq!(forms(&cone(-1.0), SEARCH)[7 * 15 + 7], Some(Form::Peak));
        assert_eq!(forms(&cone(1.0), SEARCH)[7 * 15 + 7], Some(Form::Pit));
        let roof = field(15, 15, |row, _| -4.0 * (row as f64 - 7.0).abs());
        assert_eq!(forms(&roof, SEARCH)[7 * 15 + 7], Some(Form::Ridge));
    }

    /// The definition, with angles, one cell at a time.
    fn by_definition(terrain: &Heightfield, search: Search, row: usize, col: usize) -> Form {
        let (rows, cols) = terrain.grid().size();
        let (mut falling, mut rising) = (0, 0);
        for (down, right) in DIRECTIONS {
            let mut angles = Vec::new();
            for step in search.skip as isize + 1..=search.radius as isize {
                let (r, c) = (row as isize + down * step, col as isize + right * step);
                if r < 0 || c < 0 || r >= rows as isize || c >= cols as isize {
                    break;
                }
                let away = step as f64 * 10.0 * libm::sqrt((down * down + right * right) as f64);
                let rise = f64::from(terrain.at(r as usize, c as usize)) - f64::from(terrain.at(row, col));
                if !rise.is_nan() {
                    angles.push(libm::atan2(rise, away).to_degrees());
                }
            }
            let sum = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                + angles.iter().copied().fold(f64::INFINITY, f64::min);
            rising += usize::from(sum > search.flatness);
            falling += usize::from(sum < -search.flatness);
        }
        Form::of_counts(falling, rising)
    }

    #[test]
    fn forms_are_those_of_the_definition_and_turn_over_with_the_ground() {
        // Steep enough that sums of angles leave a quarter turn.
        let noise = |row: usize, col: usize| orograph_core::gaussian(8, 9, row as i64, col as i64);
        for (relief, flatness) in [(1.0, 1.0), (10.0, 3.0), (400.0, 20.0), (5000.0, 44.0)] {
            let search = Search { radius: 6, skip: 1, flatness };
            let terrain =
                field(
                    30,
                    31,
                    |row, col| {
                        if (row * 31 + col) % 37 == 5 { f64::NAN } else { relief * noise(row, col) }
                    },
                );
            let found = forms(&terrain, search);
            let over = terrain.map(&Job::detached(), |height| -height).unwrap();
            let turned = forms(&over, search);
            for (i, form) in found.iter().enumerate() {
                let (row, col) = (i / 31, i % 31);
                assert_eq!(form.is_none(), terrain.at(row, col).is_nan());
                if let (Some(form), Some(turned)) = (form, turned[i]) {
                    assert_eq!(*form, by_definition(&terrain, search, row, col), "{row}, {col} at {relief}");
                    assert_eq!(turned, by_definition(&over, search, row, col));
                }
            }
        }
    }
}
