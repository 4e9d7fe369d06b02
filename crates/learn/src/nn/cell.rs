//! Passes of sequences through a gated recurrent unit: forward, and backward through time.

use std::ops::Range;

use b2b_agent::network::Layer;
use b2b_agent::network::graph::sized;
use b2b_agent::network::recurrent::{GATES, step};

use super::orthogonal::write_weights;
use super::pass::{add_parameter_gradients, forward};
use super::product::{Matrix, multiply};
use crate::random::RandomStream;

/// Sequences of steps. Rows of steps have one sequence after another.
#[derive(Clone, Copy, Debug)]
pub struct Sequences<'a> {
    /// Steps of each.
    pub length: usize,
    /// State before the first step of each: sequences × width. In a graph network, it has the states of one node after
    /// another, and padding after the nodes of smaller buildings.
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

/// Buffers of passes through the unit. They grow to the largest batch and are reused: see [`Pass`](super::Pass).
///
/// A token is a row or, in a graph network, a node of a row. The unit processes one step of all sequences at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct CellPass {
    /// Tokens in the order of time.
    order: Vec<Token>,
    /// Ends of the steps in this order.
    ends: Vec<usize>,
    /// Inputs and then values of the gates of each token.
    gates: Vec<f32>,
    /// State after each token.
    after: Vec<f32>,
    /// State before each token, and inputs of the gates from it, in the order of time.
    before: Vec<f32>,
    of_state: Vec<f32>,
    gradients: CellGradients,
}

/// A token and the state before it.
#[derive(Clone, Copy, Debug)]
struct Token {
    number: usize,
    before: Before,
}

/// The origin of a state.
#[derive(Clone, Copy, Debug)]
enum Before {
    Zeros,
    /// At this place in the states before the sequences.
    Given(usize),
    /// After this token.
    After(usize),
}

/// Gradients of a backward pass.
#[derive(Clone, Debug, Default)]
struct CellGradients {
    /// Of the states after the tokens.
    after: Vec<f32>,
    /// Of the inputs of the gates from the input, by token.
    of_input: Vec<f32>,
    /// Of the inputs of the gates from the state, in the order of time.
    of_state: Vec<f32>,
    /// Of the states before a step.
    before: Vec<f32>,
}

impl CellPass {
    /// Arranges the tokens of the rows of sequences in the order of time.
    ///
    /// # Panics
    /// If the number of tokens changes within a sequence where the state does not begin with zeros.
    pub fn arrange(
        &mut self,
        width: usize,
        sequences: Sequences<'_>,
        tokens: impl Fn(usize) -> Range<usize>,
    ) {
        let Sequences { length, states, starts } = sequences;
        let count = starts.len() / length;
        let stride = states.len() / count.max(1);
        self.order.clear();
        self.ends.clear();
        for number in 0..length {
            for sequence in 0..count {
                let row = sequence * length + number;
                let (own, earlier) = (tokens(row), tokens(row.saturating_sub(1)));
                let goes_on = number > 0 && !starts[row];
                assert!(!goes_on || earlier.len() == own.len(), "a state is of the nodes of one building");
                for (index, token) in own.enumerate() {
                    let before = match number {
                        _ if starts[row] => Before::Zeros,
                        0 => Before::Given(sequence * stride + index * width),
                        _ => Before::After(earlier.start + index),
                    };
                    self.order.push(Token { number: token, before });
                }
            }
            self.ends.push(self.order.len());
        }
    }

    /// Returns the inputs of the gates of all tokens, to set them before a forward pass.
    pub fn inputs(&mut self, cell: &Layer) -> &mut [f32] {
        sized(&mut self.gates, self.order.len() * cell.outputs)
    }

    /// Returns the states after the tokens.
    pub fn states(&self, cell: &Layer) -> &[f32] {
        &self.after[..self.order.len() * cell.inputs]
    }

    /// Computes the states after all tokens, from the [inputs](Self::inputs) and the states before the sequences.
    pub fn forward(&mut self, cell: &Layer, parameters: &[f32], states: &[f32]) {
        let tokens = self.order.len();
        for (buffer, width) in [
            (&mut self.after, cell.inputs),
            (&mut self.before, cell.inputs),
            (&mut self.of_state, cell.outputs),
        ] {
            sized(buffer, tokens * width);
        }
        for number in 0..self.ends.len() {
            self.forward_step(cell, parameters, self.step(number), states);
        }
    }

    /// Returns the places of a step in the order of time.
    fn step(&self, number: usize) -> Range<usize> {
        number.checked_sub(1).map_or(0, |earlier| self.ends[earlier])..self.ends[number]
    }

