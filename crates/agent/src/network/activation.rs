//! Activations of hidden layers.

use serde::{Deserialize, Serialize};

/// The activation of hidden layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// Hyperbolic tangent: see [`tanh`].
    #[default]
    Tanh,
    /// max(0, x).
    Relu,
}

impl Activation {
    /// Applies the activation in place.
    pub fn apply(self, values: &mut [f32]) {
        match self {
            Self::Tanh => values.iter_mut().for_each(|value| *value = tanh(*value)),
            Self::Relu => values.iter_mut().for_each(|value| *value = value.max(0.0)),
        }
    }

    /// Multiplies gradients of the outputs by the derivative of the activation, in place, to get gradients of the
    /// inputs.
    pub fn backward(self, outputs: &[f32], gradients: &mut [f32]) {
        match self {
            Self::Tanh => gradients.iter_mut().zip(outputs).for_each(|(g, y)| *g *= 1.0 - y * y),
            Self::Relu => {
                gradients.iter_mut().zip(outputs).for_each(|(g, y)| *g *= f32::from(u8::from(*y > 0.0)))
            }
        }
    }
}

/// Coefficients of the numerator, x to x¹³, and of the denominator, 1 to x⁶.
const NUMERATOR: [f32; 7] = [
    4.893_524_6e-3,
    6.372_619_3e-4,
    1.485_722_4e-5,
    5.122_297e-8,
    -8.604_672e-11,
    2.000_188e-13,
    -2.760_768_5e-16,
];
const DENOMINATOR: [f32; 4] = [4.893_525e-3, 2.268_434_6e-3, 1.185_347_1e-4, 1.198_258_4e-6];
/// Input from which the approximation is constant.
const SATURATED: f32 = 7.905_311;

/// Returns the hyperbolic tangent, within 5e-7, by Eigen's rational approximation. It makes no calls, so that loops are
/// vectorized, and gives the same bits on every machine.
pub fn tanh(x: f32) -> f32 {
    let x = x.clamp(-SATURATED, SATURATED);
    let square = x * x;
    let polynomial =
        |coefficients: &[f32]| coefficients.iter().rev().fold(0.0, |sum, each| sum * square + each);
    x * polynomial(&NUMERATOR) / polynomial(&DENOMINATOR)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tanh_agrees_with_the_standard_library() {
        for step in -20_000..=20_000 {
            let x = step as f32 * 1e-3;
            let error = (tanh(x) - x.tanh()).abs();
            assert!(error < 5e-7, "tanh({x}): off by {error}");
        }
        assert_eq!([tanh(0.0), tanh(-0.5)], [0.0, -tanh(0.5)]);
        assert!(tanh(f32::NAN).is_nan());
    }
}
