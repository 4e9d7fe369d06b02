//! Collectors in worker processes, on the real engine.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use b2b_agent::network::{Activation, Actor, Distribution, Edges, GraphNetwork};
use b2b_agent::{
    Acting, AgentController, Interface, NodeForm, NodeSpaces, ObservationForm, ObservationOptions, Pilot,
};
use b2b_building::BuildingType;
use b2b_control::{Controller, Guideline36, Guideline36Parameters};
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, EpisodeConfig, Task, rollout as run_episode};
use b2b_learn::collector::Collector;
use b2b_learn::fragments::FragmentCollector;
use b2b_learn::learner::Learner as _;
use b2b_learn::lockstep::LockstepCollector;
use b2b_learn::ppo::{Ppo, PpoConfig};
use b2b_learn::rollout::{Rollout, Widths};
use b2b_learn::state::State;
use b2b_learn::train::RecurrentPolicy;
use b2b_workers::{Autoreset, EpisodeSetting, Fixed, Launcher, Source, VecEnv, VecEnvOptions, WorkerOptions};
use rustix::process::{Pid, Signal, kill_process};

const ENVIRONMENTS: usize = 3;
const STEPS_PER_HOUR: u32 = 4;
/// Steps of an episode of one day.
const DAY: usize = 96;
/// Steps of a rollout: the episode ends within the third.
const STEPS: usize = 34;
const SEED: u64 = 7;
/// Width of the state of recurrent networks.
const WIDTH: usize = 12;
const DIRECT: Interface = Interface {
    observation: ObservationOptions {
        form: ObservationForm::Raw,
        attributes: false,
        forecast: 0,
        feedback: false,
    },
    acting: Acting::Direct,
    nodes: None,
};
const RESIDUAL: Interface = Interface {
    observation: ObservationOptions {
        form: ObservationForm::Features,
        attributes: true,
        forecast: 2,
        feedback: false,
    },
    acting: Acting::Residual { authority: 0.5 },
    nodes: None,
};

/// A supervisor that decides every hour.
const SUPERVISORY: Interface = Interface {
    observation: ObservationOptions {
        form: ObservationForm::Features,
        attributes: false,
        forecast: 0,
        feedback: false,
    },
    acting: Acting::Supervisory { every: 60, shared: true, setpoints: true, rule: false },
    nodes: None,
};

/// Recurrent networks, which observe their rewards.
const RECURRENT: Interface = Interface {
    observation: ObservationOptions {
        form: ObservationForm::Raw,
        attributes: false,
        forecast: 0,
        feedback: true,
    },
    ..DIRECT
};

/// Graph networks of houses and offices.
const GRAPH: Interface = Interface { nodes: Some(NodeForm { attributes: true }), ..RESIDUAL };

/// Graph networks of houses and offices with a memory, which observe their rewards.
const REMEMBERING_GRAPH: Interface = Interface {
    observation: ObservationOptions { feedback: true, ..RESIDUAL.observation },
    nodes: Some(NodeForm { attributes: false }),
    ..RESIDUAL
};

/// Graph networks that supervise houses and offices.
const GRAPH_SUPERVISORY: Interface = Interface { nodes: Some(NodeForm { attributes: true }), ..SUPERVISORY };

/// Returns environments of a house on a winter day; for graph networks, the second is a small office.
fn environments(interface: Interface) -> VecEnv {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let setting = |building_type| {
        let name = BuildingName::Type(building_type);
        let found = catalog.find(&name, &Placement::default(), &mut Quiet).unwrap();
        let episode = episode(interface, found.weather.clone());
        EpisodeSetting::new(Source::from(found), episode)
    };
    let types: &[BuildingType] = match interface.nodes {
        None => &[BuildingType::SingleFamilyHouse],
        Some(_) => &[BuildingType::SingleFamilyHouse, BuildingType::OfficeSmall],
    };
    let sampler = Fixed(types.iter().copied().map(setting).collect());
    let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b-learn-worker"));
    let workers = WorkerOptions::new(launcher, catalog.library().path());
    let options = VecEnvOptions { workers, autoreset: Autoreset::Disabled, widths: None };
    VecEnv::new(ENVIRONMENTS, Box::new(sampler), options).unwrap()
}

