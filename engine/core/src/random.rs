//! Counter-based random numbers: a function of seed, stream and position, never of visiting order.

/// One round of the SplitMix64 finaliser.
#[must_use]
pub const fn mix64(state: u64) -> u64 {
    let z = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The random bits at position (`a`, `b`) of `stream`, a constant of the algorithm, under `seed`.
#[must_use]
pub const fn key(seed: u64, stream: u64, a: i64, b: i64) -> u64 {
    // The low halves: positions of one raster never differ in the high ones alone.
    let position = ((a as u32 as u64) << 32) | b as u32 as u64;
    mix64(seed ^ mix64(stream ^ mix64(position)))
}

/// Uniform in `[0, 1)` from the bits of [`key`].
#[must_use]
pub const fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// Uniform in `[-1, 1)` from the bits of [`key`].
#[must_use]
pub const fn signed_unit(bits: u64) -> f64 {
    2.0 * unit(bits) - 1.0
}

/// Standard normal number at (`a`, `b`), by the Box–Muller transform of `stream` and `stream + 1`.
#[must_use]
pub fn gaussian(seed: u64, stream: u64, a: i64, b: i64) -> f64 {
    let u = 1.0 - unit(key(seed, stream, a, b)); // in (0, 1]: its logarithm is finite
    let v = unit(key(seed, stream.wrapping_add(1), a, b));
    (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mixer_is_splitmix64() {
        // First outputs of SplitMix64 seeded with 0: the published test vector.
        assert_eq!(mix64(0), 0xE220_A839_7B1D_CDAF);
        assert_eq!(mix64(0x9E37_79B9_7F4A_7C15), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let n = 40_000;
        let (mut mean, mut square) = (0.0, 0.0);
        for i in 0..n {
            let u = unit(key(1, 2, i, 3));
            assert!((0.0..1.0).contains(&u));
            mean += u / n as f64;
            let g = gaussian(1, 2, i, 3);
            square += g * g / n as f64;
        }
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!((square - 1.0).abs() < 0.03, "{square}");
    }
}
