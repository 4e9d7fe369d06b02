//! Passes of sequences through recurrent networks: forward, and backward through time.

use b2b_agent::network::graph::sized;
use b2b_agent::network::recurrent::{GATES, Recurrent, RecurrentPlaces, step};
use b2b_agent::network::{Layer, Mlp};

use super::orthogonal::{InitialGains, orthogonal, write_weights};
use super::pass::{Pass, add_parameter_gradients, forward};
use super::product::{Matrix, multiply};
use crate::random::RandomStream;

/// Sequences of steps. Rows of steps have one sequence after another.
#[derive(Clone, Copy, Debug)]
pub struct Sequences<'a> {
    /// Steps of each.
    pub length: usize,
    /// State before the first step of each: sequences × width.
    pub states: &'a [f32],
    /// Whether a step begins with a state of zeros instead: sequences × length.
    pub starts: &'a [bool],
}

impl Sequences<'_> {
    /// Returns steps of networks without a state.
    pub fn none() -> Self {
        Self { length: 1, states: &[], starts: &[] }
    }
}

/// Buffers of passes through a recurrent network. They grow to the largest batch and are reused: see [`Pass`].
///
/// The encoder and the head process the steps of all sequences together, the cell one step of all sequences at a time.
#[derive(Clone, Debug)]
pub struct RecurrentPass {
    places: RecurrentPlaces,
    encoder: Pass,
    head: Pass,
    /// Values of the gates of each row.
    gates: Vec<f32>,
    /// State after each row.
    after: Vec<f32>,
    /// State before each step, and inputs of the gates from it: one step of all sequences after another.
    before: Vec<f32>,
    of_state: Vec<f32>,
    gradients: CellGradients,
    rows: usize,
}

/// Gradients of a backward pass.
#[derive(Clone, Debug, Default)]
struct CellGradients {
    /// Of the states after the rows.
    states: Vec<f32>,
    /// Of the inputs of the gates from the encoder, by row.
    of_input: Vec<f32>,
    /// Of the inputs of the gates from the state, one step of all sequences after another.
    of_state: Vec<f32>,
    /// Of the states before the last step processed: sequences × width.
    carried: Vec<f32>,
}

impl RecurrentPass {
    /// Returns the buffers of a shape.
    pub fn new(network: &Recurrent) -> Self {
        Self {
            places: network.places(),
            encoder: Pass::new(&network.encoder),
            head: Pass::new(&network.head),
            gates: Vec::new(),
            after: Vec::new(),
            before: Vec::new(),
            of_state: Vec::new(),
            gradients: CellGradients::default(),
            rows: 0,
        }
    }

    /// Returns the outputs of the last forward pass: rows × outputs.
    pub fn outputs(&self) -> &[f32] {
        self.head.outputs()
    }

    /// Returns the states after the rows of the last forward pass: rows × width.
    pub fn states(&self) -> &[f32] {
        &self.after[..self.rows * self.width()]
    }

    /// Returns the width of the state.
    fn width(&self) -> usize {
        self.places.cell.inputs
    }

    /// Computes and returns the outputs of all steps of sequences, rows × inputs: rows × outputs.
    ///
    /// # Panics
    /// When a slice has another length than the shape and the sequences.
    pub fn forward(&mut self, parameters: &[f32], inputs: &[f32], sequences: Sequences<'_>) -> &[f32] {
        let (rows, width) = (sequences.starts.len(), self.width());
        self.rows = rows;
        let encoded = self.encoder.forward(&parameters[self.places.encoder.clone()], inputs, rows);
        sized(&mut self.gates, rows * GATES * width).copy_from_slice(encoded);
        sized(&mut self.after, rows * width);
        sized(&mut self.before, rows * width);
        sized(&mut self.of_state, rows * GATES * width);
        for number in 0..sequences.length {
            self.forward_step(parameters, number, sequences);
        }
        self.head.forward(&parameters[self.places.head.clone()], &self.after[..rows * width], rows)
    }

