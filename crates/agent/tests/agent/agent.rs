//! Agents in buildings, on the real engine.

use std::path::Path;
use std::sync::Arc;

use b2b_agent::network::{Activation, Actor, Distribution, Mlp, Recurrent, Shape};
use b2b_agent::{
    Acting, Agent, AgentInfo, Error, FORMAT, Interface, ObservationForm, ObservationOptions, Pilot,
    TrainingInfo,
};
use b2b_control::{Controller, Reactive};
use b2b_dataset::{Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, EpisodeConfig, Spaces, Trajectory, rollout, rollout_next};

pub fn env(building: &str, task: &str) -> Env {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let found = catalog.find(&building.parse().unwrap(), &Placement::default(), &mut Quiet).unwrap();
    let weather = found.weather.clone();
    let building = Arc::new(found.prepare(catalog.library()).unwrap());
    let (period, task) = ("01-10..01-10".parse().unwrap(), task.parse().unwrap());
    Env::new(catalog.library().clone(), building, EpisodeConfig { weather, period, steps_per_hour: 12, task })
        .unwrap()
}

/// An actor with small weights that depend on the seed.
pub fn actor(pilot: &Pilot, scale: f32) -> Actor {
    let (inputs, outputs) = pilot.widths();
    let shape = Mlp::new(inputs, &[8], outputs, Activation::Tanh);
    let parameters =
        (0..shape.parameters()).map(|index| scale * ((index * 7919) % 101) as f32 / 101.0 - scale / 2.0);
    Actor {
        parameters: parameters.collect(),
        distribution: Distribution::Gaussian { log_std: vec![-1.0; outputs] },
        shape: Shape::Mlp(shape),
    }
}

fn info(pilot: &Pilot, spaces: &Spaces, interface: Interface, actor: &Actor) -> AgentInfo {
    AgentInfo {
        format: FORMAT,
        interface,
        slots: pilot.observation().names(),
        actuators: pilot.action_names().to_vec(),
        node_types: vec![],
        network: actor.shape.clone(),
        memory_episodes: None,
        distribution: actor.distribution.clone(),
        task: spaces.episode.task.clone(),
        training: TrainingInfo { buildings: "OfficeSmall-0042".into(), ..TrainingInfo::default() },
        weights: String::new(),
    }
}

/// Writes an agent of a building to a folder.
fn write(folder: &Path, spaces: &Arc<Spaces>, interface: Interface, scale: f32) {
    let pilot = Pilot::new(interface, spaces).unwrap();
    let actor = actor(&pilot, scale);
    Agent::write(folder, info(&pilot, spaces, interface, &actor), &actor).unwrap();
}

const FEATURES: ObservationOptions =
    ObservationOptions { form: ObservationForm::Features, attributes: false, forecast: 0, feedback: false };
const RESIDUAL: Interface =
    Interface { observation: FEATURES, acting: Acting::Residual { authority: 0.5 }, nodes: None };

#[test]
fn a_correction_and_a_shift_of_zero_are_the_reactive_controllers() {
    let mut env = env("OfficeSmall-0042", "occupancy");
    let spaces = Arc::clone(env.spaces());
    let mut reactive = Reactive::for_env(&env);
    let reactive = rollout(&mut env, &mut reactive, &mut ()).unwrap();
    for interface in [RESIDUAL, Interface { acting: TARGETS, ..RESIDUAL }] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &spaces, interface, 0.0);
        let mut agent = Agent::read(folder.path()).unwrap().controller(&spaces).unwrap();
        let own = rollout(&mut env, &mut agent, &mut ()).unwrap();
        assert_eq!(own.episode_return, reactive.episode_return, "{interface:?}");
    }
}

const TARGETS: Acting = Acting::Targets { every: 60, shift: 1.5 };

