//! The exponential function.

/// Limits of inputs, within which results are normal numbers.
const LOWEST: f32 = -87.0;
const HIGHEST: f32 = 88.0;
/// 1.5 × 2²³: adding a number to it rounds the number to an integer in the low bits.
const ROUNDING: f32 = 12_582_912.0;
/// ln 2 in two parts, the first of which has few bits.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
/// Coefficients of (eˣ - 1 - x) / x² (Cephes, `expf`), highest power first.
const COEFFICIENTS: [f32; 6] =
    [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 0.166_666_66, 0.5];

/// Returns the exponential, within a relative error of 2e-7, by a polynomial. It makes no calls, so that loops are
/// vectorized, and gives the same bits on every machine. Inputs are clamped to -87 and 88.
pub fn exp(x: f32) -> f32 {
    let x = x.clamp(LOWEST, HIGHEST);
    let shifted = x * std::f32::consts::LOG2_E + ROUNDING;
    let whole = shifted - ROUNDING;
    let rest = x - whole * LN_2[0] - whole * LN_2[1];
    let polynomial = COEFFICIENTS.iter().fold(0.0, |sum, each| sum * rest + each);
    let power = f32::from_bits((shifted.to_bits() << 23).wrapping_add(0x3f80_0000));
    (polynomial * rest * rest + rest + 1.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_the_standard_library() {
        for step in -86_900..=87_900 {
            let x = step as f32 * 1e-3;
            let error = (f64::from(exp(x)) / f64::from(x).exp() - 1.0).abs();
            assert!(error < 2e-7, "exp({x}): off by {error}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert!(exp(-1e9) < 1e-37 && exp(f32::NAN).is_nan());
    }
}