    /// Computes the states after a step of all sequences.
    fn forward_step(&mut self, parameters: &[f32], number: usize, sequences: Sequences<'_>) {
        let (width, Sequences { length, states, starts }) = (self.width(), sequences);
        let count = starts.len() / length;
        let before = &mut self.before[number * count * width..][..count * width];
        for (sequence, before) in before.chunks_exact_mut(width).enumerate() {
            let row = sequence * length + number;
            match number {
                _ if starts[row] => before.fill(0.0),
                0 => before.copy_from_slice(&states[sequence * width..][..width]),
                _ => before.copy_from_slice(&self.after[(row - 1) * width..][..width]),
            }
        }
        let of_state = &mut self.of_state[number * count * GATES * width..][..count * GATES * width];
        forward(&self.places.cell, parameters, before, of_state);
        let both = before.chunks_exact(width).zip(of_state.chunks_exact(GATES * width));
        for (sequence, (before, of_state)) in both.enumerate() {
            let row = sequence * length + number;
            let after = &mut self.after[row * width..][..width];
            after.copy_from_slice(before);
            step(&mut self.gates[row * GATES * width..][..GATES * width], of_state, after);
        }
    }

    /// Propagates the gradients of the outputs of the last forward pass, which must have been of these inputs and sequences, back
    /// to the first step of each sequence. Adds the gradients of the parameters to `sums`.
    ///
    /// # Panics
    /// When a slice has another length than the shape and the sequences.
    pub fn backward(
        &mut self,
        parameters: &[f32],
        (inputs, sequences): (&[f32], Sequences<'_>),
        output_gradients: &[f32],
        sums: &mut [f32],
    ) {
        let (rows, width) = (self.rows, self.width());
        let Self { places, head, after, gradients, .. } = self;
        let states = sized(&mut gradients.states, rows * width);
        let (of_head, range) = (&parameters[places.head.clone()], places.head.clone());
        head.backward(
            of_head,
            &after[..rows * width],
            output_gradients,
            Some(&mut sums[range]),
            Some(states),
        );
        sized(&mut gradients.of_input, rows * GATES * width);
        sized(&mut gradients.of_state, rows * GATES * width);
        sized(&mut gradients.carried, rows / sequences.length * width).fill(0.0);
        for number in (0..sequences.length).rev() {
            self.backward_step(parameters, number, sequences);
        }
        let Self { places, encoder, before, gradients, .. } = self;
        let (of_state, before) = (&gradients.of_state[..rows * GATES * width], &before[..rows * width]);
        add_parameter_gradients(&places.cell, before, of_state, rows, sums);
        let of_input = &gradients.of_input[..rows * GATES * width];
        let (of_encoder, range) = (&parameters[places.encoder.clone()], places.encoder.clone());
        encoder.backward(of_encoder, inputs, of_input, Some(&mut sums[range]), None);
    }

    /// Computes the gradients of a step of all sequences, and of the states before it.
    fn backward_step(&mut self, parameters: &[f32], number: usize, sequences: Sequences<'_>) {
        let (width, Sequences { length, starts, .. }) = (self.width(), sequences);
        let (count, gates) = (starts.len() / length, GATES * width);
        let Self { places, gates: values, before, of_state, gradients, .. } = self;
        let CellGradients { states, of_input, of_state: of_state_gradients, carried } = gradients;
        let carried = &mut carried[..count * width];
        for (sequence, carried) in carried.chunks_exact_mut(width).enumerate() {
            let (row, place) = (sequence * length + number, number * count + sequence);
            let known = Known {
                gates: &values[row * gates..][..gates],
                candidate: &of_state[place * gates..][2 * width..gates],
                before: &before[place * width..][..width],
                after: &states[row * width..][..width],
            };
            let of_input = &mut of_input[row * gates..][..gates];
            known.backward(carried, of_input, &mut of_state_gradients[place * gates..][..gates]);
        }
        let cell = &places.cell;
        let weights = Matrix::new(&parameters[cell.weights.clone()], cell.inputs, cell.outputs);
        let of_state = &of_state_gradients[number * count * gates..][..count * gates];
        multiply(Matrix::new(of_state, count, gates), weights.transposed(), 1.0, carried);
        for (sequence, carried) in carried.chunks_exact_mut(width).enumerate() {
            if starts[sequence * length + number] {
                carried.fill(0.0);
            }
        }
    }
}

/// The known numbers of a step of a sequence.
struct Known<'a> {
    /// Values of update gate, reset gate and candidate.
    gates: &'a [f32],
    /// Input of the candidate from the state.
    candidate: &'a [f32],
    /// State before the step.
    before: &'a [f32],
    /// Gradients of the state after the step, without later steps.
    after: &'a [f32],
}

