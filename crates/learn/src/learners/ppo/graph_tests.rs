use std::sync::Arc;

use b2b_agent::network::graph::{ActionPlace, Batch, Edges, NodeWidths, Tape};
use b2b_agent::network::{Activation, Graph, GraphNetwork, Layer};

use super::config::{LogStd, PpoConfig};
use super::learner::Ppo;
use super::worker::{ACTOR, CRITIC, Minibatch, Worker};
use crate::credit::Credit;
use crate::learner::Learner as _;
use crate::nn::graph::reference::{self, Tokens};
use crate::nn::reference::{assert_gradients, wide};
use crate::random::RandomStream;
use crate::rollout::{End, Rollout, Scene};
use crate::state::State;
use crate::widths::Widths;

/// The largest building has three zones of two features and one action, and a node of one feature without actions.
const WIDTHS: Widths = Widths { observation: 7, action: 3, parts: 1, nodes: 4 };
/// With a reward part for each node.
const BY_NODE: Widths = Widths { parts: 4, ..WIDTHS };

fn network() -> GraphNetwork {
    GraphNetwork {
        types: vec![NodeWidths { features: 2, outputs: 1 }, NodeWidths { features: 1, outputs: 0 }],
        embedding: 8,
        heads: 2,
        layers: 1,
        feed_forward: 6,
        activation: Activation::Tanh,
        edges: Edges::None,
        memory: 0,
    }
}

/// Returns a building with this number of zones.
fn building(zones: usize) -> Arc<Graph> {
    let place = |node| ActionPlace { node, output: 0, number: 0 };
    let nodes = zones + 1;
    Arc::new(Graph {
        names: (0..nodes).map(|node| format!("node {node}")).collect(),
        types: (0..nodes).map(|node| usize::from(node == zones)).collect(),
        features: (0..nodes).map(|node| 2 * node).chain([2 * zones + 1]).collect(),
        actions: (0..zones).map(place).collect(),
        relations: vec![0; nodes * nodes],
    })
}

fn config(log_std: LogStd) -> PpoConfig {
    PpoConfig {
        batch_size: 16,
        epochs: 2,
        entropy_coefficient: 0.02,
        actor_gain: 0.5,
        initial_log_std: -0.3,
        log_std,
        ..PpoConfig::default()
    }
}

fn learner(log_std: LogStd, seed: u64) -> Ppo {
    Ppo::of_graphs((&network(), 1), WIDTHS, config(log_std), true, seed).unwrap()
}

/// Returns random steps of two environments; the second changes from a building of three zones to a building of two.
fn rollout(steps: usize, seed: u64) -> Rollout {
    rollout_of(WIDTHS, steps, seed)
}