#[test]
fn zones_follow_shifted_targets_and_errors_are_relative_to_the_tasks_targets() {
    for building in ["OfficeSmall-0042", "SingleFamilyHouse-0018"] {
        let mut env = env(building, "constant");
        let spaces = Arc::clone(env.spaces());
        let mut pilot = Pilot::new(Interface { acting: TARGETS, ..RESIDUAL }, &spaces).unwrap();
        let zones = spaces.controlled_zones().count();
        assert_eq!(pilot.action_names().len(), zones);
        assert!(pilot.action_names().iter().all(|name| name.ends_with(" target")));
        let mut evening = |share: f32| {
            let mut observation = env.reset().unwrap().to_vec();
            pilot.reset();
            let mut error = 0.0;
            for _ in 0..env.episode_steps() {
                error = pilot.observe(&observation)[0];
                observation.copy_from_slice(env.step(pilot.act(&vec![share; zones])).unwrap().observation);
            }
            let temperature = spaces.controlled_zones().next().unwrap();
            (observation[temperature], error)
        };
        let [(lower, below), (middle, at), (higher, above)] = [-1.0, 0.0, 1.0].map(&mut evening);
        assert!((middle - lower - 1.5).abs() < 0.3, "{building}: {lower} {middle}");
        assert!((higher - middle - 1.5).abs() < 0.3, "{building}: {middle} {higher}");
        assert!((below - at).abs() > 0.2 && (above - at).abs() > 0.2, "{building}: {below} {at} {above}");
    }
}

#[test]
fn corrections_are_within_their_authority_and_actions_within_bounds() {
    let mut env = env("OfficeSmall-0042", "occupancy");
    let spaces = Arc::clone(env.spaces());
    let mut reactive = Reactive::for_env(&env);
    let mut pilot = Pilot::new(RESIDUAL, &spaces).unwrap();
    let observation = env.reset().unwrap().to_vec();
    let mut base = vec![0.0; spaces.action.len()];
    reactive.act(&observation, &mut base);
    pilot.observe(&observation);
    for value in [-7.0, -1.0, 0.3, 1.0, 7.0f32] {
        let action = pilot.act(&vec![value; base.len()]).to_vec();
        for (index, action) in action.into_iter().enumerate() {
            let (low, high) = (spaces.action.low()[index], spaces.action.high()[index]);
            let expected = base[index] + 0.5 * f64::from(value.clamp(-1.0, 1.0)) * (high - low);
            assert!((action - expected.clamp(low, high)).abs() < 1e-9, "{}", spaces.action.names()[index]);
        }
    }
}

/// The base controllers' cooling setpoint stays above a reheat setpoint raised by an agent. Otherwise, they would cool
/// what the agent reheats, and lower the supply air temperature to its minimum.
#[test]
fn base_controllers_do_not_cool_a_zone_whose_reheat_setpoint_is_raised() {
    let mut env = env("OfficeMedium-0626", "constant");
    let spaces = Arc::clone(env.spaces());
    let names = spaces.action.names();
    let raised: Vec<f32> =
        names.iter().map(|name| if name.ends_with("heating setpoint") { 0.02 } else { 0.0 }).collect();
    let supply: Vec<usize> =
        (0..names.len()).filter(|index| names[*index].ends_with("supply air temperature")).collect();
    let mut pilot = Pilot::new(RESIDUAL, &spaces).unwrap();
    let mut observation = env.reset().unwrap().to_vec();
    let mut action = Vec::new();
    for _ in 0..288 {
        pilot.observe(&observation);
        action = pilot.act(&raised).to_vec();
        env.step(&action).unwrap();
        observation = env.observation().to_vec();
    }
    let temperatures: Vec<f64> = supply.iter().map(|index| action[*index]).collect();
    assert!(temperatures.iter().all(|temperature| *temperature > 16.0), "{temperatures:?}");
}

#[test]
fn an_agent_reads_back_unchanged_and_acts_alike() {
    let folder = tempfile::tempdir().unwrap();
    let mut env = env("SingleFamilyHouse-0014", "occupancy+energy0.5");
    let spaces = Arc::clone(env.spaces());
    for observation in [ObservationForm::Raw, ObservationForm::Roles, ObservationForm::Features] {
        for acting in [Acting::Direct, RESIDUAL.acting] {
            let interface = Interface { observation: observation.into(), acting, nodes: None };
            write(folder.path(), &spaces, interface, 0.4);
            let agent = Agent::read(folder.path()).unwrap();
            assert_eq!(agent.info().interface, interface);
            let returns = [0, 1].map(|_| {
                let mut controller = agent.controller(&spaces).unwrap();
                rollout(&mut env, &mut controller, &mut ()).unwrap().episode_return
            });
            assert_eq!(returns[0], returns[1]);
            assert!(returns[0] < 0.0);
        }
    }
}

