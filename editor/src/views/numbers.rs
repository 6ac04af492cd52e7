//! Numbers as people read them: as many digits as tell something, and no more.

/// Digits that tell something, of a number that stands alone.
const DIGITS: i32 = 6;

/// A number that stands alone, with about six digits; a void when it is none.
#[must_use]
pub(super) fn readable(number: f64) -> String {
    if number.is_nan() {
        return "void".to_owned();
    }
    written(number, decimals_for(number.abs()))
}

/// A number with its unit.
#[must_use]
pub(super) fn with_unit(number: f64, unit: &str) -> String {
    match unit {
        "1" | "" => readable(number),
        _ => format!("{} {unit}", readable(number)),
    }
}

/// A number of a scale with its unit: with thousandths of what the scale spans, and no finer.
#[must_use]
pub(super) fn within(number: f64, span: f64, unit: &str) -> String {
    let decimals = usize::try_from((3 - exponent(span)).clamp(0, 8)).unwrap_or(0);
    if !(1e-4..1e9).contains(&span) || number == number.trunc() {
        return with_unit(number, unit);
    }
    match unit {
        "1" | "" => written(number, decimals),
        _ => format!("{} {unit}", written(number, decimals)),
    }
}

/// Decimals with which every number of a column is written, so that their points stand one under another.
#[must_use]
pub(super) fn decimals(numbers: &[f64]) -> usize {
    let known = || numbers.iter().copied().filter(|number| number.is_finite());
    if known().all(|number| number == number.trunc()) {
        return 0;
    }
    let largest = known().fold(0.0f64, |largest, number| largest.max(number.abs()));
    // Small numbers of a column with large ones keep two digits where that is possible.
    let smallest = known().map(f64::abs).filter(|size| *size > 0.0).fold(largest, f64::min);
    let wanted = 1 - exponent(smallest);
    decimals_for(largest).max(usize::try_from(wanted.clamp(0, DIGITS)).unwrap_or(0))
}

/// A number with so many decimals; very large and very small ones in powers of ten.
#[must_use]
pub(super) fn written(number: f64, decimals: usize) -> String {
    let size = number.abs();
    if number.is_nan() {
        "—".to_owned()
    } else if number.is_infinite() {
        if number > 0.0 { "∞" } else { "−∞" }.to_owned()
    } else if size != 0.0 && !(1e-4..1e12).contains(&size) {
        format!("{number:.3e}")
    } else {
        // Adding zero turns −0 into 0.
        format!("{:.decimals$}", number + 0.0)
    }
}

fn decimals_for(size: f64) -> usize {
    if size == size.trunc() {
        return 0;
    }
    usize::try_from((DIGITS - 1 - exponent(size)).clamp(0, 8)).unwrap_or(0)
}

/// The power of ten of the first digit.
fn exponent(size: f64) -> i32 {
    if size > 0.0 && size.is_finite() { libm::floor(libm::log10(size)) as i32 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_tell_something() {
        assert_eq!(readable(3.0), "3");
        assert_eq!(readable(-0.0), "0");
        assert_eq!(readable(1_234.567_891), "1234.57");
        assert_eq!(readable(0.012_345_678), "0.0123457");
        assert_eq!(readable(1.5e-9), "1.500e-9");
        assert_eq!(readable(f64::NAN), "void");
        assert_eq!(with_unit(2.0, "m"), "2 m");
        assert_eq!(with_unit(0.25, "1"), "0.250000");
    }

    #[test]
    fn a_number_of_a_scale_is_no_finer_than_the_scale_shows() {
        assert_eq!(within(-29.503, 929.5, "m"), "-29.5 m");
        assert_eq!(within(900.0, 929.5, "m"), "900 m");
        assert_eq!(within(1234.56, 20_000.0, "m"), "1235 m");
        assert_eq!(within(0.25, 1.0, "1"), "0.250");
        assert_eq!(within(5.123_456_7, 0.0, "m"), "5.12346 m", "level ground spans nothing");
    }

    #[test]
    fn a_column_is_written_with_one_number_of_decimals() {
        assert_eq!(decimals(&[1.0, 20.0, f64::NAN]), 0);
        assert_eq!(decimals(&[1000.5, 2.0]), 2);
        assert_eq!(decimals(&[1000.5, 0.004]), 4, "the small one is still told");
        assert_eq!(written(2.0, 2), "2.00");
        assert_eq!(written(f64::NAN, 2), "—");
    }
}