impl Known<'_> {
    /// Writes the gradients of the inputs of the gates, from the encoder and from the state. `carried` has the gradients of the
    /// state from later steps, and gets the gradients of the state before the step that do not pass through the gates.
    fn backward(&self, carried: &mut [f32], of_input: &mut [f32], of_state: &mut [f32]) {
        let width = carried.len();
        for unit in 0..width {
            let gradient = self.after[unit] + carried[unit];
            let [update, reset, candidate] = [0, 1, 2].map(|gate| self.gates[gate * width + unit]);
            let of_candidate = gradient * (1.0 - update) * (1.0 - candidate * candidate);
            let of_update = gradient * (self.before[unit] - candidate) * update * (1.0 - update);
            let of_reset = of_candidate * self.candidate[unit] * reset * (1.0 - reset);
            for (gate, value) in [of_update, of_reset, of_candidate].into_iter().enumerate() {
                of_input[gate * width + unit] = value;
                of_state[gate * width + unit] = value;
            }
            of_state[2 * width + unit] *= reset;
            carried[unit] = gradient * update;
        }
    }
}

/// Returns initial parameters: orthogonal weights, with the gain `last` in the last layer and 1 in the cell. The update gates
/// remember for 1 to `memory` steps, evenly on a logarithmic scale, so that some units keep what others forget (after Tallec and
/// Ollivier 2018).
pub fn initialize(network: &Recurrent, last: f32, memory: usize, random: &mut RandomStream) -> Vec<f32> {
    let hidden = std::f32::consts::SQRT_2;
    let of =
        |mlp: &Mlp, last, random: &mut RandomStream| orthogonal(mlp, InitialGains { hidden, last }, random);
    let mut parameters = of(&network.encoder, 1.0, random);
    let (width, cell) = (network.state(), network.places().cell);
    parameters.resize(cell.biases.end, 0.0);
    let gate = Layer { inputs: width, outputs: width, weights: 0..width * width, biases: 0..0 };
    let mut weights = vec![0.0; width * width];
    for number in 0..GATES {
        write_weights(&gate, 1.0, random, &mut weights);
        let rows = parameters[cell.weights.clone()].chunks_exact_mut(cell.outputs);
        for (row, own) in rows.zip(weights.chunks_exact(width)) {
            row[number * width..][..width].copy_from_slice(own);
        }
    }
    for bias in &mut parameters[cell.biases.clone()][..width] {
        *bias = (random.uniform() * (memory as f64).ln()) as f32;
    }
    parameters.extend(of(&network.head, last, random));
    parameters
}

#[cfg(test)]
mod tests {
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
            let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
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
                for unit in 0..WIDTH {
                    let z = logistic(x[unit] + u[unit]);
                    let r = logistic(x[WIDTH + unit] + u[WIDTH + unit]);
                    let n = (x[2 * WIDTH + unit] + r * u[2 * WIDTH + unit]).tanh();
                    state[unit] = (1.0 - z) * n + z * state[unit];
                }
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
            assert!(near(scratch.state(), &pass.states()[row * WIDTH..][..WIDTH]), "row {row}");
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
        pass.backward(&case.parameters, (&case.inputs, case.sequences()), &weights, &mut sums);
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
            pass.backward(&case.parameters, (inputs, first), &weights, &mut sums);
        }
        assert!(sums.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-5));
    }
}
