use std::sync::Arc;

use b2b_agent::network::graph::{ActionPlace, Batch, Edges, Graph, GraphNetwork, NodeWidths, REACHES, Tape};
use b2b_agent::network::{Activation, Layer};

use super::{GraphPass, Readout, initialize, reference};
use crate::nn::cell::Sequences;
use crate::nn::reference::{assert_gradients, wide};
use crate::random::RandomStream;

/// Features and outputs of three node types, the last of which is only observed, and the second only controlled.
const TYPES: [(usize, usize); 3] = [(3, 2), (0, 1), (2, 0)];

fn network((edges, memory): (Edges, usize), outputs: fn(usize) -> usize) -> GraphNetwork {
    GraphNetwork {
        types: TYPES.map(|(features, actions)| NodeWidths { features, outputs: outputs(actions) }).to_vec(),
        embedding: 8,
        heads: 2,
        layers: 2,
        feed_forward: 6,
        activation: Activation::Tanh,
        edges,
        memory,
    }
}

/// Returns a building with nodes of these types, and random edges.
fn graph(types: &[usize], seed: u64) -> Graph {
    let mut random = RandomStream::new(seed, 0);
    let mut features = vec![0];
    types.iter().for_each(|each| features.push(features[features.len() - 1] + TYPES[*each].0));
    let nodes = types.len();
    let relations = (0..nodes * nodes).map(|pair| match (pair / nodes == pair % nodes, random.below(3)) {
        (true, _) => REACHES,
        (_, 0) => REACHES | 1 << random.below(5),
        _ => 0,
    });
    let actions = types.iter().enumerate().flat_map(|(node, each)| {
        let number = TYPES[..*each].iter().map(|(_, actions)| actions).sum::<usize>();
        (0..TYPES[*each].1).map(move |output| ActionPlace { node, output, number: number + output })
    });
    Graph {
        names: types.iter().map(usize::to_string).collect(),
        types: types.to_vec(),
        features,
        actions: actions.collect(),
        relations: relations.collect(),
    }
}

/// Three buildings, the first two of which have one shape.
fn graphs() -> Vec<Arc<Graph>> {
    let types: [&[usize]; 3] = [&[0, 0, 1, 2], &[0, 0, 1, 2], &[0, 1, 0, 0, 0, 2, 2, 1]];
    types.into_iter().zip(1..).map(|(types, seed)| Arc::new(graph(types, seed))).collect()
}

/// Two sequences of three steps. The first changes its building before the last step; the second forgets before its
/// second step.
const OF_ROWS: [usize; 6] = [2, 2, 0, 1, 1, 1];
const STARTS: [bool; 6] = [false, false, true, false, true, false];
const LENGTH: usize = 3;
const WIDTH: usize = 18;
/// Nodes of the largest building.
const NODES_OF_LARGEST: usize = 8;

fn random_parameters(network: &GraphNetwork) -> Vec<f32> {
    let mut random = RandomStream::new(5, 0);
    let mut parameters = initialize(network, 1.0, 20, &mut random);
    parameters.iter_mut().for_each(|value| *value += 0.2 * random.normal() as f32);
    parameters
}

fn normals(count: usize, seed: u64) -> Vec<f32> {
    let mut values = vec![0.0; count];
    RandomStream::new(seed, 0).normals(&mut values);
    values
}

fn observations() -> Vec<f32> {
    normals(OF_ROWS.len() * WIDTH, 9)
}

/// Returns states before sequences of a number of rows, padded to the largest building.
fn states(network: &GraphNetwork, sequences: usize) -> Vec<f32> {
    normals(sequences * NODES_OF_LARGEST * network.memory, 8)
}

/// Uses of edges and widths of memories.
const ALL: [(Edges, usize); 5] =
    [(Edges::None, 0), (Edges::Bias, 0), (Edges::Mask, 0), (Edges::Mixed, 0), (Edges::Bias, 11)];