/// Returns the house of the environments in this process.
fn house(interface: Interface) -> Env {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let name = BuildingName::Type(BuildingType::SingleFamilyHouse);
    let found = catalog.find(&name, &Placement::default(), &mut Quiet).unwrap();
    let episode = episode(interface, found.weather.clone());
    let building = Arc::new(found.prepare(catalog.library()).unwrap());
    Env::new(catalog.library().clone(), building, episode).unwrap()
}

/// Returns a winter day.
fn episode(interface: Interface, weather: PathBuf) -> EpisodeConfig {
    let task = match interface.acting {
        Acting::Supervisory { .. } => "operate".parse().unwrap(),
        _ => Task::default(),
    };
    EpisodeConfig { weather, period: "01-10..01-10".parse().unwrap(), steps_per_hour: STEPS_PER_HOUR, task }
}

fn fragments(interface: Interface, correlation: f32) -> FragmentCollector {
    fragments_with(interface, false, correlation, 0.0)
}

fn fragments_with(
    interface: Interface,
    by_zone: bool,
    correlation: f32,
    travel_cost: f32,
) -> FragmentCollector {
    let scale = Box::new(|_: &_| Ok(0.3));
    let environments = environments(interface);
    FragmentCollector::new(environments, interface, by_zone, correlation, travel_cost, scale, SEED).unwrap()
}

fn lockstep(interface: Interface, correlation: f32) -> LockstepCollector {
    LockstepCollector::new(environments(interface), interface, correlation, Box::new(|_: &_| Ok(0.3)), SEED)
        .unwrap()
}

/// Returns an actor that differs for every seed.
fn actor(widths: Widths, interface: Interface, seed: u64) -> Actor {
    let config = PpoConfig { actor_hidden: vec![16], critic_hidden: vec![16], ..PpoConfig::default() };
    if interface.nodes.is_none() && interface.observation.feedback {
        let policy = RecurrentPolicy { width: WIDTH, ..RecurrentPolicy::default() };
        let config = PpoConfig { n_steps: policy.sequence, ..config };
        return Ppo::recurrent(&policy, widths, config, seed).unwrap().actor();
    }
    if interface.nodes.is_none() {
        return Ppo::new(widths, config, seed).unwrap().actor();
    }
    let network = GraphNetwork {
        types: NodeSpaces::of(interface).widths(),
        embedding: 16,
        heads: 2,
        layers: 2,
        feed_forward: 16,
        activation: Activation::Relu,
        edges: Edges::Mixed,
        memory: if interface == REMEMBERING_GRAPH { WIDTH } else { 0 },
    };
    Ppo::of_graphs((&network, 2), widths, config, true, seed).unwrap().actor()
}

/// Collects the rollouts with these numbers, each with its own actor.
fn rollouts(
    collector: &mut dyn Collector,
    interface: Interface,
    numbers: std::ops::RangeInclusive<u64>,
    steps: usize,
) -> Vec<Rollout> {
    let mut collect = |number| {
        let mut rollout = Rollout::default();
        let widths = collector.widths();
        collector.collect(&actor(widths, interface, number), steps, &mut rollout).unwrap();
        rollout.check(widths).unwrap();
        rollout
    };
    numbers.map(&mut collect).collect()
}

#[test]
fn fragments_and_lockstep_collect_the_same_bits() {
    // With 32 steps, the episode ends on the last step of the third rollout.
    for (interface, steps) in [
        (DIRECT, 32),
        (RESIDUAL, STEPS),
        (RECURRENT, 32),
        (RECURRENT, STEPS),
        (GRAPH, STEPS),
        (REMEMBERING_GRAPH, 32),
    ] {
        let ours = rollouts(&mut fragments(interface, 0.4), interface, 1..=4, steps);
        let theirs = rollouts(&mut lockstep(interface, 0.4), interface, 1..=4, steps);
        let ends = |rollouts: &[Rollout]| rollouts.iter().map(|each| each.ends.len()).collect::<Vec<_>>();
        assert_eq!(ends(&ours), [0, 0, ENVIRONMENTS, 0]);
        assert_eq!(ours[2].ends[0].step, DAY - 2 * steps - 1);
        for (number, (one, other)) in ours.iter().zip(&theirs).enumerate() {
            assert!(one == other, "rollout {number} of {steps} steps with {interface:?}");
            assert_scenes(one, interface);
        }
    }
}

