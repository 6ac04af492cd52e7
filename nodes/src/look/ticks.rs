//! Round numbers along an axis, in steps of 1, 2 and 5 times a power of ten.

/// A number to mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where.
    pub value: f64,
    /// Its text; empty for a minor tick.
    pub label: String,
}

/// No axis has more.
const MOST: f64 = 60.0;

/// The least step of 1, 2 or 5 times a power of ten that is not less than `step`; `None` unless `step` is
/// positive and finite.
#[must_use]
pub fn round_step(step: f64) -> Option<f64> {
    if !(step.is_finite() && step > 0.0) {
        return None;
    }
    let power = libm::pow(10.0, libm::floor(libm::log10(step)));
    // The slack takes 0.2 / 0.1 and its like, which may come out a hair above 2.
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| step <= factor * power * (1.0 + 1e-9));
    Some(factor.unwrap_or(10.0) * power).filter(|rounded| rounded.is_finite() && *rounded > 0.0)
}

/// Ticks on a linear axis, about `count` of them, none outside `low..=high`.
#[must_use]
pub fn linear(low: f64, high: f64, count: f64) -> Vec<Tick> {
    let Some(step) = round_step((high - low) / count.max(1.0)) else { return Vec::new() };
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    if !(first.is_finite() && last - first <= MOST) {
        return Vec::new();
    }
    let decimals = (-libm::floor(libm::log10(step) + 1e-9)).clamp(0.0, 12.0) as usize;
    let tick = |i: i64| {
        // Adding zero turns -0 into 0.
        let value = i as f64 * step + 0.0;
        let label = if value.abs() >= 1e9 || (step < 1e-6 && value != 0.0) {
            format!("{value:e}")
        } else {
            format!("{value:.decimals$}")
        };
        Tick { value, label }
    };
    (0..=(last - first) as i64).map(|i| tick(first as i64 + i)).collect()
}

/// Ticks on a logarithmic axis: powers of ten, and 2 to 9 times those, labelled where decades are few.
#[must_use]
pub fn logarithmic(low: f64, high: f64) -> Vec<Tick> {
    if !(low > 0.0 && high.is_finite() && low <= high) {
        return Vec::new();
    }
    let (first, last) = (libm::floor(libm::log10(low)) as i32, libm::ceil(libm::log10(high)) as i32);
    let few = libm::log10(high / low) < 2.5;
    let every = (last - first) / 12 + 1;
    let mut ticks = Vec::new();
    for exponent in first..=last {
        let power = libm::pow(10.0, f64::from(exponent));
        for factor in 1..=9 {
            let value = f64::from(factor) * power;
            if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                continue;
            }
            let labelled = if few { matches!(factor, 1 | 2 | 5) } else { factor == 1 };
            let shown = labelled && (exponent - first) % every == 0;
            if shown || every == 1 {
                let label = if !shown {
                    String::new()
                } else if (-4..6).contains(&exponent) {
                    format!("{value:.*}", usize::try_from(-exponent).unwrap_or(0))
                } else {
                    format!("{factor}e{exponent}")
                };
                ticks.push(Tick { value, label });
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn steps_are_one_two_or_five() {
        assert_eq!(labels(&linear(0.0, 1.0, 5.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&linear(-130.0, 260.0, 4.0)), ["-100", "0", "100", "200"]);
        assert_eq!(labels(&linear(0.0, 0.05, 5.0)).last(), Some(&"0.05"));
        for nothing in [(0.0, 0.0), (1.0, 0.0), (0.0, f64::NAN), (f64::NEG_INFINITY, 1.0), (1e300, 1e300)] {
            assert_eq!(linear(nothing.0, nothing.1, 5.0), []);
        }
    }

    #[test]
    fn decades_are_marked() {
        let wide = logarithmic(0.05, 2000.0);
        let labelled: Vec<_> = wide.iter().filter(|tick| !tick.label.is_empty()).collect();
        let texts: Vec<_> = labelled.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(texts, ["0.1", "1", "10", "100", "1000"]);
        let few = logarithmic(3.0, 60.0);
        let texts: Vec<_> = labels(&few).into_iter().filter(|label| !label.is_empty()).collect();
        assert_eq!(texts, ["5", "10", "20", "50"]);
        assert_eq!(logarithmic(0.0, 1.0), []);
        assert!(logarithmic(f64::MIN_POSITIVE, f64::MAX).len() < 100);
    }
}