/// A raw observation with feedback, and direct actions.
const REMEMBERING: Interface = Interface {
    observation: ObservationOptions {
        form: ObservationForm::Raw,
        attributes: false,
        forecast: 0,
        feedback: true,
    },
    acting: Acting::Direct,
    nodes: None,
};

/// Writes a recurrent agent of a building to a folder.
fn write_recurrent(folder: &Path, spaces: &Arc<Spaces>, interface: Interface) {
    let pilot = Pilot::new(interface, spaces).unwrap();
    let (inputs, outputs) = pilot.widths();
    let shape = Recurrent {
        encoder: Mlp::new(inputs, &[8], 3 * 10, Activation::Tanh),
        head: Mlp::new(10, &[], outputs, Activation::Tanh),
    };
    let number = |index: usize| ((index * 7919) % 101) as f32 / 101.0 - 0.5;
    let actor = Actor {
        parameters: (0..shape.parameters()).map(number).collect(),
        distribution: Distribution::Gaussian { log_std: vec![-1.0; outputs] },
        shape: Shape::Recurrent(shape),
    };
    Agent::write(folder, info(&pilot, spaces, interface, &actor), &actor).unwrap();
}

#[test]
fn a_recurrent_agent_forgets_at_a_reset_and_remembers_in_the_next_episode() {
    let folder = tempfile::tempdir().unwrap();
    let mut env = env("SingleFamilyHouse-0014", "occupancy");
    let spaces = Arc::clone(env.spaces());
    write_recurrent(folder.path(), &spaces, REMEMBERING);
    let agent = Agent::read(folder.path()).unwrap();
    let mut controller = agent.controller(&spaces).unwrap();
    let mut trajectories = [(); 4].map(|()| Trajectory::default());
    let [first, next, again, after] = &mut trajectories;
    rollout(&mut env, &mut controller, first).unwrap();
    rollout_next(&mut env, &mut controller, next).unwrap();
    rollout(&mut env, &mut controller, again).unwrap();
    rollout_next(&mut env, &mut controller, after).unwrap();
    let [first, next, again, after] = trajectories.map(|trajectory| trajectory.hash());
    assert_eq!((&first, &next), (&again, &after));
    assert_ne!(first, next, "it remembers the first episode");

    let info = AgentInfo { memory_episodes: Some(2), ..agent.info().clone() };
    let mut controller = Agent::new("two", info, (**agent.actor()).clone()).controller(&spaces).unwrap();
    rollout(&mut env, &mut controller, &mut ()).unwrap();
    for expected in [next, first] {
        let mut trajectory = Trajectory::default();
        rollout_next(&mut env, &mut controller, &mut trajectory).unwrap();
        assert_eq!(trajectory.hash(), expected, "it forgets after two episodes, as in training");
    }
}

#[test]
fn the_slots_of_feedback_have_the_last_action_the_root_of_its_reward_and_a_flag() {
    let mut env = env("SingleFamilyHouse-0014", "constant");
    let spaces = Arc::clone(env.spaces());
    let mut pilot = Pilot::new(REMEMBERING, &spaces).unwrap();
    let names = pilot.observation().names();
    let actions = spaces.action.len();
    let own = &names[names.len() - actions - 2..];
    let expected: Vec<String> = spaces.action.names().iter().map(|name| format!("{name} previous")).collect();
    assert_eq!(own[..actions], expected);
    assert_eq!(own[actions..], ["previous reward", "first step"]);
    let row = |row: &[f32]| row[row.len() - actions - 2..].to_vec();
    assert_eq!(row(pilot.observe(env.reset().unwrap())), [&vec![0.0; actions][..], &[0.0, 1.0]].concat());
    let action: Vec<f32> = (0..actions).map(|index| if index == 0 { 3.0 } else { -0.25 }).collect();
    let physical = pilot.act(&action).to_vec();
    let step = env.step(&physical).unwrap();
    let (reward, observation) = (step.reward.total(), step.observation.to_vec());
    pilot.reward(reward);
    let seen = row(pilot.observe(&observation));
    assert_eq!((seen[0], seen[1], seen[actions + 1]), (1.0, -0.25, 0.0));
    assert!(reward < 0.0 && (seen[actions] + (-reward).sqrt().min(5.0) as f32).abs() < 1e-6);
    pilot.reset();
    assert_eq!(row(pilot.observe(&observation))[actions..], [0.0, 1.0]);
    let features = ObservationOptions { form: ObservationForm::Features, ..REMEMBERING.observation };
    let names_of = |observation| {
        Pilot::new(Interface { observation, ..REMEMBERING }, &spaces).unwrap().observation().names()
    };
    let [with, without] = [features, FEATURES].map(names_of);
    assert_eq!(with[without.len()..], ["previous reward", "first step"], "features have the actions");
}