/// Returns steps with rewards of these widths. With parts by node, each zone has a reward, and so does the last node,
/// which counts for all actions.
fn rollout_of(widths: Widths, steps: usize, seed: u64) -> Rollout {
    let mut random = RandomStream::new(seed, 1);
    let mut draw = |count: usize| {
        let mut values = vec![0.0; count];
        random.normals(&mut values);
        values
    };
    let scene = |environment, step, zones: usize| {
        let (graph, nodes) = (building(zones), zones + 1);
        let weight = |place: usize| f32::from(u8::from([place / nodes, zones].contains(&(place % nodes))));
        let credit = match widths.parts {
            1 => Credit::joint(Widths { action: zones, ..widths }),
            _ => {
                let penalized: Vec<usize> = (0..nodes).collect();
                Credit::of_nodes(&graph, &penalized, (0..zones * nodes).map(weight).collect())
            }
        };
        Scene { environment, step, graph, credit: Arc::new(credit) }
    };
    let mut rollout = Rollout {
        environments: 2,
        steps,
        observations: draw(2 * steps * 7),
        actions: draw(2 * steps * 3),
        rewards: draw(2 * steps * widths.parts),
        next: draw(2 * 7),
        ends: vec![End { environment: 1, step: 5, observation: draw(7) }],
        scenes: vec![scene(0, 0, 1), scene(1, 0, 3), scene(1, 6, 2)],
        ..Rollout::default()
    };
    rollout.clear_padding(widths);
    rollout
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads_and_after_a_restart() {
    for log_std in [LogStd::Free, LogStd::OfState] {
        let run = |threads: usize| {
            let config = PpoConfig { batch_size: 300, ..config(log_std) };
            let mut ppo = Ppo::of_graphs((&network(), 1), WIDTHS, config, true, 3).unwrap();
            ppo.set_threads(threads);
            (0..2).for_each(|seed| assert_eq!(ppo.update(&rollout(150, seed)).unwrap().skipped, 0));
            ppo.state()
        };
        assert!(run(1) == run(4));
        let mut ppo = learner(log_std, 3);
        ppo.update(&rollout(20, 0)).unwrap();
        let mut restored = learner(log_std, 8);
        restored.restore(&State::from_bytes(&ppo.state().to_bytes()).unwrap()).unwrap();
        assert_eq!(ppo.update(&rollout(20, 1)).unwrap(), restored.update(&rollout(20, 1)).unwrap());
        assert!(ppo.state() == restored.state() && ppo.actor() == restored.actor());
        assert_eq!(restored.seen_types(), [0, 1]);
    }
}

#[test]
fn features_are_normalized_over_all_nodes_of_a_type() {
    let mut ppo = learner(LogStd::Free, 3);
    assert_eq!(ppo.seen_types(), Vec::<usize>::new());
    let mut shifted = rollout(200, 0);
    // The features of zones alternate in every row, followed by the last node's feature.
    for row in 0..400 {
        let zones = shifted.scenes[shifted.scene_of(row / 200, row % 200)].graph.nodes() - 1;
        let row = &mut shifted.observations[row * 7..][..2 * zones];
        row.iter_mut().step_by(2).for_each(|value| *value = 3.0 + 2.0 * *value);
    }
    ppo.update(&shifted).unwrap();
    for (place, mean, scale) in ppo.networks.feature_places()[0].clone().map(|place| {
        let of = |range: std::ops::Range<usize>| ppo.parameters[range].to_vec();
        (place.clone(), of(place.mean), of(place.scale))
    }) {
        assert!((mean[0] - 3.0).abs() < 0.2 && mean[1].abs() < 0.2, "{place:?}: {mean:?}");
        assert!((scale[0] - 0.5).abs() < 0.05 && (scale[1] - 1.0).abs() < 0.1, "{scale:?}");
    }
}

/// Sets the states of the nodes before a row that begins a sequence or forgets.
fn begin(batch: &Minibatch<'_>, row: usize, network: usize, states: &mut Tokens) {
    let (networks, nodes) = (batch.networks, batch.graphs[batch.samples.scenes[row]].nodes());
    let (length, stride) = (networks.sequence, networks.states()[network]);
    if stride == 0 {
        return;
    }
    if batch.samples.starts[row] {
        *states = vec![vec![0.0; MEMORY]; nodes];
    } else if row.is_multiple_of(length) {
        let given = &batch.samples.states[network][row / length * stride..];
        *states = given.chunks(MEMORY).take(nodes).map(wide).collect();
    }
}

/// Returns the loss of a minibatch in double precision.
fn loss(batch: &Minibatch<'_>, parameters: &[f64]) -> f64 {
    let Minibatch { networks, samples, config, .. } = batch;
    let [actor, critic] = [&networks.actor, &networks.critic].map(|shape| shape.graph().unwrap());
    let mut sum = 0.0;
    let mut states = [Vec::new(), Vec::new()];
    for row in 0..batch.rows {
        let graph = &batch.graphs[samples.scenes[row]];
        states.iter_mut().enumerate().for_each(|(network, states)| begin(batch, row, network, states));
        let input = wide(&samples.observations[row * 7..][..graph.width()]);
        let of_actor = &parameters[networks.actors()];
        let outputs = reference::forward(actor, of_actor, graph, &input, &mut states[ACTOR]);
        let credit = &batch.credits[samples.scenes[row]];
        let mut log_densities = vec![0.0; credit.groups()];
        let mut log_stds = 0.0;
        for (action, place) in graph.actions.iter().enumerate() {
            let log_std = match networks.of_state() {
                true => outputs[place.node][1],
                false => parameters[networks.log_stds()][place.number],
            };
            let taken = f64::from(samples.actions[row * 3 + action]);
            let normal = (taken - outputs[place.node][0]) / log_std.exp();
            let group = if networks.is_by_node() { action } else { 0 };
            log_densities[group] += -0.5 * normal * normal - log_std - 0.5 * std::f64::consts::TAU.ln();
            log_stds += log_std;
        }
        for (group, log_density) in log_densities.into_iter().enumerate() {
            let at = row * batch.groups + group;
            let ratio = (log_density - f64::from(samples.old[at])).exp();
            let advantage = f64::from(samples.advantages[at]);
            sum -= (advantage * ratio).min(advantage * ratio.clamp(0.8, 1.2));
        }
        sum -= f64::from(config.entropy_coefficient) * log_stds;
        let of_critic = &parameters[networks.critics()];
        let values = reference::forward(critic, of_critic, graph, &input, &mut states[CRITIC]);
        let returns = &samples.returns[row * networks.widths.parts..];
        let error = |(node, target): (&Vec<f64>, &f32)| (node[0] - f64::from(*target)).powi(2);
        sum += 0.5
            * match networks.is_by_node() {
                true => values.iter().zip(returns).map(error).sum::<f64>() / values.len() as f64,
                false => {
                    let value = values.iter().map(|node| node[0]).sum::<f64>() / values.len() as f64;
                    (value - f64::from(returns[0])).powi(2)
                }
            };
    }
    sum / batch.rows as f64
}

#[test]
fn gradients_of_all_parameters_match_finite_differences() {
    let cases = [
        (LogStd::Free, WIDTHS, false),
        (LogStd::OfState, WIDTHS, false),
        (LogStd::Free, BY_NODE, false),
        (LogStd::OfState, BY_NODE, true),
    ];
    for (log_std, widths, remembers) in cases {
        let mut ppo = match remembers {
            true => remembering(widths, config(log_std), 3),
            false => Ppo::of_graphs((&network(), 1), widths, config(log_std), true, 3).unwrap(),
        };
        ppo.prepare_for_test(&match remembers {
            true => remembered(widths, 20, 0),
            false => rollout_of(widths, 20, 0),
        });
        let mut worker = Worker::new(&ppo.networks);
        let batch = Minibatch {
            config: &ppo.config,
            networks: &ppo.networks,
            credits: &ppo.credits,
            groups: ppo.groups,
            parameters: &ppo.parameters,
            samples: &ppo.samples,
            graphs: &ppo.graphs,
            rows: 40,
            critic_only: false,
        };
        // More rows than are passed at a time.
        worker.learn(&batch, 0..40);
        let all = wide(&ppo.parameters);
        let fixed: Vec<std::ops::Range<usize>> = ppo
            .networks
            .feature_places()
            .into_iter()
            .flatten()
            .map(|place| place.mean.start..place.scale.end)
            .collect();
        let learned: Vec<usize> =
            (0..all.len()).filter(|place| !fixed.iter().any(|range| range.contains(place))).collect();
        let gradients: Vec<f32> = learned.iter().map(|place| worker.gradients[*place]).collect();
        let start: Vec<f64> = learned.iter().map(|place| all[*place]).collect();
        assert_gradients(&start, &gradients, |moved| {
            let mut parameters = all.clone();
            learned.iter().zip(moved).for_each(|(place, value)| parameters[*place] = *value);
            loss(&batch, &parameters)
        });
    }
}

#[test]
fn actions_learn_from_the_rewards_of_their_own_nodes_and_of_nodes_that_count_for_all() {
    let config = PpoConfig { normalize_values: false, ..config(LogStd::Free) };
    let advantages = |changed: Option<usize>| {
        let mut ppo = Ppo::of_graphs((&network(), 1), BY_NODE, config.clone(), true, 3).unwrap();
        let mut rollout = rollout_of(BY_NODE, 20, 0);
        // A step of the second environment, in the building of three zones.
        changed.into_iter().for_each(|node| rollout.rewards[(20 + 2) * 4 + node] += 1.0);
        ppo.prepare(&rollout);
        ppo.samples.advantages[(20 + 2) * 3..][..3].to_vec()
    };
    let before = advantages(None);
    let gains = |node: usize| -> Vec<f32> {
        advantages(Some(node)).iter().zip(&before).map(|(after, before)| (after - before).round()).collect()
    };
    assert_eq!(gains(1), [0.0, 1.0, 0.0]);
    assert_eq!(gains(3), [1.0, 1.0, 1.0]);
}

#[test]
fn values_of_nodes_stay_as_they_are_when_their_scale_changes() {
    let mut ppo = Ppo::of_graphs((&network(), 1), BY_NODE, config(LogStd::Free), false, 3).unwrap();
    let mut shifted = rollout_of(BY_NODE, 20, 0);
    shifted.rewards.iter_mut().for_each(|reward| *reward = 5.0 * *reward - 40.0);
    ppo.prepare(&shifted);
    let values = |ppo: &mut Ppo, rollout: &Rollout| -> Vec<f32> {
        let values = ppo.evaluate(rollout).steps;
        // In a building with one zone, two parts are padding.
        assert!(values[..20 * 4].chunks(4).all(|row| row[2..] == [0.0; 2]));
        values
    };
    let before = values(&mut ppo, &shifted);
    assert!(before.iter().any(|value| *value != 0.0));
    shifted.rewards.iter_mut().for_each(|reward| *reward *= 3.0);
    ppo.prepare(&shifted);
    let after = values(&mut ppo, &shifted);
    assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 1e-4));
}

