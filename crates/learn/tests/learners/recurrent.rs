//! Learning of a toy environment with a hidden context by recurrent PPO.

use std::sync::Arc;

use b2b_agent::Agent;
use b2b_agent::network::graph::{ActionPlace, NodeWidths};
use b2b_agent::network::{Activation, Edges, Graph, GraphNetwork};
use b2b_learn::collector::Collector;
use b2b_learn::learner::Learner as _;
use b2b_learn::ppo::{Ppo, PpoConfig};
use b2b_learn::rollout::{Rollout, Widths};
use b2b_learn::train::{RecurrentPolicy, TrainConfig};

use super::ppo::evaluate_in;
use super::random_search::run;
use super::toy::{Hidden, Local, Toy};

const ENVIRONMENTS: usize = 16;
const UPDATES: usize = 60;

fn config() -> PpoConfig {
    PpoConfig {
        learning_rate: 3e-3,
        n_steps: 2 * Hidden::<false>::STEPS,
        batch_size: 160,
        gamma: 0.95,
        actor_hidden: vec![16],
        critic_hidden: vec![16],
        initial_log_std: -0.5,
        ..PpoConfig::default()
    }
}

/// Returns the mean return without exploration after the updates of a learner of these widths, in a building for graph
/// networks.
fn train<const SEEN: bool>(
    graphs: &[Arc<Graph>],
    seed: u64,
    learner: impl Fn(Widths) -> b2b_learn::Result<Ppo>,
) -> f64 {
    let mut collector = Local::<Hidden<SEEN>>::new(ENVIRONMENTS, seed).with_graphs(graphs.to_vec());
    let mut ppo = learner(collector.widths()).unwrap();
    let mut rollout = Rollout::default();
    for _ in 0..UPDATES {
        collector.collect(&ppo.actor(), config().n_steps, &mut rollout).unwrap();
        assert_eq!(ppo.update(&rollout).unwrap().skipped, 0);
    }
    evaluate_in::<Hidden<SEEN>>(&ppo.actor(), graphs.last())
}

#[test]
fn memory_reaches_the_return_of_a_context_in_sight_and_no_memory_does_not() {
    // With sequences of 10 steps, half of an episode depends on what the sequence before showed.
    for (sequence, seed) in [(20, 0), (10, 2)] {
        let policy = RecurrentPolicy { width: 16, sequence, ..RecurrentPolicy::default() };
        let flat = |widths| Ppo::new(widths, config(), seed);
        let (seen, without) = (train::<true>(&[], seed, flat), train::<false>(&[], seed, flat));
        let with = train::<false>(&[], seed, |widths| Ppo::recurrent(&policy, widths, config(), seed));
        println!("sequences of {sequence}: seen {seen:.1}, memory {with:.1}, no memory {without:.1}");
        assert!(seen > 19.0 && with > seen - 2.0 && without < 5.0, "{seen} {with} {without}");
    }
}

/// Returns a building of a node that acts and of others that only take part in attention.
fn building(others: usize) -> Arc<Graph> {
    let nodes = 1 + others;
    Arc::new(Graph {
        names: (0..nodes).map(|node| format!("node {node}")).collect(),
        types: (0..nodes).map(|node| node.min(1)).collect(),
        features: std::iter::once(0).chain(std::iter::repeat_n(3, nodes)).collect(),
        actions: vec![ActionPlace { node: 0, output: 0, number: 0 }],
        relations: vec![0; nodes * nodes],
    })
}

#[test]
fn a_memory_of_nodes_reaches_the_return_of_a_context_in_sight_in_buildings_of_two_sizes() {
    let graphs = [building(1), building(3)];
    let network = |memory| GraphNetwork {
        types: vec![NodeWidths { features: 3, outputs: 1 }, NodeWidths { features: 0, outputs: 0 }],
        embedding: 16,
        heads: 2,
        layers: 1,
        feed_forward: 16,
        activation: Activation::Tanh,
        edges: Edges::None,
        memory,
    };
    let of = |memory: usize, sequence: usize| {
        move |widths| Ppo::of_graphs((&network(memory), sequence), widths, config(), true, 0)
    };
    let (seen, without) = (train::<true>(&graphs, 0, of(0, 1)), train::<false>(&graphs, 0, of(0, 1)));
    let with = [20, 10].map(|sequence| train::<false>(&graphs, 0, of(16, sequence)));
    println!("seen {seen:.1}, memory {with:.1?} with sequences of 20 and 10, no memory {without:.1}");
    assert!(seen > 18.5 && with.iter().all(|with| *with > seen - 2.0) && without < 5.0);
}

const OPTIONS: &str = "
    buildings = ['SingleFamilyHouse-0014']
    period = '01-10..01-11'
    environments = 2
    window_days = 0
    steps = 1728
    mirrored_noise = false
    evaluation = { every = 0, whole_period = false }
    ppo = { n_steps = 144, batch_size = 96 }";

/// Asserts that a run ends with the same weights if it is resumed twice, and returns the agent.
fn assert_resumes(preset: &str, policy: &str) -> Agent {
    let config = TrainConfig::preset(preset).unwrap();
    let config = config.with_changes(&format!("policy = {policy}\n{OPTIONS}")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    run(&config, &whole);
    // The first episode ends after 576 steps of each environment, in the middle of the second part.
    for steps in [288, 1440] {
        run(&config.with_changes(&format!("steps = {steps}")).unwrap(), &parts);
    }
    run(&config, &parts);
    let [whole, parts] = [whole, parts].map(|folder| Agent::read(&folder).unwrap());
    assert_eq!(whole.info().training.steps, 1728);
    assert_eq!(whole.info().weights, parts.info().weights);
    whole
}

#[test]
fn a_run_that_is_resumed_in_the_middle_of_an_episode_learns_the_same_weights() {
    let agent =
        assert_resumes("recurrent", "{ kind = 'recurrent', width = 16, sequence = 48, memory_episodes = 2 }");
    assert!(agent.actor().shape.recurrent().is_some() && agent.info().interface.observation.feedback);
    let sizes = "embedding = 16, heads = 2, layers = 1, feed_forward = 16";
    let agent =
        assert_resumes("graph", &format!("{{ kind = 'graph', {sizes}, memory = 8, memory_episodes = 2 }}"));
    assert_eq!(agent.actor().shape.state(), 8);
}

#[test]
fn the_steps_of_a_rollout_must_be_whole_sequences() {
    let widths = Hidden::<false>::WIDTHS;
    let policy = RecurrentPolicy { sequence: 12, ..RecurrentPolicy::default() };
    let said = Ppo::recurrent(&policy, widths, config(), 0).unwrap_err().to_string();
    assert!(said.contains("`ppo.n_steps` is 40; expected a multiple of `policy.sequence`, 12"), "{said}");
    let policy = RecurrentPolicy { width: 8, sequence: 20, ..RecurrentPolicy::default() };
    let mut ppo = Ppo::recurrent(&policy, widths, config(), 0).unwrap();
    let mut rollout = Rollout::default();
    let flat = Ppo::new(widths, config(), 0).unwrap().actor();
    Local::<Hidden<false>>::new(2, 0).collect(&flat, 40, &mut rollout).unwrap();
    let said = ppo.update(&rollout).unwrap_err().to_string();
    assert!(said.contains("states"), "{said}");
}