#[test]
fn every_flipped_bit_of_a_description_is_an_error_and_one_of_format_1_states_no_hash() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), env("SingleFamilyHouse-0014", "constant").spaces(), RESIDUAL, 0.4);
    let whole = Agent::read(folder.path()).unwrap();
    let path = folder.path().join("agent.json");
    let text = std::fs::read(&path).unwrap();
    for byte in 0..text.len() {
        let mut damaged = text.clone();
        damaged[byte] ^= 1 << (byte % 8);
        std::fs::write(&path, damaged).unwrap();
        assert!(Agent::read(folder.path()).is_err(), "byte {byte}");
    }
    let mut earlier: serde_json::Value = serde_json::from_slice(&text).unwrap();
    earlier["format"] = 1.into();
    assert!(earlier.as_object_mut().unwrap().remove("sha256").is_some());
    std::fs::write(&path, earlier.to_string()).unwrap();
    let earlier = Agent::read(folder.path()).unwrap();
    assert_eq!(AgentInfo { format: FORMAT, ..earlier.info().clone() }, *whole.info());
}

#[test]
fn a_network_larger_than_its_weights_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), env("SingleFamilyHouse-0014", "constant").spaces(), RESIDUAL, 0.4);
    let path = folder.path().join("agent.json");
    let whole: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    for (width, is_recurrent) in [1 << 20, 9_007_199_254_740_993_u64, 1 << 62]
        .into_iter()
        .flat_map(|width| [(width, false), (width, true)])
    {
        let mut damaged = whole.clone();
        if is_recurrent {
            let (one, other) = (serde_json::json!([width, width]), serde_json::json!([1, width]));
            damaged["network"] = serde_json::json!({
                "encoder": {"widths": one, "activation": "tanh"}, "head": {"widths": other, "activation": "tanh"}
            });
        } else {
            damaged["network"]["widths"][1] = width.into();
        }
        damaged["format"] = 1.into();
        std::fs::write(&path, damaged.to_string()).unwrap();
        let message = Agent::read(folder.path()).unwrap_err().to_string();
        assert!(message.contains("its network is larger than weights.safetensors"), "{message}");
    }
}

#[test]
fn features_are_of_the_order_of_one_and_have_the_same_names_in_all_houses() {
    let mut names: Option<Vec<String>> = None;
    for house in ["SingleFamilyHouse-0014", "SingleFamilyHouse-0018", "SingleFamilyHouse-0387"] {
        let mut env = env(house, "occupancy");
        let spaces = Arc::clone(env.spaces());
        let mut pilot = Pilot::new(RESIDUAL, &spaces).unwrap();
        let here: Vec<String> = pilot.observation().names();
        assert_eq!(*names.get_or_insert(here.clone()), here, "{house}");
        let mut seen = env.reset().unwrap().to_vec();
        for _ in 0..200 {
            let row = pilot.observe(&seen).to_vec();
            for (value, name) in row.iter().zip(&here) {
                assert!(value.abs() <= 6.0, "{house}: {name} is {value}");
            }
            let action = pilot.act(&vec![0.0; spaces.action.len()]).to_vec();
            seen = env.step(&action).unwrap().observation.to_vec();
        }
    }
}