/// Returns outputs of a batch by the definition, from observations and the states before sequences: rows × 12 actions,
/// rows × 9 nodes or rows × 1.
fn expected(
    network: &GraphNetwork,
    parameters: &[f64],
    graphs: &[Arc<Graph>],
    (observations, states): (&[f64], &[f64]),
    readout: Readout,
) -> Vec<f64> {
    let rows = OF_ROWS.iter().zip(observations.chunks(WIDTH)).enumerate();
    let width = network.memory.max(1);
    let mut state = Vec::new();
    rows.flat_map(|(row, (of_row, observation))| {
        let graph = &graphs[*of_row];
        if STARTS[row] {
            state = vec![vec![0.0; network.memory]; graph.nodes()];
        } else if row % LENGTH == 0 {
            let first = row / LENGTH * NODES_OF_LARGEST * network.memory;
            state = states[first..].chunks(width).take(graph.nodes()).map(<[f64]>::to_vec).collect();
        }
        let outputs = reference::forward(network, parameters, graph, observation, &mut state);
        match readout {
            Readout::Actions { actions, .. } => {
                let mut row: Vec<f64> =
                    graph.actions.iter().map(|place| outputs[place.node][place.output]).collect();
                row.resize(actions, 0.0);
                row
            }
            Readout::Nodes { nodes } => {
                let mut row: Vec<f64> = outputs.iter().map(|node| node[0]).collect();
                row.resize(nodes, 0.0);
                row
            }
            Readout::Mean => vec![outputs.iter().map(|node| node[0]).sum::<f64>() / outputs.len() as f64],
        }
    })
    .collect()
}

const ACTIONS: Readout = Readout::Actions { actions: 12, of_state: false };
const NODES: Readout = Readout::Nodes { nodes: 9 };

#[test]
fn outputs_and_gradients_match_the_definition() {
    for kind in ALL {
        check_gradients(kind, ACTIONS, |actions| actions);
    }
}

/// All networks have the same readouts, so one network suffices.
#[test]
fn gradients_of_nodes_and_means_match_the_definition() {
    let with_memory = ALL[ALL.len() - 1];
    check_gradients(with_memory, Readout::Mean, |_| 1);
    check_gradients(with_memory, NODES, |_| 1);
}

fn check_gradients(kind: (Edges, usize), readout: Readout, outputs: fn(usize) -> usize) {
    let network = network(kind, outputs);
    let (parameters, observations, graphs) = (random_parameters(&network), observations(), graphs());
    let states = states(&network, OF_ROWS.len() / LENGTH);
    let sequences = Sequences { length: LENGTH, states: &states, starts: &STARTS };
    let batch = Batch { graphs: &graphs, of_rows: &OF_ROWS, observations: &observations, width: WIDTH };
    let mut pass = GraphPass::new(&network, readout);
    let outputs = pass.forward(&parameters, batch, sequences).to_vec();
    let (observed, states) = (wide(&observations), wide(&states));
    let defined = |parameters: &[f64]| expected(&network, parameters, &graphs, (&observed, &states), readout);
    let by_definition = defined(&wide(&parameters));
    assert_eq!(outputs.len(), by_definition.len());
    for (output, expected) in outputs.iter().zip(&by_definition) {
        assert!((f64::from(*output) - expected).abs() < 2e-5, "{kind:?}: {output} {expected}");
    }
    let weights = normals(outputs.len(), 2);
    let mut sums = vec![0.0; parameters.len()];
    pass.backward(&parameters, batch, &weights, &mut sums);
    // Means and scales of features are not learned.
    let mut fixed = vec![false; parameters.len()];
    for encoder in network.places().encoders {
        fixed[encoder.mean.start..encoder.scale.end].fill(true);
    }
    let mut all = wide(&parameters);
    let learned: Vec<usize> = (0..all.len()).filter(|place| !fixed[*place]).collect();
    let gradients: Vec<f32> = learned.iter().map(|place| sums[*place]).collect();
    let start: Vec<f64> = learned.iter().map(|place| all[*place]).collect();
    assert_gradients(&start, &gradients, |moved| {
        learned.iter().zip(moved).for_each(|(place, value)| all[*place] = *value);
        defined(&all).iter().zip(&weights).map(|(output, weight)| output * f64::from(*weight)).sum()
    });
    assert!(sums.iter().zip(&fixed).all(|(sum, fixed)| !fixed || *sum == 0.0));
}