#[test]
fn a_memory_of_two_episodes_is_the_same_bits_in_fragments_and_lockstep_and_after_a_restoration() {
    [RECURRENT, REMEMBERING_GRAPH].into_iter().for_each(assert_a_memory_of_two_episodes);
}

fn assert_a_memory_of_two_episodes(interface: Interface) {
    let numbers = 1..=9;
    let with = |collector: &mut dyn Collector| rollouts(collector, interface, numbers.clone(), STEPS);
    let mut fragments_of_two = fragments(interface, 0.4).with_memory_episodes(2);
    let all = with(&mut fragments_of_two);
    assert!(all == with(&mut lockstep(interface, 0.4).with_memory_episodes(2)));
    // Episodes of 96 steps end in rollouts of 34 steps after 96, 192 and 288 steps: the memory begins anew after the
    // second.
    let starts = |rollouts: &[Rollout]| -> Vec<(usize, usize)> {
        let of_first = |(number, each): (usize, &Rollout)| {
            let own = each.starts.iter().filter(|start| start.0 == 0);
            own.map(move |start| (number, start.1)).collect::<Vec<_>>()
        };
        rollouts.iter().enumerate().flat_map(of_first).collect()
    };
    assert_eq!(starts(&all), [(0, 0), (5, 22)]);
    let one = with(&mut fragments(interface, 0.4));
    assert_eq!(starts(&one), [(0, 0), (2, 28), (5, 22), (8, 16)]);
    assert!(one[..2] == all[..2] && one[2] != all[2]);
    let width = fragments_of_two.widths().nodes * WIDTH;
    assert!(all.iter().all(|each| each.states.len() == ENVIRONMENTS * width));
    assert!(all[2..].iter().all(|each| each.states.iter().any(|value| *value != 0.0)));
    // In the middle of the second episode of a memory.
    let mut whole = fragments(interface, 0.4).with_memory_episodes(2);
    rollouts(&mut whole, interface, 1..=4, STEPS);
    let mut restored = fragments(interface, 0.4).with_memory_episodes(2);
    let any = actor(restored.widths(), interface, 0);
    restored.restore(&State::from_bytes(&whole.state().to_bytes()).unwrap(), &any).unwrap();
    assert!(restored.state() == whole.state());
    assert!(rollouts(&mut restored, interface, 5..=9, STEPS) == all[4..]);
}

/// The controller of an agent, with its actions.
struct Recorded {
    controller: AgentController,
    actions: Vec<Vec<f64>>,
}

impl Controller for Recorded {
    fn reset(&mut self) {
        self.controller.reset();
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        self.controller.act(observation, action);
        self.actions.push(action.to_vec());
    }

    fn reward(&mut self, reward: f64) {
        self.controller.reward(reward);
    }
}

/// Without exploration, fragments make the steps of the agent's controller, which observes its rewards too.
#[test]
fn training_and_evaluation_act_and_remember_alike() {
    let form = ObservationForm::Features;
    let features =
        Interface { observation: ObservationOptions { form, ..RECURRENT.observation }, ..RECURRENT };
    let supervisory = Interface { acting: SUPERVISORY.acting, ..features };
    for (interface, hold) in [(RECURRENT, 1), (supervisory, 4), (REMEMBERING_GRAPH, 1)] {
        let mut collector = fragments(interface, 0.0);
        let width = collector.widths().action;
        let mut quiet = actor(collector.widths(), interface, 1);
        let Distribution::Gaussian { log_std } = &mut quiet.distribution else { panic!("a Gaussian") };
        log_std.fill(-80.0);
        let quiet = Arc::new(quiet);
        let mut rollout = Rollout::default();
        collector.collect(&quiet, DAY / hold, &mut rollout).unwrap();
        let mut env = house(interface);
        let mut pilot = Pilot::new(interface, env.spaces()).unwrap();
        let controller = AgentController::new(pilot.clone(), quiet);
        let mut recorded = Recorded { controller, actions: Vec::new() };
        run_episode(&mut env, &mut recorded, &mut ()).unwrap();
        assert_eq!(recorded.actions.len(), DAY);
        let mut observation = env.reset().unwrap().to_vec();
        for (number, action) in recorded.actions.iter().enumerate() {
            pilot.observe(&observation);
            let own = pilot.act(&rollout.actions[number / hold * width..][..width]).to_vec();
            assert!(own == *action, "step {number}, a decision every {hold}");
            let step = env.step(&own).unwrap();
            pilot.reward(step.reward.total());
            observation = step.observation.to_vec();
        }
    }
}