#[test]
fn options_of_flat_networks_are_errors() {
    let said = |config| Ppo::of_graphs((&network(), 1), WIDTHS, config, true, 0).unwrap_err().to_string();
    let credit = PpoConfig { credit: Some(vec![vec![1.0]; 3]), ..config(LogStd::Free) };
    assert!(said(credit).contains("`credit` is a matrix"));
    let normalizing = PpoConfig { normalize_observations: true, ..config(LogStd::Free) };
    let expected = "`normalize_observations` is true; graph networks have `policy.normalize`";
    assert_eq!(said(normalizing), expected);
}

const MEMORY: usize = 3;

/// Returns a learner with a memory, and sequences of five steps.
fn remembering(widths: Widths, config: PpoConfig, seed: u64) -> Ppo {
    let network = GraphNetwork { memory: MEMORY, ..network() };
    Ppo::of_graphs((&network, 5), widths, config, true, seed).unwrap()
}

/// Returns random steps of an actor that forgets before the first step of the first environment, and where the second
/// changes its building.
fn remembered(widths: Widths, steps: usize, seed: u64) -> Rollout {
    let mut states = vec![0.0; 2 * widths.nodes * MEMORY];
    RandomStream::new(seed, 2).normals(&mut states);
    Rollout { states, starts: vec![(0, 0), (1, 6)], ..rollout_of(widths, steps, seed) }
}

