//! Recurrent networks: an encoder, a gated recurrent unit (Cho et al. 2014) and a head.
//!
//! The state is h. The encoder's output is x, which has the inputs of the two gates and of the candidate:
//!
//! ```text
//! u = R h + b                              for the update gate, the reset gate and the candidate
//! z = σ(x_z + u_z)                         update gate
//! r = σ(x_r + u_r)                         reset gate
//! n = tanh(x_n + r ⊙ u_n)                  candidate
//! h ← (1 - z) ⊙ n + z ⊙ h
//! ```
//!
//! These are the equations of PyTorch's `GRUCell`, and of ONNX's `GRU` with `linear_before_reset` = 1. The gates are in
//! ONNX's order.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{Layer, Mlp, Tensor, tanh};

/// Number of gates, including the candidate. Each is as wide as the state.
pub const GATES: usize = 3;

/// The shape of a recurrent network.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recurrent {
    /// From the observation to the inputs of the gates: three times the width of the state.
    pub encoder: Mlp,
    /// From the state to the outputs.
    pub head: Mlp,
}

/// The positions of a recurrent network's parts among its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecurrentPlaces {
    /// Range of the encoder's parameters.
    pub encoder: Range<usize>,
    /// The recurrent layer, from the state to the inputs of the gates.
    pub cell: Layer,
    /// Range of the head's parameters.
    pub head: Range<usize>,
}

/// The state of a recurrent network and the buffers of a step.
#[derive(Clone, Debug)]
pub(super) struct RecurrentScratch {
    pub(super) state: Vec<f32>,
    places: RecurrentPlaces,
    layers: Vec<f32>,
    /// Inputs of the gates from the encoder, and from the state.
    gates: [Vec<f32>; 2],
}

impl Recurrent {
    /// Returns the width of the state.
    pub fn state(&self) -> usize {
        self.head.widths.first().copied().unwrap_or(0)
    }

    /// Returns the positions of the network's parts among its parameters.
    pub fn places(&self) -> RecurrentPlaces {
        let (encoder, state) = (self.encoder.parameters(), self.state());
        let weights = encoder..encoder + state * GATES * state;
        let biases = weights.end..weights.end + GATES * state;
        let head = biases.end..biases.end + self.head.parameters();
        let cell = Layer { inputs: state, outputs: GATES * state, weights, biases };
        RecurrentPlaces { encoder: 0..encoder, cell, head }
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.places().head.end
    }

    /// Returns the tensors.
    pub(super) fn tensors(&self) -> Vec<Tensor> {
        let RecurrentPlaces { cell, head, .. } = self.places();
        let encoder = self.encoder.tensors("encoder.");
        let of_head = self.head.tensors("head.").into_iter().map(|tensor| {
            let place = tensor.place.start + head.start..tensor.place.end + head.start;
            Tensor { place, ..tensor }
        });
        encoder.into_iter().chain(cell.tensors("cell")).chain(of_head).collect()
    }

    /// Returns the buffers of a step, with a state of zeros.
    pub(super) fn scratch(&self) -> RecurrentScratch {
        let (state, longest) = (self.state(), self.encoder.scratch().len().max(self.head.scratch().len()));
        RecurrentScratch {
            state: vec![0.0; state],
            places: self.places(),
            layers: vec![0.0; longest],
            gates: [vec![0.0; GATES * state], vec![0.0; GATES * state]],
        }
    }

    /// Writes the outputs for the next input and updates the state. Allocates nothing, and gives the same bits on every
    /// machine.
    pub(super) fn forward(
        &self,
        parameters: &[f32],
        input: &[f32],
        scratch: &mut RecurrentScratch,
        output: &mut [f32],
    ) {
        let RecurrentScratch { state, places, layers, gates: [of_input, of_state] } = scratch;
        self.encoder.forward(&parameters[places.encoder.clone()], input, layers, of_input);
        places.cell.forward(parameters, state, of_state);
        step(of_input, of_state, state);
        self.head.forward(&parameters[places.head.clone()], state, layers, output);
    }
}

/// Replaces a state by the next one, given the inputs of the gates from the encoder and from the state. Overwrites
/// `of_input` with the values of the update gate, the reset gate and the candidate.
pub fn step(of_input: &mut [f32], of_state: &[f32], state: &mut [f32]) {
    let width = state.len();
    let (gates, candidate) = of_input.split_at_mut(2 * width);
    let (from_gates, from_candidate) = of_state.split_at(2 * width);
    gates.iter_mut().zip(from_gates).for_each(|(gate, other)| *gate = sigmoid(*gate + other));
    let (update, reset) = gates.split_at(width);
    for ((candidate, other), reset) in candidate.iter_mut().zip(from_candidate).zip(reset) {
        *candidate = tanh(*candidate + reset * other);
    }
    for ((state, candidate), update) in state.iter_mut().zip(&*candidate).zip(update) {
        *state = (1.0 - update) * candidate + update * *state;
    }
}

/// Returns the logistic function of a number, with the same bits on every machine.
fn sigmoid(x: f32) -> f32 {
    0.5 * tanh(0.5 * x) + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Activation;

    #[test]
    fn a_step_follows_the_equations_of_the_reference() {
        // The equations of PyTorch's `GRUCell(1, 1)` in double precision, from the state 0.5 with the input 2.
        let shape = Recurrent {
            encoder: Mlp::new(1, &[], 3, Activation::Tanh),
            head: Mlp::new(1, &[], 1, Activation::Tanh),
        };
        let (encoder, cell) = ([0.3, -0.2, 0.5, 0.1, 0.2, -0.1], [0.7, 0.4, -0.6, 0.05, -0.3, 0.25]);
        let parameters: Vec<f32> = encoder.into_iter().chain(cell).chain([2.0, 1.0]).collect();
        assert_eq!(shape.parameters(), parameters.len());
        let mut scratch = shape.scratch();
        scratch.state[0] = 0.5;
        let mut output = [0.0];
        shape.forward(&parameters, &[2.0], &mut scratch, &mut output);
        let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
        let z = logistic(0.3 * 2.0 + 0.1 + 0.7 * 0.5 + 0.05);
        let r = logistic(-0.2 * 2.0 + 0.2 + 0.4 * 0.5 - 0.3);
        let n = (0.5 * 2.0 - 0.1 + r * (-0.6 * 0.5 + 0.25)).tanh();
        let expected = (1.0 - z) * n + z * 0.5;
        assert!((f64::from(scratch.state[0]) - expected).abs() < 1e-6, "{} {expected}", scratch.state[0]);
        assert!((f64::from(output[0]) - (2.0 * expected + 1.0)).abs() < 2e-6);
    }

    #[test]
    fn tensors_fill_the_parameters_without_gaps() {
        let shape = Recurrent {
            encoder: Mlp::new(4, &[5], 9, Activation::Relu),
            head: Mlp::new(3, &[6], 2, Activation::Relu),
        };
        let mut at = 0;
        for tensor in shape.tensors() {
            assert_eq!((tensor.place.start, tensor.place.len()), (at, tensor.sizes.iter().product()));
            at = tensor.place.end;
        }
        assert_eq!(at, shape.parameters());
    }
}