#[test]
fn a_building_in_a_batch_has_the_outputs_that_it_has_alone() {
    let (graphs, observations) = (graphs(), observations());
    for kind in ALL {
        let network = network(kind, |actions| actions);
        let (parameters, places) = (random_parameters(&network), network.places());
        let batch = Batch { graphs: &graphs, of_rows: &OF_ROWS, observations: &observations, width: WIDTH };
        let padded = states(&network, OF_ROWS.len());
        let nodes_of = |row: usize| graphs[OF_ROWS[row]].nodes();
        let own = |row: usize| {
            let first = row * NODES_OF_LARGEST * network.memory;
            padded[first..first + nodes_of(row) * network.memory].to_vec()
        };
        let mut all: Vec<f32> = (0..OF_ROWS.len()).flat_map(own).collect();
        let mut together = Tape::default();
        together.forward(&network, &places, &parameters, batch, &mut all, Layer::forward_rows);
        let mut pass = GraphPass::new(&network, ACTIONS);
        let sequences = Sequences { length: 1, states: &padded, starts: &[false; OF_ROWS.len()] };
        let learned = pass.forward(&parameters, batch, sequences).to_vec();
        let mut alone = Tape::default();
        for (row, (of_row, observation)) in OF_ROWS.iter().zip(observations.chunks(WIDTH)).enumerate() {
            let (graph, mut state) = (&graphs[*of_row], own(row));
            let batch = Batch::of_one(graph, &observation[..graph.width()]);
            alone.forward(&network, &places, &parameters, batch, &mut state, Layer::forward_rows);
            for node in 0..graph.nodes() {
                let bits =
                    [(&together, row), (&alone, 0)].map(|(tape, row)| tape.outputs_of(&network, row, node));
                assert_eq!(bits[0], bits[1]);
            }
            let first = together.rows[row].first * network.memory;
            assert_eq!(state, all[first..first + state.len()], "states after the step");
            let near = |one: &f32, other: &f32| (one - other).abs() < 1e-5;
            assert_eq!(pass.state(row).len(), state.len());
            assert!(pass.state(row).iter().zip(&state).all(|(one, other)| near(one, other)));
            for (action, place) in graph.actions.iter().enumerate() {
                let output = alone.outputs_of(&network, 0, place.node)[place.output];
                assert!(near(&output, &learned[row * 12 + action]), "the learner's pass");
            }
        }
    }
}

#[test]
fn permuted_nodes_have_permuted_outputs() {
    let order = [3, 7, 0, 4, 6, 1, 5, 2];
    let original = &graphs()[2];
    let types: Vec<usize> = order.iter().map(|node| original.types[*node]).collect();
    let mut permuted = graph(&types, 0);
    for (pair, relation) in permuted.relations.iter_mut().enumerate() {
        *relation = original.relations[order[pair / 8] * 8 + order[pair % 8]];
    }
    let permuted = Arc::new(permuted);
    let observation = &observations()[..original.width()];
    let features = |node: &usize| &observation[original.features[*node]..original.features[*node + 1]];
    let moved: Vec<f32> = order.iter().flat_map(features).copied().collect();
    for kind in ALL {
        let network = network(kind, |actions| actions);
        let (parameters, places) = (random_parameters(&network), network.places());
        let states = states(&network, 1);
        let moved_states = order.iter().flat_map(|node| &states[node * network.memory..][..network.memory]);
        let both =
            [(original, observation, states.clone()), (&permuted, &moved, moved_states.copied().collect())];
        let [before, after] = both.map(|(graph, observation, mut states)| {
            let (mut tape, batch) = (Tape::default(), Batch::of_one(graph, observation));
            tape.forward(&network, &places, &parameters, batch, &mut states, Layer::forward_rows);
            tape
        });
        for (place, node) in order.iter().enumerate() {
            let outputs = after.outputs_of(&network, 0, place).iter();
            for (output, expected) in outputs.zip(before.outputs_of(&network, 0, *node)) {
                assert!((output - expected).abs() < 1e-5, "{kind:?}: {output} {expected}");
            }
        }
    }
}