/// Returns the outputs of the nodes of a building in a step, and replaces their states by the next ones.
fn pass(
    network: &GraphNetwork,
    parameters: &[f32],
    graph: &Arc<Graph>,
    observation: &[f32],
    state: &mut [f32],
) -> Vec<Vec<f32>> {
    let (mut tape, batch) = (Tape::default(), Batch::of_one(graph, &observation[..graph.width()]));
    tape.forward(network, &network.places(), parameters, batch, state, Layer::forward_rows);
    (0..graph.nodes()).map(|node| tape.outputs_of(network, 0, node).to_vec()).collect()
}

#[test]
fn sequences_have_the_densities_and_values_of_single_steps() {
    let rollout = remembered(WIDTHS, 20, 0);
    let mut ppo = remembering(WIDTHS, PpoConfig { normalize_values: false, ..config(LogStd::Free) }, 3);
    ppo.prepare(&rollout);
    ppo.critic_states.fill(0.0);
    let values = ppo.evaluate(&rollout);
    let [actor, critic] = [&ppo.networks.actor, &ppo.networks.critic].map(|shape| shape.graph().unwrap());
    let [of_actor, of_critic] =
        [ppo.networks.actors(), ppo.networks.critics()].map(|range| &ppo.parameters[range]);
    let value = |graph: &Arc<Graph>, observation: &[f32], state: &mut [f32]| {
        let outputs = pass(critic, of_critic, graph, observation, state);
        outputs.iter().map(|node| node[0]).sum::<f32>() / outputs.len() as f32
    };
    let near = |one: f32, other: f32| (one - other).abs() < 1e-4 * (1.0 + other.abs());
    for environment in 0..2 {
        let mut states = [Vec::new(), Vec::new()];
        for step in 0..20 {
            let scene = rollout.scene_of(environment, step);
            let (graph, row) = (&rollout.scenes[scene].graph, environment * 20 + step);
            let numbers = graph.nodes() * MEMORY;
            if step == 0 {
                let first = &rollout.states[environment * WIDTHS.nodes * MEMORY..][..numbers];
                states = [first.to_vec(), vec![0.0; numbers]];
            }
            if rollout.starts.contains(&(environment, step)) {
                states = [vec![0.0; numbers], vec![0.0; numbers]];
            }
            let observation = &rollout.observations[row * 7..][..7];
            let outputs = pass(actor, of_actor, graph, observation, &mut states[0]);
            let mean: Vec<f32> =
                graph.actions.iter().map(|place| outputs[place.node][place.output]).collect();
            let (action, log_std) = (&rollout.actions[row * 3..][..mean.len()], vec![-0.3; mean.len()]);
            let density = super::loss::group_log_density(&ppo.credits[scene], 0, action, &mean, &log_std);
            assert!(near(ppo.samples.old[row * ppo.groups], density), "row {row}");
            assert!(near(values.steps[row], value(graph, observation, &mut states[1])), "row {row}");
            if (environment, step) == (1, 5) {
                let end = value(graph, &rollout.ends[0].observation, &mut states[1].clone());
                assert!(near(values.ends[0], end));
            }
        }
        let graph = &rollout.scenes[rollout.scene_of(environment, 19)].graph;
        let kept = &ppo.critic_states[environment * WIDTHS.nodes * MEMORY..];
        assert!(kept.iter().zip(&states[1]).all(|(kept, state)| near(*kept, *state)));
        let next = value(graph, &rollout.next[environment * 7..][..7], &mut states[1]);
        assert!(near(values.next[environment], next));
    }
}

#[test]
fn networks_with_a_memory_learn_the_same_bits_on_any_number_of_threads_and_after_a_restart() {
    let config = PpoConfig { batch_size: 320, ..config(LogStd::OfState) };
    let learned = |threads: usize| {
        let mut ppo = remembering(BY_NODE, config.clone(), 3);
        ppo.set_threads(threads);
        assert_eq!(ppo.update(&remembered(BY_NODE, 160, 0)).unwrap().skipped, 0);
        ppo
    };
    let mut first = learned(1);
    assert!(first.state() == learned(3).state());
    let mut restored = remembering(BY_NODE, config.clone(), 8);
    restored.restore(&State::from_bytes(&first.state().to_bytes()).unwrap()).unwrap();
    let again = |ppo: &mut Ppo| (ppo.update(&remembered(BY_NODE, 160, 1)).unwrap(), ppo.state());
    assert!(again(&mut first) == again(&mut restored));
}
