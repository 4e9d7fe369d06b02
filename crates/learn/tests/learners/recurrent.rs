//! Learning of a toy environment with a hidden context by recurrent PPO.

use b2b_agent::Agent;
use b2b_learn::collector::Collector;
use b2b_learn::learner::Learner as _;
use b2b_learn::ppo::{Ppo, PpoConfig};
use b2b_learn::rollout::Rollout;
use b2b_learn::train::{RecurrentPolicy, TrainConfig};

use super::ppo::evaluate;
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

/// Returns the mean return without exploration after the updates.
fn train<const SEEN: bool>(policy: Option<&RecurrentPolicy>, seed: u64) -> f64 {
    let mut collector = Local::<Hidden<SEEN>>::new(ENVIRONMENTS, seed);
    let widths = collector.widths();
    let mut ppo = match policy {
        Some(policy) => Ppo::recurrent(policy, widths, config(), seed).unwrap(),
        None => Ppo::new(widths, config(), seed).unwrap(),
    };
    let mut rollout = Rollout::default();
    for _ in 0..UPDATES {
        collector.collect(&ppo.actor(), config().n_steps, &mut rollout).unwrap();
        assert_eq!(ppo.update(&rollout).unwrap().skipped, 0);
    }
    evaluate::<Hidden<SEEN>>(&ppo.actor())
}

#[test]
fn memory_reaches_the_return_of_a_context_in_sight_and_no_memory_does_not() {
    // Shorter sequences: what they learn of begins in the sequence before.
    for (sequence, seeds) in [(20, 0..2), (10, 2..3)] {
        let policy = RecurrentPolicy { width: 16, sequence, ..RecurrentPolicy::default() };
        for seed in seeds {
            let seen = train::<true>(None, seed);
            let [with, without] = [Some(&policy), None].map(|policy| train::<false>(policy, seed));
            println!("sequences of {sequence}: seen {seen:.1}, memory {with:.1}, no memory {without:.1}");
            assert!(seen > 19.0 && with > seen - 2.0 && without < 5.0, "{seen} {with} {without}");
        }
    }
}

const OPTIONS: &str = "
    preset = 'recurrent'
    buildings = ['SingleFamilyHouse-0014']
    period = '01-10..01-11'
    environments = 2
    window_days = 0
    steps = 1728
    policy = { kind = 'recurrent', width = 16, sequence = 48, memory_episodes = 2 }
    mirrored_noise = false
    evaluation = { every = 0, whole_period = false }
    ppo = { n_steps = 144, batch_size = 96 }";

#[test]
fn a_run_that_is_resumed_in_the_middle_of_an_episode_learns_the_same_weights() {
    let config = TrainConfig::default().with_changes(OPTIONS).unwrap();
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
    assert!(whole.actor().shape.recurrent().is_some() && whole.info().interface.observation.feedback);
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
