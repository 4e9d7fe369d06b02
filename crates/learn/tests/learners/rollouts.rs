//! Rollouts under controllers that act in worker processes, on the real engine.

use std::path::Path;
use std::sync::Arc;

use b2b_agent::network::{Activation, Actor, Distribution, Mlp, Shape};
use b2b_agent::{
    Acting, Agent, AgentInfo, FORMAT, Interface, ObservationForm, ObservationOptions, Pilot, TrainingInfo,
};
use b2b_building::BuildingType;
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Environment, EpisodeConfig, Error, Metrics, Spaces, Step, Trajectory, rollout};
use b2b_workers::{Episode, EpisodeSetting, Launcher, RolloutMemory, Source, WorkerOptions, Workers};
use serde_json::{Value, json};

fn episode(building_type: BuildingType) -> Episode {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let name = BuildingName::Type(building_type);
    let found = catalog.find(&name, &Placement::default(), &mut Quiet).unwrap();
    let (weather, period) = (found.weather.clone(), "01-10..01-11".parse().unwrap());
    let task = "occupancy+energy0.5".parse().unwrap();
    let setting =
        EpisodeSetting::new(Source::from(found), EpisodeConfig { weather, period, steps_per_hour: 12, task });
    let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b-learn-worker"));
    let workers = Workers::new(WorkerOptions::new(launcher, catalog.library().path())).unwrap();
    workers.episode(&setting).unwrap()
}

/// Runs an episode with a controller in this process.
fn here(episode: &mut Episode, controller: &mut dyn Controller) -> (Metrics, Trajectory) {
    let mut trajectory = Trajectory::default();
    let metrics = rollout(episode, controller, &mut trajectory).unwrap();
    (metrics, trajectory)
}

/// Runs an episode with a controller in its worker.
fn there(episode: &mut Episode, description: &Value) -> (Metrics, Trajectory) {
    let mut trajectory = Trajectory::default();
    let mut memory = RolloutMemory::new(episode.workers());
    let metrics = episode.rollout(description, &mut memory, &mut trajectory).unwrap();
    (metrics, trajectory)
}

#[test]
fn reactive_control_in_the_worker_matches_the_owner_bit_for_bit() {
    for building_type in [BuildingType::SingleFamilyHouse, BuildingType::OfficeMedium] {
        let mut episode = episode(building_type);
        let spaces = Arc::clone(episode.spaces());
        let mut parameters = ReactiveParameters::default();
        parameters.unitary.gains.proportional /= 3.0;
        let mut reactive = Reactive::new(&spaces.building, &spaces.observation, 12, &parameters);
        let (metrics, trajectory) = here(&mut episode, &mut reactive);
        let description = Reactive::description(&parameters);
        let (metrics_there, trajectory_there) = there(&mut episode, &description);
        assert_eq!(trajectory_there.len(), 2 * 288);
        assert_eq!((&metrics_there, trajectory_there.hash()), (&metrics, trajectory.hash()));
        // Again, with nothing recorded.
        episode.reset().unwrap();
        episode.send_rollout(&description).unwrap();
        b2b_workers::recv(std::slice::from_mut(&mut episode), 1, &mut Vec::new()).unwrap();
        assert_eq!(episode.metrics(), Some(&metrics));
    }
}

#[test]
fn an_agent_in_the_worker_matches_the_owner_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut episode = episode(BuildingType::OfficeSmall);
    let spaces = Arc::clone(episode.spaces());
    write_agent(folder.path(), &spaces);
    let agent = Agent::read(folder.path()).unwrap();
    let (metrics, trajectory) = here(&mut episode, &mut agent.controller(&spaces).unwrap());
    let description = serde_json::to_value(agent.description(&spaces).unwrap().unwrap()).unwrap();
    let (metrics_there, trajectory_there) = there(&mut episode, &description);
    assert_eq!((&metrics_there, trajectory_there.hash()), (&metrics, trajectory.hash()));
}

#[test]
fn a_description_of_any_length_reaches_the_worker() {
    let folder = tempfile::tempdir().unwrap();
    let mut episode = episode(BuildingType::SingleFamilyHouse);
    let spaces = Arc::clone(episode.spaces());
    write_agent(folder.path(), &spaces);
    let agent = Agent::read(folder.path()).unwrap();
    let short = serde_json::to_value(agent.description(&spaces).unwrap().unwrap()).unwrap();
    let mut long = short.clone();
    long["agent"]["comment"] = "as in a large building ".repeat(10_000).into();
    let (metrics, trajectory) = there(&mut episode, &short);
    let (metrics_long, trajectory_long) = there(&mut episode, &long);
    assert_eq!((&metrics_long, trajectory_long.hash()), (&metrics, trajectory.hash()));
    episode.reset().unwrap();
    episode.send_rollout(&long).unwrap();
    b2b_workers::recv(std::slice::from_mut(&mut episode), 1, &mut Vec::new()).unwrap();
    assert_eq!(episode.metrics(), Some(&metrics));
}

#[test]
fn an_error_of_either_side_ends_the_rollout_and_the_next_reset_starts_over() {
    let mut episode = episode(BuildingType::SingleFamilyHouse);
    let mut memory = RolloutMemory::new(episode.workers());
    let error = episode.rollout(&json!({"guess": {}}), &mut memory, &mut ()).unwrap_err();
    assert!(matches!(&error, Error::Lost { why, .. } if why.contains("unknown variant `guess`")), "{error}");
    let reactive = Reactive::description(&ReactiveParameters::default());
    let mut steps = 0;
    let mut interrupting = |_: &Step<'_>| {
        steps += 1;
        if steps == 300 { Err(Error::Interrupted) } else { Ok(()) }
    };
    let error = episode.rollout(&reactive, &mut memory, &mut interrupting).unwrap_err();
    assert!(matches!(error, Error::Interrupted), "{error}");
    episode.rollout(&reactive, &mut memory, &mut ()).unwrap();
}

/// Writes an agent with small weights for a building.
fn write_agent(folder: &Path, spaces: &Arc<Spaces>) {
    let interface = Interface {
        observation: ObservationOptions {
            form: ObservationForm::Features,
            attributes: true,
            forecast: 2,
            feedback: false,
        },
        acting: Acting::Residual { authority: 0.5 },
        nodes: None,
    };
    let pilot = Pilot::new(interface, spaces).unwrap();
    let (inputs, outputs) = pilot.widths();
    let shape = Mlp::new(inputs, &[8], outputs, Activation::Tanh);
    let parameters = (0..shape.parameters()).map(|index| ((index * 7919) % 101) as f32 / 250.0 - 0.2);
    let actor = Actor {
        parameters: parameters.collect(),
        distribution: Distribution::Gaussian { log_std: vec![-1.0; outputs] },
        shape: Shape::Mlp(shape),
    };
    let info = AgentInfo {
        format: FORMAT,
        interface,
        slots: pilot.observation().names(),
        actuators: spaces.action.names().to_vec(),
        node_types: vec![],
        network: actor.shape.clone(),
        memory_episodes: None,
        distribution: actor.distribution.clone(),
        task: spaces.episode.task.clone(),
        training: TrainingInfo::default(),
        weights: String::new(),
    };
    Agent::write(folder, info, &actor).unwrap();
}
