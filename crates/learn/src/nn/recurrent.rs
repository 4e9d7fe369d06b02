//! Passes of sequences through recurrent networks.

use b2b_agent::network::Mlp;
use b2b_agent::network::recurrent::{Recurrent, RecurrentPlaces};

use super::cell::{self, CellPass, Sequences};
use super::orthogonal::{InitialGains, orthogonal};
use super::pass::Pass;
use crate::random::RandomStream;

/// Buffers of passes through a recurrent network. They grow to the largest batch and are reused: see [`Pass`].
///
/// The encoder and the head process the steps of all sequences together, the cell one step of all sequences at a time.
#[derive(Clone, Debug)]
pub struct RecurrentPass {
    places: RecurrentPlaces,
    encoder: Pass,
    cell: CellPass,
    head: Pass,
}

impl RecurrentPass {
    /// Returns the buffers of a shape.
    pub fn new(network: &Recurrent) -> Self {
        Self {
            places: network.places(),
            encoder: Pass::new(&network.encoder),
            cell: CellPass::default(),
            head: Pass::new(&network.head),
        }
    }

    /// Returns the outputs of the last forward pass: rows × outputs.
    pub fn outputs(&self) -> &[f32] {
        self.head.outputs()
    }

    /// Returns the state after a row of the last forward pass.
    pub fn state(&self, row: usize) -> &[f32] {
        let cell = &self.places.cell;
        &self.cell.states(cell)[row * cell.inputs..][..cell.inputs]
    }

    /// Computes and returns the outputs of all steps of sequences, rows × inputs: rows × outputs.
    ///
    /// # Panics
    /// When a slice has another length than the shape and the sequences.
    pub fn forward(&mut self, parameters: &[f32], inputs: &[f32], sequences: Sequences<'_>) -> &[f32] {
        let (Self { places, encoder, cell, head }, rows) = (self, sequences.starts.len());
        cell.arrange(places.cell.inputs, sequences, |row| row..row + 1);
        let encoded = encoder.forward(&parameters[places.encoder.clone()], inputs, rows);
        cell.inputs(&places.cell).copy_from_slice(encoded);
        cell.forward(&places.cell, parameters, sequences.states);
        head.forward(&parameters[places.head.clone()], cell.states(&places.cell), rows)
    }

    /// Propagates the gradients of the outputs of the last forward pass, which must have been of these inputs, back to
    /// the first step of each sequence. Adds the gradients of the parameters to `sums`.
    ///
    /// # Panics
    /// When a slice has another length than the shape and the sequences.
    pub fn backward(
        &mut self,
        parameters: &[f32],
        inputs: &[f32],
        output_gradients: &[f32],
        sums: &mut [f32],
    ) {
        let Self { places, encoder, cell, head } = self;
        let (states, of_states) = cell.gradients(&places.cell);
        let (of_head, range) = (&parameters[places.head.clone()], places.head.clone());
        head.backward(of_head, states, output_gradients, Some(&mut sums[range]), Some(of_states));
        let of_input = cell.backward(&places.cell, parameters, sums);
        let (of_encoder, range) = (&parameters[places.encoder.clone()], places.encoder.clone());
        encoder.backward(of_encoder, inputs, of_input, Some(&mut sums[range]), None);
    }
}

/// Returns initial parameters: orthogonal weights, with the gain `last` in the last layer and 1 in the cell, which
/// remembers for up to `memory` steps.
pub fn initialize(network: &Recurrent, last: f32, memory: usize, random: &mut RandomStream) -> Vec<f32> {
    let hidden = std::f32::consts::SQRT_2;
    let of =
        |mlp: &Mlp, last, random: &mut RandomStream| orthogonal(mlp, InitialGains { hidden, last }, random);
    let mut parameters = of(&network.encoder, 1.0, random);
    let cell = network.places().cell;
    parameters.resize(cell.biases.end, 0.0);
    cell::initialize(&cell, memory, random, &mut parameters);
    parameters.extend(of(&network.head, last, random));
    parameters
}

#[cfg(test)]
mod tests {
    use b2b_agent::network::recurrent::GATES;
    use b2b_agent::network::{Activation, Actor, Distribution, Shape};

    use super::*;
    use crate::nn::reference::{self, assert_gradients, wide};

    const LENGTH: usize = 6;
    const SEQUENCES: usize = 3;
    const ROWS: usize = LENGTH * SEQUENCES;
    const WIDTH: usize = 4;

    struct Case {
        network: Recurrent,
        parameters: Vec<f32>,
        inputs: Vec<f32>,
        states: Vec<f32>,
        starts: Vec<bool>,
        random: RandomStream,
    }

