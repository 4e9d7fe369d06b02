//! Forward and backward passes of batches of buildings.

use b2b_agent::network::graph::{Batch, Graph, GraphNetwork, MemoryPlaces, Places, Span, Tape};

use super::backward::{Gradients, Target};
use crate::nn::cell::{CellPass, Sequences};
use crate::nn::pass::forward;
use crate::nn::sized;

/// The use of the outputs of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readout {
    /// The outputs of the actions of a building in the order of its actuators, padded to `actions`; with `of_state` as
    /// many logarithms of standard deviations follow.
    Actions {
        /// Actions in a row.
        actions: usize,
        /// Whether logarithms of standard deviations follow.
        of_state: bool,
    },
    /// The mean of the outputs of all nodes.
    Mean,
    /// The output of each node, padded to `nodes`.
    Nodes {
        /// Nodes in a row.
        nodes: usize,
    },
}

/// Buffers of passes through a graph network. They grow to the largest batch and are reused: see
/// [`Pass`](crate::nn::Pass).
#[derive(Clone, Debug)]
pub struct GraphPass {
    network: GraphNetwork,
    places: Places,
    readout: Readout,
    tape: Tape,
    /// The pass through the memory.
    cell: CellPass,
    gradients: Gradients,
    outputs: Vec<f32>,
}

impl GraphPass {
    /// Returns the buffers of a network.
    pub fn new(network: &GraphNetwork, readout: Readout) -> Self {
        Self {
            network: network.clone(),
            places: network.places(),
            readout,
            tape: Tape::default(),
            cell: CellPass::default(),
            gradients: Gradients::default(),
            outputs: Vec::new(),
        }
    }

    /// Returns the width of a row of outputs.
    pub fn width(&self) -> usize {
        match self.readout {
            Readout::Actions { actions, of_state } => actions * if of_state { 2 } else { 1 },
            Readout::Mean => 1,
            Readout::Nodes { nodes } => nodes,
        }
    }

    /// Returns the outputs of the last forward pass: rows × width.
    pub fn outputs(&self) -> &[f32] {
        &self.outputs[..self.tape.rows.len() * self.width()]
    }

    /// Returns the states of the nodes after a row of the last forward pass.
    pub fn state(&self, row: usize) -> &[f32] {
        let Some(MemoryPlaces { cell, .. }) = &self.places.memory else { return &[] };
        let Span { first, nodes, .. } = self.tape.rows[row];
        &self.cell.states(cell)[first * cell.inputs..][..nodes * cell.inputs]
    }

    /// Computes and returns the outputs of a batch, whose rows are the steps of sequences for a network with a memory:
    /// rows × width. Padding is 0.
    ///
    /// # Panics
    /// When the parameters or the rows have another length than the shape.
    pub fn forward(&mut self, parameters: &[f32], batch: Batch<'_>, sequences: Sequences<'_>) -> &[f32] {
        let (width, rows) = (self.width(), batch.of_rows.len());
        let Self { network, places, tape, cell: pass, outputs, readout, .. } = self;
        tape.embed(network, places, parameters, batch, forward);
        let mut states = &[][..];
        if let Some(MemoryPlaces { input, cell }) = &places.memory {
            let tokens = |row: usize| tape.rows[row].first..tape.rows[row].first + tape.rows[row].nodes;
            pass.arrange(cell.inputs, sequences, tokens);
            forward(input, parameters, tape.embeddings(network), pass.inputs(cell));
            pass.forward(cell, parameters, sequences.states);
            states = pass.states(cell);
        }
        tape.decode(network, places, parameters, states, forward);
        let outputs = sized(outputs, rows * width);
        outputs.fill(0.0);
        for ((row, graph), outputs) in batch.graphs().enumerate().zip(outputs.chunks_exact_mut(width)) {
            each(*readout, network, graph, |node, output, place, share| {
                outputs[place] += share * tape.outputs_of(network, row, node)[output];
            });
        }
        self.outputs()
    }

    /// Propagates output gradients back through the last forward pass, which must have been on this batch, and adds the
    /// parameters' gradients to `sums`.
    ///
    /// # Panics
    /// When a slice has another length than the shape.
    pub fn backward(&mut self, parameters: &[f32], batch: Batch<'_>, gradients: &[f32], sums: &mut [f32]) {
        let width = self.width();
        let Self { network, places, readout, tape, cell, gradients: buffers, .. } = self;
        buffers.begin(network, tape);
        for ((row, graph), gradients) in batch.graphs().enumerate().zip(gradients.chunks_exact(width)) {
            each(*readout, network, graph, |node, output, place, share| {
                let token = tape.rows[row].first + node;
                let outputs = network.types[tape.types[token]].outputs;
                buffers.outputs[tape.types[token]][tape.places[token] * outputs + output] +=
                    share * gradients[place];
            });
        }
        let mut target = Target { network, places, parameters, sums };
        buffers.propagate(&mut target, tape, cell, batch);
    }
}

/// Calls a function with every output of a building that is read: node, output of the node, place in the row, and its
/// share there.
fn each(
    readout: Readout,
    network: &GraphNetwork,
    graph: &Graph,
    mut read: impl FnMut(usize, usize, usize, f32),
) {
    match readout {
        Readout::Actions { actions, of_state } => {
            for (action, place) in graph.actions.iter().enumerate() {
                read(place.node, place.output, action, 1.0);
                if of_state {
                    let half = network.types[graph.types[place.node]].outputs / 2;
                    read(place.node, half + place.output, actions + action, 1.0);
                }
            }
        }
        Readout::Mean => {
            let share = 1.0 / graph.nodes() as f32;
            (0..graph.nodes()).for_each(|node| read(node, 0, 0, share));
        }
        Readout::Nodes { .. } => (0..graph.nodes()).for_each(|node| read(node, 0, node, 1.0)),
    }
}
