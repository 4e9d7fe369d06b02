use b2b_agent::network::Activation;
use b2b_agent::network::graph::{ActionPlace, Edges, NodeWidths};

use super::worker::Minibatch;
use super::*;
use crate::nn::graph::reference;
use crate::nn::reference::{assert_gradients, wide};
use crate::rollout::{End, Rollout, Scene};

/// The largest building has three zones of two features and one action, and a node of one feature without actions.
const WIDTHS: Widths = Widths { observation: 7, action: 3, parts: 1 };

fn network() -> GraphNetwork {
    GraphNetwork {
        types: vec![NodeWidths { features: 2, outputs: 1 }, NodeWidths { features: 1, outputs: 0 }],
        embedding: 8,
        heads: 2,
        layers: 1,
        feed_forward: 6,
        activation: Activation::Tanh,
        edges: Edges::None,
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
    Ppo::of_graphs(&network(), WIDTHS, config(log_std), true, seed).unwrap()
}

/// Returns random steps of two environments, the second of which goes from a building of three zones to one of two.
fn rollout(steps: usize, seed: u64) -> Rollout {
    let mut random = Random::new(seed, 1);
    let mut draw = |count: usize| {
        let mut values = vec![0.0; count];
        random.normals(&mut values);
        values
    };
    let scene = |environment, step, zones| Scene { environment, step, graph: building(zones) };
    let mut rollout = Rollout {
        environments: 2,
        steps,
        observations: draw(2 * steps * 7),
        actions: draw(2 * steps * 3),
        rewards: draw(2 * steps),
        next: draw(2 * 7),
        ends: vec![End { environment: 1, step: 5, observation: draw(7) }],
        scenes: vec![scene(0, 0, 1), scene(1, 0, 3), scene(1, 6, 2)],
    };
    rollout.clear_padding(WIDTHS);
    rollout
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads_and_after_a_restart() {
    for log_std in [LogStd::Free, LogStd::OfState] {
        let run = |threads: usize| {
            let config = PpoConfig { batch_size: 300, ..config(log_std) };
            let mut ppo = Ppo::of_graphs(&network(), WIDTHS, config, true, 3).unwrap();
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
    // The features of zones alternate in every row, before that of the last node.
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

/// Returns the loss of a minibatch in double precision.
fn loss(batch: &Minibatch<'_>, parameters: &[f64]) -> f64 {
    let Minibatch { networks, samples, config, .. } = batch;
    let [actor, critic] = [&networks.actor, &networks.critic].map(|shape| shape.graph().unwrap());
    let mut sum = 0.0;
    for row in 0..batch.rows {
        let graph = &batch.graphs[samples.scenes[row]];
        let input = wide(&samples.observations[row * 7..][..graph.width()]);
        let outputs = reference::forward(actor, &parameters[networks.actors()], graph, &input);
        let mut log_density = 0.0;
        let mut log_stds = 0.0;
        for (action, place) in graph.actions.iter().enumerate() {
            let log_std = match networks.of_state() {
                true => outputs[place.node][1],
                false => parameters[networks.log_stds()][place.number],
            };
            let taken = f64::from(samples.actions[row * 3 + action]);
            let normal = (taken - outputs[place.node][0]) / log_std.exp();
            log_density += -0.5 * normal * normal - log_std - 0.5 * std::f64::consts::TAU.ln();
            log_stds += log_std;
        }
        let ratio = (log_density - f64::from(samples.old[row])).exp();
        let advantage = f64::from(samples.advantages[row]);
        sum -= (advantage * ratio).min(advantage * ratio.clamp(0.8, 1.2));
        sum -= f64::from(config.entropy_coefficient) * log_stds;
        let values = reference::forward(critic, &parameters[networks.critics()], graph, &input);
        let value = values.iter().map(|node| node[0]).sum::<f64>() / values.len() as f64;
        sum += 0.5 * (value - f64::from(samples.returns[row])).powi(2);
    }
    sum / batch.rows as f64
}

#[test]
fn gradients_of_all_parameters_are_those_of_finite_differences() {
    for log_std in [LogStd::Free, LogStd::OfState] {
        let mut ppo = learner(log_std, 3);
        let rollout = rollout(20, 0);
        ppo.graphs = rollout.scenes.iter().map(|scene| Arc::clone(&scene.graph)).collect();
        ppo.prepare_for_test(&rollout);
        let mut worker = Worker::new(&ppo.networks);
        let batch = Minibatch {
            config: &ppo.config,
            networks: &ppo.networks,
            credit: &ppo.credit,
            parameters: &ppo.parameters,
            samples: &ppo.samples,
            graphs: &ppo.graphs,
            rows: 40,
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
fn a_reward_in_parts_is_an_error() {
    let widths = Widths { parts: 2, ..WIDTHS };
    let error = Ppo::of_graphs(&network(), widths, config(LogStd::Free), true, 0).unwrap_err();
    assert!(error.to_string().contains("`parts` is 2"), "{error}");
}