#[test]
fn a_decision_held_for_an_hour_is_a_step_with_the_discounted_rewards_of_its_steps() {
    let collect = |interface: Interface, discount: f32| {
        let mut collector = fragments(interface, 0.0).with_discount(discount);
        let quiet = actor(collector.widths(), interface, 1);
        let Distribution::Gaussian { log_std } = &quiet.distribution else { panic!("a Gaussian") };
        let distribution = Distribution::Gaussian { log_std: vec![-20.0; log_std.len()] };
        let idle = Actor { parameters: vec![0.0; quiet.parameters.len()], distribution, ..quiet };
        let mut rollout = Rollout::default();
        collector.collect(&idle, 24, &mut rollout).unwrap();
        rollout
    };
    let [all, first] = [1.0, 0.0].map(|discount| collect(SUPERVISORY, discount));
    let by_node = collect(GRAPH_SUPERVISORY, 1.0);
    assert_eq!(by_node.rewards[..24], all.rewards[..24], "nothing shifted at any node is the guideline too");
    let ends: Vec<(usize, usize)> = all.ends.iter().map(|end| (end.environment, end.step)).collect();
    assert_eq!(ends, [(0, 23), (1, 23), (2, 23)], "a day is 24 decisions");
    let mut env = house(SUPERVISORY);
    let mut guideline = Guideline36::new(env.spaces(), &Guideline36Parameters::default());
    let mut action = vec![0.0; env.spaces().action.len()];
    env.reset().unwrap();
    for hour in 0..24 {
        let mut rewards = Vec::new();
        for _ in 0..STEPS_PER_HOUR {
            guideline.act(env.observation(), &mut action);
            rewards.push(0.3 * env.step(&action).unwrap().reward.total() as f32);
        }
        let near = |one: f32, other: f32| (one - other).abs() <= 1e-4 * (1.0 + other.abs());
        let sum = rewards.iter().sum();
        assert!(near(all.rewards[hour], sum), "hour {hour}: {} {sum}", all.rewards[hour]);
        assert!(near(first.rewards[hour], rewards[0]), "hour {hour}: {}", first.rewards[hour]);
    }
}

/// Asserts that a rollout of graph networks has the buildings of its environments, with the smaller ones padded with
/// zeros.
fn assert_scenes(rollout: &Rollout, interface: Interface) {
    let widths: Vec<usize> = rollout.scenes.iter().map(|scene| scene.graph.width()).collect();
    if interface.nodes.is_none() {
        return assert!(widths.is_empty());
    }
    let environments: Vec<usize> = rollout.scenes.iter().map(|scene| scene.environment).collect();
    let mut distinct = environments.clone();
    distinct.dedup();
    assert_eq!(distinct, [0, 1, 2]);
    let stride = rollout.observations.len() / rollout.rows();
    let of = |environment: usize| widths[environments.iter().position(|each| *each == environment).unwrap()];
    assert!(of(0) == of(2) && of(0) < of(1) && of(1) == stride, "{widths:?}");
    for (row, values) in rollout.observations.chunks(stride).enumerate() {
        assert!(values[of(row / rollout.steps)..].iter().all(|value| *value == 0.0));
    }
}