    impl Case {
        fn new() -> Self {
            let network = Recurrent {
                encoder: Mlp::new(5, &[7], GATES * WIDTH, Activation::Tanh),
                head: Mlp::new(WIDTH, &[6], 2, Activation::Tanh),
            };
            let mut random = RandomStream::new(4, 0);
            let mut parameters = initialize(&network, 1.0, 20, &mut random);
            assert_eq!(parameters.len(), network.parameters());
            parameters.iter_mut().for_each(|value| *value += 0.2 * random.normal() as f32);
            let mut draw = |count| {
                let mut values = vec![0.0; count];
                random.normals(&mut values);
                values
            };
            let (inputs, states) = (draw(ROWS * 5), draw(SEQUENCES * WIDTH));
            // The second sequence forgets before its first step, the third before its fourth.
            let starts = (0..ROWS).map(|row| [LENGTH, 2 * LENGTH + 3].contains(&row)).collect();
            Self { network, parameters, inputs, states, starts, random }
        }

        fn sequences(&self) -> Sequences<'_> {
            Sequences { length: LENGTH, states: &self.states, starts: &self.starts }
        }

        /// Returns the outputs in double precision.
        fn reference(&self, parameters: &[f64]) -> Vec<f64> {
            let RecurrentPlaces { encoder, cell, head } = self.network.places();
            let mut outputs = Vec::new();
            let mut state = Vec::new();
            for row in 0..ROWS {
                if row % LENGTH == 0 {
                    state = wide(&self.states[row / LENGTH * WIDTH..][..WIDTH]);
                }
                if self.starts[row] {
                    state.fill(0.0);
                }
                let input = wide(&self.inputs[row * 5..][..5]);
                let x = reference::forward(&self.network.encoder, &parameters[encoder.clone()], &input);
                let layer = Mlp::new(WIDTH, &[], GATES * WIDTH, Activation::Tanh);
                let u = reference::forward(&layer, &parameters[cell.weights.start..cell.biases.end], &state);
                reference::next_state(&x, &u, &mut state);
                outputs.extend(reference::forward(&self.network.head, &parameters[head.clone()], &state));
            }
            outputs
        }
    }

    #[test]
    fn sequences_have_the_outputs_and_states_of_single_steps() {
        let case = Case::new();
        let mut pass = RecurrentPass::new(&case.network);
        let outputs = pass.forward(&case.parameters, &case.inputs, case.sequences()).to_vec();
        let actor = Actor {
            shape: Shape::Recurrent(case.network.clone()),
            parameters: case.parameters.clone(),
            distribution: Distribution::Gaussian { log_std: vec![0.0; 2] },
        };
        let (mut scratch, mut output) = (actor.scratch(None), [0.0; 2]);
        let near = |one: &[f32], other: &[f32]| one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-5);
        for row in 0..ROWS {
            if row % LENGTH == 0 {
                scratch.state_mut().copy_from_slice(&case.states[row / LENGTH * WIDTH..][..WIDTH]);
            }
            if case.starts[row] {
                scratch.state_mut().fill(0.0);
            }
            actor.mean(&case.inputs[row * 5..][..5], &mut scratch, &mut output);
            assert!(near(&output, &outputs[2 * row..][..2]), "row {row}");
            assert!(near(scratch.state(), pass.state(row)), "row {row}");
        }
    }

    #[test]
    fn gradients_match_finite_differences() {
        let mut case = Case::new();
        let mut weights = vec![0.0; ROWS * 2];
        case.random.normals(&mut weights);
        let mut pass = RecurrentPass::new(&case.network);
        pass.forward(&case.parameters, &case.inputs, case.sequences());
        let mut sums = vec![0.0; case.parameters.len()];
        pass.backward(&case.parameters, &case.inputs, &weights, &mut sums);
        assert_gradients(&wide(&case.parameters), &sums, |parameters| {
            let outputs = case.reference(parameters);
            outputs.iter().zip(&weights).map(|(output, weight)| output * f64::from(*weight)).sum()
        });
        // Gradients accumulate, and the buffers serve fewer sequences.
        let first =
            Sequences { length: LENGTH, states: &case.states[..WIDTH], starts: &case.starts[..LENGTH] };
        let inputs = &case.inputs[..LENGTH * 5];
        let before = sums.clone();
        for sign in [1.0, -1.0] {
            let weights: Vec<f32> = weights[..LENGTH * 2].iter().map(|weight| sign * weight).collect();
            pass.forward(&case.parameters, inputs, first);
            pass.backward(&case.parameters, inputs, &weights, &mut sums);
        }
        assert!(sums.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