#[test]
fn attributes_and_a_correct_forecast_follow_the_features() {
    let observation = ObservationOptions { attributes: true, forecast: 3, ..FEATURES };
    let interface = Interface { observation, ..RESIDUAL };
    let mut env = env("OfficeSmall-0042", "occupancy+energy0.5");
    let spaces = Arc::clone(env.spaces());
    let mut pilot = Pilot::new(interface, &spaces).unwrap();
    let names = pilot.observation().names();
    let place =
        |name: &str| names.iter().position(|each| each == name).unwrap_or_else(|| panic!("no {name}"));
    let plain = Pilot::new(RESIDUAL, &spaces).unwrap().observation().names();
    assert_eq!(names[..plain.len()], plain);
    assert_eq!(names.len(), plain.len() + b2b_building::morphology::COMMON.len() + 1 + 3);

    let (now, ahead) = (place("outdoor temperature"), place("outdoor temperature in 3 h"));
    let (area, weight) = (place("building floor_area"), place("task energy weight"));
    let mut seen = env.reset().unwrap().to_vec();
    let mut rows: Vec<Vec<f32>> = Vec::new();
    for _ in 0..100 {
        rows.push(pilot.observe(&seen).to_vec());
        let action = pilot.act(&vec![0.0; spaces.action.len()]).to_vec();
        seen = env.step(&action).unwrap().observation.to_vec();
    }
    for (early, late) in rows.iter().zip(&rows[36..]) {
        // The engine interpolates within the hour and reports the weather at the end of a step.
        assert!((early[ahead] - late[now]).abs() * 15.0 < 0.5, "{} {}", early[ahead], late[now]);
        assert_eq!((early[area], early[weight]), (rows[0][area], 0.5));
    }
    assert!(rows[0][area] > -1.0 && rows[0][area] < 0.0, "a small office: {}", rows[0][area]);
    let known = b2b_agent::attributes(observation, &spaces).unwrap();
    let mut in_worker = Pilot::without_model(interface, &spaces, None, &known).unwrap();
    assert_eq!(in_worker.observe(env.reset().unwrap()), rows[0]);
}

#[test]
fn the_error_for_a_damaged_agent_or_another_building_names_the_cause() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("agent");
    let said = Agent::read(&path).unwrap_err().to_string();
    assert!(said.contains("not the folder of an agent") && said.contains("agent.json"), "{said}");
    let office = env("OfficeSmall-0042", "occupancy");
    let spaces = Arc::clone(office.spaces());
    write(&path, &spaces, RESIDUAL, 0.1);
    let agent = Agent::read(&path).unwrap();
    let house = env("SingleFamilyHouse-0014", "occupancy");
    let error = agent.controller(house.spaces()).unwrap_err();
    assert!(matches!(&error, Error::OtherBuilding { building, .. } if building == "SingleFamilyHouse-0014"));
    assert!(error.to_string().contains("trained on OfficeSmall-0042"), "{error}");
    let weights = path.join("weights.safetensors");
    let whole = std::fs::read(&weights).unwrap();
    std::fs::write(&weights, &whole[..whole.len() - 4]).unwrap();
    assert!(matches!(Agent::read(&path).unwrap_err(), Error::Damaged { .. }));
    std::fs::write(&weights, &whole).unwrap();
    let text = std::fs::read_to_string(path.join("agent.json")).unwrap();
    std::fs::write(path.join("agent.json"), text.replace("\"format\": 2", "\"format\": 3")).unwrap();
    let said = Agent::read(&path).unwrap_err().to_string();
    assert!(said.contains("its format is 3"), "{said}");
}

#[test]
fn an_agent_from_other_rules_is_refused() {
    let env = env("OfficeSmall-0042", "operate");
    let spaces = Arc::clone(env.spaces());
    let acting = Acting::Supervisory { every: 60, shared: true, setpoints: false, rule: true };
    let interface = Interface { observation: FEATURES, acting, nodes: None };
    let pilot = Pilot::new(interface, &spaces).unwrap();
    let (actor, folder) = (actor(&pilot, 0.0), tempfile::tempdir().unwrap());
    let mut info = info(&pilot, &spaces, interface, &actor);
    let base = format!("guideline36 revision 5, {}", b2b_control::linear_supervisor::identity());
    info.training.base_controllers = Some(base);
    Agent::write(folder.path(), info.clone(), &actor).unwrap();
    Agent::read(folder.path()).unwrap();
    info.training.base_controllers = Some("linear-supervisor#000000000000".into());
    Agent::write(folder.path(), info, &actor).unwrap();
    let said = Agent::read(folder.path()).unwrap_err().to_string();
    assert!(said.contains("linear-supervisor#000000000000") && said.contains("train it again"), "{said}");
}