#[test]
fn a_full_stroke_of_all_actuators_has_the_configured_cost() {
    const COST: f32 = 0.7;
    for by_zone in [false, true] {
        let free = rollouts(&mut fragments_with(DIRECT, by_zone, 0.0, 0.0), DIRECT, 1..=4, STEPS);
        let mut collector = fragments_with(DIRECT, by_zone, 0.0, COST);
        let Widths { action, parts, .. } = collector.widths();
        let costly = rollouts(&mut collector, DIRECT, 1..=4, STEPS);
        let mut costs = Vec::new();
        let mut expected = Vec::new();
        for (free, costly) in free.iter().zip(&costly) {
            assert!(free.actions == costly.actions, "the cost changes nothing but the reward");
            // In the first environment; a stroke is from -1 to 1.
            let rows = |rewards: &[f32]| {
                rewards.chunks_exact(parts).map(|row| row.iter().sum()).collect::<Vec<f32>>()
            };
            let (before, after) =
                (rows(&free.rewards[..STEPS * parts]), rows(&costly.rewards[..STEPS * parts]));
            costs.extend(before.iter().zip(after).map(|(before, after)| before - after));
            expected.extend(free.actions[..STEPS * action].iter().map(|value| value.clamp(-1.0, 1.0)));
        }
        assert!(costs[0] == 0.0 && costs[DAY] == 0.0, "the first action of an episode moves nothing");
        for step in (1..costs.len()).filter(|step| *step != DAY) {
            let [last, now] = [step - 1, step].map(|step| &expected[step * action..][..action]);
            let strokes: f32 = last.iter().zip(now).map(|(last, now)| (now - last).abs() / 2.0).sum();
            let cost = COST * strokes / action as f32;
            assert!((costs[step] - cost).abs() < 1e-4, "step {step}: {} instead of {cost}", costs[step]);
        }
        // A restored collection charges the first step like an uninterrupted one.
        let state = {
            let mut first = fragments_with(DIRECT, by_zone, 0.0, COST);
            rollouts(&mut first, DIRECT, 1..=1, STEPS);
            first.state()
        };
        let mut restored = fragments_with(DIRECT, by_zone, 0.0, COST);
        let any = actor(restored.widths(), DIRECT, 0);
        restored.restore(&state, &any).unwrap();
        assert!(rollouts(&mut restored, DIRECT, 2..=2, STEPS)[0] == costly[1]);
    }
}

fn a_restored_collection_continues(interface: Interface) {
    let mut whole = fragments(interface, 0.4);
    rollouts(&mut whole, interface, 1..=2, STEPS);
    let first = whole.state();
    let mut expected = rollouts(&mut whole, interface, 3..=4, STEPS);
    let second = whole.state();
    expected.extend(rollouts(&mut whole, interface, 5..=6, STEPS));
    // The first state is in the first episodes, the second in the next.
    for (state, from) in [(first, 3), (second, 5)] {
        let state = State::from_bytes(&state.to_bytes()).unwrap();
        let mut restored = fragments(interface, 0.4);
        let any = actor(restored.widths(), interface, 0);
        restored.restore(&state, &any).unwrap();
        assert!(restored.state() == state, "the state is kept");
        let continued = rollouts(&mut restored, interface, from..=6, STEPS);
        assert!(continued == expected[from as usize - 3..], "continued at rollout {from} with {interface:?}");
    }
}

#[test]
fn a_restored_collection_continues_with_the_same_bits() {
    a_restored_collection_continues(RESIDUAL);
}

#[test]
fn a_restored_collection_of_recurrent_networks_continues_with_the_same_bits() {
    a_restored_collection_continues(RECURRENT);
}

#[test]
fn a_restored_collection_of_graphs_continues_with_the_same_bits() {
    a_restored_collection_continues(GRAPH);
    a_restored_collection_continues(REMEMBERING_GRAPH);
}

