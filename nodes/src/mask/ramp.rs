//! A soft step up and down: how a level turns into a share.

/// Share of `x` in the band `low..=high`: 1 inside, 0 further than `soft` outside, smooth between; 0 for NaN.
#[must_use]
pub fn band(x: f64, low: f64, high: f64, soft: f64) -> f64 {
    // How far outside, as a share of the soft edge; a hard edge divides by nothing, and its share is not used.
    // Written without branches, so that loops over it run on many cells at once.
    let outside = (low - x).max(x - high);
    let edge = smooth(1.0 - outside / soft);
    let share = if outside <= 0.0 { 1.0 } else { edge };
    if x >= low - soft && x <= high + soft { share } else { 0.0 }
}

/// The cubic from 0 to 1 that is level at both ends.
#[must_use]
pub fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_one_inside_and_falls_smoothly_outside() {
        for (x, share) in
            [(0.0, 0.0), (5.0, 0.0), (7.5, 0.5), (10.0, 1.0), (20.0, 1.0), (22.5, 0.5), (25.1, 0.0)]
        {
            assert_eq!(band(x, 10.0, 20.0, 5.0), share, "at {x}");
        }
        assert_eq!([9.99, 10.0, 20.0, 20.01].map(|x| band(x, 10.0, 20.0, 0.0)), [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(band(f64::NAN, 0.0, 1.0, 1.0), 0.0);
    }
}