    fn forward_step(&mut self, cell: &Layer, parameters: &[f32], places: Range<usize>, states: &[f32]) {
        let (width, gates) = (cell.inputs, cell.outputs);
        let before = &mut self.before[places.start * width..places.end * width];
        for (token, before) in self.order[places.clone()].iter().zip(before.chunks_exact_mut(width)) {
            match token.before {
                Before::Zeros => before.fill(0.0),
                Before::Given(place) => before.copy_from_slice(&states[place..][..width]),
                Before::After(token) => before.copy_from_slice(&self.after[token * width..][..width]),
            }
        }
        let of_state = &mut self.of_state[places.start * gates..places.end * gates];
        forward(cell, parameters, before, of_state);
        let known = before.chunks_exact(width).zip(of_state.chunks_exact(gates));
        for (token, (before, of_state)) in self.order[places].iter().zip(known) {
            let after = &mut self.after[token.number * width..][..width];
            after.copy_from_slice(before);
            step(&mut self.gates[token.number * gates..][..gates], of_state, after);
        }
    }

    /// Returns the states after the tokens of the last forward pass, and the buffer of their gradients. Before a
    /// backward pass, the caller fills it with the gradients that do not come through later steps.
    pub fn gradients(&mut self, cell: &Layer) -> (&[f32], &mut [f32]) {
        let numbers = self.order.len() * cell.inputs;
        (&self.after[..numbers], sized(&mut self.gradients.after, numbers))
    }

    /// Propagates the [gradients](Self::gradients) of the states back to the first step of each sequence. Adds the
    /// gradients of the unit's parameters to `sums`, and returns the gradients of the [inputs](Self::inputs).
    pub fn backward(&mut self, cell: &Layer, parameters: &[f32], sums: &mut [f32]) -> &[f32] {
        let tokens = self.order.len();
        sized(&mut self.gradients.of_input, tokens * cell.outputs);
        sized(&mut self.gradients.of_state, tokens * cell.outputs);
        for number in (0..self.ends.len()).rev() {
            self.backward_step(cell, parameters, self.step(number));
        }
        let of_state = &self.gradients.of_state[..tokens * cell.outputs];
        add_parameter_gradients(cell, &self.before[..tokens * cell.inputs], of_state, tokens, sums);
        &self.gradients.of_input[..tokens * cell.outputs]
    }

    /// Computes the gradients of a step of all sequences, and adds the gradients of the states before it.
    fn backward_step(&mut self, cell: &Layer, parameters: &[f32], places: Range<usize>) {
        let (width, gates) = (cell.inputs, cell.outputs);
        let CellGradients { after, of_input, of_state, before: of_before } = &mut self.gradients;
        let of_before = sized(of_before, places.len() * width);
        let tokens = &self.order[places.clone()];
        for ((place, token), of_before) in places.clone().zip(tokens).zip(of_before.chunks_exact_mut(width)) {
            let known = Known {
                gates: &self.gates[token.number * gates..][..gates],
                candidate: &self.of_state[place * gates..][2 * width..gates],
                before: &self.before[place * width..][..width],
                after: &after[token.number * width..][..width],
            };
            let of_input = &mut of_input[token.number * gates..][..gates];
            known.backward(of_before, of_input, &mut of_state[place * gates..][..gates]);
        }
        let weights = Matrix::new(&parameters[cell.weights.clone()], width, gates);
        let of_state = Matrix::new(&of_state[places.start * gates..places.end * gates], places.len(), gates);
        multiply(of_state, weights.transposed(), 1.0, of_before);
        for (token, of_before) in tokens.iter().zip(of_before.chunks_exact(width)) {
            if let Before::After(earlier) = token.before {
                let sums = &mut after[earlier * width..][..width];
                sums.iter_mut().zip(of_before).for_each(|(sum, gradient)| *sum += gradient);
            }
        }
    }
}

/// The known numbers of a token.
struct Known<'a> {
    /// Values of update gate, reset gate and candidate.
    gates: &'a [f32],
    /// Input of the candidate from the state.
    candidate: &'a [f32],
    /// State before it.
    before: &'a [f32],
    /// Gradients of the state after it.
    after: &'a [f32],
}

impl Known<'_> {
    /// Writes the gradients of the inputs of the gates, from the input and from the state, and the gradients of the
    /// state before that do not pass through the gates.
    fn backward(&self, of_before: &mut [f32], of_input: &mut [f32], of_state: &mut [f32]) {
        let width = of_before.len();
        for unit in 0..width {
            let gradient = self.after[unit];
            let [update, reset, candidate] = [0, 1, 2].map(|gate| self.gates[gate * width + unit]);
            let of_candidate = gradient * (1.0 - update) * (1.0 - candidate * candidate);
            let of_update = gradient * (self.before[unit] - candidate) * update * (1.0 - update);
            let of_reset = of_candidate * self.candidate[unit] * reset * (1.0 - reset);
            for (gate, value) in [of_update, of_reset, of_candidate].into_iter().enumerate() {
                of_input[gate * width + unit] = value;
                of_state[gate * width + unit] = value;
            }
            of_state[2 * width + unit] *= reset;
            of_before[unit] = gradient * update;
        }
    }
}

/// Writes the initial parameters of a unit: orthogonal weights. The update gates remember for 1 to `memory` steps,
/// evenly on a logarithmic scale, so that some units keep what others forget (after Tallec and Ollivier 2018).
pub(super) fn initialize(cell: &Layer, memory: usize, random: &mut RandomStream, parameters: &mut [f32]) {
    let width = cell.inputs;
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
}