#[test]
fn an_episode_that_is_lost_in_a_replay_costs_no_other() {
    let mut whole = fragments(DIRECT, 0.4);
    // An episode of more than one chunk would take several days; a loss in the first chunk is enough.
    rollouts(&mut whole, DIRECT, 1..=1, STEPS);
    let mut state = whole.state();
    let width = whole.widths().action;
    state.put_f32("actions.1", &vec![f32::NAN; STEPS * width]);
    let mut restored = fragments(DIRECT, 0.4);
    let any = actor(restored.widths(), DIRECT, 0);
    restored.restore(&state, &any).unwrap();
    assert_eq!(restored.lost(), 1);
    let expected = rollouts(&mut whole, DIRECT, 2..=2, STEPS).remove(0);
    let rollout = rollouts(&mut restored, DIRECT, 2..=2, STEPS).remove(0);
    assert_one_episode_is_another(&rollout, &expected, whole.widths());
}

#[test]
fn mirrored_noise_is_opposite_in_the_environments_of_a_pair() {
    let mut collector = fragments(DIRECT, 0.4).with_mirrored_noise();
    let widths = collector.widths();
    let all = rollouts(&mut collector, DIRECT, 1..=3, STEPS);
    // Three environments: a pair in the same episode, and one alone.
    assert!(all.iter().all(|rollout| rollout.pairs == [STEPS]));
    let first = &all[0];
    let row = |values: &[f32], environment: usize, width: usize| {
        values[environment * STEPS * width..][..width].to_vec()
    };
    let [one, other, alone] = [0, 1, 2].map(|environment| row(&first.actions, environment, widths.action));
    let actor = actor(widths, DIRECT, 1);
    let mut mean = vec![0.0; widths.action];
    actor.mean(&row(&first.observations, 0, widths.observation), &mut actor.scratch(None), &mut mean);
    for (index, mean) in mean.iter().enumerate() {
        assert!((one[index] + other[index] - 2.0 * mean).abs() < 1e-5 && one[index] != *mean);
    }
    assert_ne!(one, alone);
    // A pair is no longer a pair once one of its episodes is lost.
    let process = collector.environments().process(1).unwrap();
    assert!(with_a_kill(&mut collector, process).pairs[0] < STEPS);
}

fn signal(process: u32, signal: Signal) {
    kill_process(Pid::from_raw(process as i32).unwrap(), signal).unwrap();
}

/// Collects the second rollout while the worker of the second environment is killed.
fn with_a_kill(collector: &mut dyn Collector, process: u32) -> Rollout {
    // Stopped, so that it does not finish before it is killed.
    signal(process, Signal::STOP);
    let killer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        signal(process, Signal::KILL);
    });
    let rollout = rollouts(collector, DIRECT, 2..=2, STEPS).remove(0);
    killer.join().unwrap();
    rollout
}

/// Asserts that a rollout has another episode of the second environment, and is otherwise as expected.
fn assert_one_episode_is_another(rollout: &Rollout, expected: &Rollout, widths: Widths) {
    let of = |rollout: &Rollout, environment: usize| {
        let row = STEPS * widths.observation;
        rollout.observations[environment * row..][..row].to_vec()
    };
    assert_eq!((rollout.environments, rollout.steps), (ENVIRONMENTS, STEPS));
    for environment in 0..ENVIRONMENTS {
        assert_eq!(of(rollout, environment) == of(expected, environment), environment != 1);
    }
}

#[test]
fn a_worker_killed_in_a_rollout_costs_its_episode_alone() {
    let mut whole = fragments(DIRECT, 0.0);
    let widths = whole.widths();
    let expected = rollouts(&mut whole, DIRECT, 1..=2, STEPS).remove(1);

    let mut collector = fragments(DIRECT, 0.0);
    rollouts(&mut collector, DIRECT, 1..=1, STEPS);
    let process = collector.environments().process(1).unwrap();
    assert_one_episode_is_another(&with_a_kill(&mut collector, process), &expected, widths);
    assert_eq!(collector.lost(), 1);
    rollouts(&mut collector, DIRECT, 3..=4, STEPS);
    assert_eq!((collector.lost(), collector.ended()), (1, ENVIRONMENTS as u64));

    let mut collector = lockstep(DIRECT, 0.0);
    rollouts(&mut collector, DIRECT, 1..=1, STEPS);
    let process = collector.environments().process(1).unwrap();
    assert_one_episode_is_another(&with_a_kill(&mut collector, process), &expected, widths);
    assert_eq!(collector.lost(), 1);
}
