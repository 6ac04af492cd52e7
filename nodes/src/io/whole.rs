//! Heights as whole numbers, for the formats that hold no others.

/// The whole number nearest to a height, halves away from zero, and whether it lies from `low` to `high`; of what does
/// not, the number means nothing. Without a branch, and without a cast that looks at its range, many are taken at once.
#[inline]
pub(super) fn nearest(height: f32, low: i32, high: i32) -> (i32, bool) {
    // f64 holds the sum exactly, so halves are told from what lies just below them.
    let sum = f64::from(height) + 0.5_f64.copysign(f64::from(height));
    // Beside this number there is room for whole ones alone, whose low bits are those of an `i32`.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let near = sum + WHOLE - WHOLE;
    let beyond = if near.abs() > sum.abs() { 1.0 } else { 0.0 };
    let towards_zero = near - f64::copysign(beyond, sum);
    let fits = (sum > f64::from(low) - 1.0) & (sum < f64::from(high) + 1.0);
    ((towards_zero + WHOLE).to_bits() as i32, fits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_away_from_zero_and_limits_are_kept() {
        let short = |height| nearest(height, -32768, 32767);
        for (height, whole) in
            [(0.5, 1), (-0.5, -1), (0.499_999_97, 0), (1.5, 2), (-2.5, -3), (32767.498, 32767)]
        {
            assert_eq!(short(height), (whole, true), "{height}");
        }
        assert_eq!(short(-32768.498), (-32768, true));
        for height in [32767.5, -32768.5, 1e9, -1e9, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert!(!short(height).1, "{height}");
        }
        assert_eq!(nearest(-2_147_483_648.0, i32::MIN, i32::MAX), (i32::MIN, true));
        assert!(!nearest(2_147_483_648.0, i32::MIN, i32::MAX).1);
        // Beyond 2^23 every height is whole, and stays what it is.
        assert_eq!(nearest(8_388_609.0, i32::MIN, i32::MAX), (8_388_609, true));
    }
}
