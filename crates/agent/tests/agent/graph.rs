//! Graph agents in buildings of several types, on the real engine.

use std::path::Path;
use std::sync::Arc;

use b2b_agent::network::{Activation, Actor, Distribution, Edges, GraphNetwork, Shape};
use b2b_agent::{
    Acting, Agent, AgentInfo, AgentObservation, Error, FORMAT, Interface, NodeForm, NodePlan, NodeSpaces,
    ObservationForm, Pilot, TrainingInfo,
};
use b2b_building::morphology::NodeType;
use b2b_control::{Guideline36, Guideline36Parameters, Reactive};
use b2b_dataset::{Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, EpisodeConfig, rollout};

fn env(building: &str, task: &str) -> Env {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let found = catalog.find(&building.parse().unwrap(), &Placement::default(), &mut Quiet).unwrap();
    let weather = found.weather.clone();
    let building = Arc::new(found.prepare(catalog.library()).unwrap());
    let (period, task) = ("01-10..01-10".parse().unwrap(), task.parse().unwrap());
    Env::new(catalog.library().clone(), building, EpisodeConfig { weather, period, steps_per_hour: 4, task })
        .unwrap()
}

fn interface(observation: ObservationForm, acting: Acting, attributes: bool) -> Interface {
    Interface { observation: observation.into(), acting, nodes: Some(NodeForm { attributes }) }
}

const RESIDUAL: Acting = Acting::Residual { authority: 0.5 };
const SUPERVISORY: Acting = Acting::Supervisory { every: 60, shared: true, setpoints: true, rule: false };

/// Writes an agent with weights of this size that was trained with these types.
fn write(folder: &Path, interface: Interface, scale: f32, known: &[NodeType]) {
    write_with(NodeSpaces::of(interface).slots(), folder, interface, scale, known);
}

/// The same, for an agent whose slots have these names.
fn write_with(slots: Vec<String>, folder: &Path, interface: Interface, scale: f32, known: &[NodeType]) {
    let spaces = NodeSpaces::of(interface);
    let network = GraphNetwork {
        types: spaces.widths(),
        embedding: 16,
        heads: 2,
        layers: 2,
        feed_forward: 24,
        activation: Activation::Relu,
        edges: Edges::Bias,
        memory: 0,
    };
    let shape = Shape::Graph(network.clone());
    let number = |index: usize| scale * (((index * 7919) % 101) as f32 / 50.0 - 1.0);
    let mut parameters: Vec<f32> = (0..shape.parameters()).map(number).collect();
    for encoder in network.places().encoders {
        parameters[encoder.mean].fill(0.0);
        parameters[encoder.scale].fill(1.0);
    }
    let log_std = vec![-1.0; spaces.actuators().len()];
    let actor = Actor { shape, parameters, distribution: Distribution::Gaussian { log_std } };
    let info = AgentInfo {
        format: FORMAT,
        interface,
        slots,
        actuators: spaces.actuators(),
        node_types: known.iter().map(|node_type| node_type.name().to_owned()).collect(),
        network: actor.shape.clone(),
        memory_episodes: None,
        distribution: actor.distribution.clone(),
        task: "occupancy".parse().unwrap(),
        training: TrainingInfo { buildings: "several".into(), ..TrainingInfo::default() },
        weights: String::new(),
    };
    Agent::write(folder, info, &actor).unwrap();
}

#[test]
fn one_agent_controls_several_types_and_acts_alike_when_read_again() {
    let folder = tempfile::tempdir().unwrap();
    for (observation, acting, attributes) in
        [(ObservationForm::Raw, Acting::Direct, false), (ObservationForm::Features, RESIDUAL, true)]
    {
        write(folder.path(), interface(observation, acting, attributes), 0.3, &NodeType::ALL);
        let agent = Agent::read(folder.path()).unwrap();
        let mut returns = Vec::new();
        for building in ["SingleFamilyHouse-0014", "OfficeMedium-0007"] {
            let mut env = env(building, "occupancy");
            let spaces = Arc::clone(env.spaces());
            let both = [0, 1].map(|_| {
                let mut controller = agent.controller(&spaces).unwrap();
                rollout(&mut env, &mut controller, &mut ()).unwrap().episode_return
            });
            assert_eq!(both[0], both[1], "{building}");
            returns.push(both[0]);
        }
        assert!(returns.iter().all(|value| *value < 0.0) && returns[0] != returns[1], "{returns:?}");
    }
}

#[test]
fn a_correction_of_zero_is_the_reactive_controllers() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), interface(ObservationForm::Features, RESIDUAL, false), 0.0, &NodeType::ALL);
    let mut env = env("OfficeSmall-0042", "occupancy");
    let spaces = Arc::clone(env.spaces());
    let mut agent = Agent::read(folder.path()).unwrap().controller(&spaces).unwrap();
    let corrected = rollout(&mut env, &mut agent, &mut ()).unwrap();
    let mut reactive = Reactive::for_env(&env);
    let reactive = rollout(&mut env, &mut reactive, &mut ()).unwrap();
    assert_eq!(corrected.episode_return, reactive.episode_return);
}

#[test]
fn attributes_tell_a_supervisor_which_units_have_heat_pumps() {
    let form = interface(ObservationForm::Features, SUPERVISORY, true);
    for (building, expected) in [("OfficeSmall-0042", true), ("RetailStandalone-0042", false)] {
        let spaces = Arc::clone(env(building, "operate").spaces());
        let plan = NodePlan::of(NodeForm { attributes: true }, &spaces).unwrap();
        let view = AgentObservation::by_node(form, &spaces, &plan).unwrap();
        let features = view.observation.features().iter();
        let units: Vec<String> = features
            .filter(|feature| feature.name.ends_with("heat pump"))
            .map(|feature| format!("{feature:?}"))
            .collect();
        let value = format!("Constant({:?})", f64::from(u8::from(expected)));
        assert!(!units.is_empty() && units.iter().all(|unit| unit.contains(&value)), "{building}: {units:?}");
    }
}

#[test]
fn a_graph_supervisor_has_every_point_at_its_node_and_is_the_guideline_while_it_shifts_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let form = interface(ObservationForm::Features, SUPERVISORY, true);
    let known = NodeSpaces::of(form).actuators();
    let fewer = interface(
        ObservationForm::Features,
        Acting::Supervisory { every: 60, shared: true, setpoints: false, rule: false },
        true,
    );
    assert!(
        NodeSpaces::of(fewer)
            .actuators()
            .iter()
            .all(|name| !name.contains("setpoint") && !name.contains("start"))
    );
    for building in ["OfficeMedium-0007", "OfficeSmall-0042"] {
        let mut env = env(building, "operate+preview");
        let spaces = Arc::clone(env.spaces());
        let mut guideline = Guideline36::new(&spaces, &Guideline36Parameters::default());
        let plan = NodePlan::of(NodeForm { attributes: true }, &spaces).unwrap();
        let view = AgentObservation::by_node(form, &spaces, &plan).unwrap();
        assert_eq!(view.graph.actions.len(), guideline.supervisory_points().len());
        for ((place, owner), point) in
            view.graph.actions.iter().zip(&view.owners).zip(guideline.supervisory_points())
        {
            let node_type = NodeType::ALL[view.graph.types[place.node]].name();
            let (shift, _) = point.shift.described();
            assert_eq!((*owner, &known[place.number]), (point.owner, &format!("{node_type}: {shift}")));
        }
        let alone = rollout(&mut env, &mut guideline, &mut ()).unwrap().episode_return;
        let returned = |scale: f32, env: &mut Env| {
            write(folder.path(), form, scale, &NodeType::ALL);
            let agent = Agent::read(folder.path()).unwrap();
            let own = rollout(env, &mut agent.controller(&spaces).unwrap(), &mut ()).unwrap().episode_return;
            // As created in a worker, which has no model.
            let mut again = agent.description(&spaces).unwrap().unwrap().controller(&spaces).unwrap();
            assert_eq!(rollout(env, again.as_mut(), &mut ()).unwrap().episode_return, own, "{building}");
            own
        };
        assert_eq!(returned(0.0, &mut env), alone, "{building}");
        assert_ne!(returned(0.3, &mut env), alone, "{building}");
        let mut pilot = Pilot::new(form, &spaces).unwrap();
        pilot.observe(env.reset().unwrap());
        let nothing = vec![0.0; pilot.widths().1];
        let after = env.step(pilot.act(&nothing)).unwrap().observation.to_vec();
        let (names, row) = (pilot.observation().names(), pilot.observe(&after).to_vec());
        let all: Vec<_> = names.iter().zip(row).collect();
        for what in ["outdoor temperature in 4 h", "price in 23 h", "change ahead", "mode: "] {
            let mut named = all.iter().filter(|(name, _)| name.contains(what));
            assert!(named.any(|(_, value)| *value != 0.0), "{building}: {what}");
        }
        let weather: Vec<_> = all.iter().filter(|(name, _)| name.ends_with("outdoor temperature")).collect();
        assert!(weather.len() > 1 && weather.iter().all(|(_, value)| *value == weather[0].1), "{weather:?}");
    }
}

#[test]
fn an_agent_whose_nodes_have_other_features_is_of_another_version() {
    let folder = tempfile::tempdir().unwrap();
    let form = interface(ObservationForm::Raw, Acting::Direct, false);
    let mut slots = NodeSpaces::of(form).slots();
    slots[0] = "weather: warmth".into();
    write_with(slots, folder.path(), form, 0.1, &NodeType::ALL);
    let env = env("SingleFamilyHouse-0014", "constant");
    let error = Agent::read(folder.path()).unwrap().controller(env.spaces()).unwrap_err();
    assert!(matches!(&error, Error::OtherVersion { why, .. } if why.contains("warmth")), "{error}");
}

#[test]
fn actuators_of_an_unknown_node_type_are_an_error_for_direct_actions() {
    let folder = tempfile::tempdir().unwrap();
    let known: Vec<_> = NodeType::ALL.into_iter().filter(|each| *each != NodeType::AirLoop).collect();
    write(folder.path(), interface(ObservationForm::Raw, Acting::Direct, false), 0.1, &known);
    let agent = Agent::read(folder.path()).unwrap();
    agent.controller(env("SingleFamilyHouse-0014", "constant").spaces()).unwrap();
    let error = agent.controller(env("OfficeMedium-0007", "constant").spaces()).unwrap_err();
    assert!(matches!(&error, Error::UnknownNodeType { node_type: "air loop", .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("OfficeMedium-0007") && said.contains("unitary zone, VAV zone"), "{said}");
}

#[test]
fn nodes_of_unknown_types_follow_the_reactive_controllers() {
    let folder = tempfile::tempdir().unwrap();
    let form = interface(ObservationForm::Features, RESIDUAL, true);
    let returns = |scale: f32, known: &[NodeType], env: &mut Env| {
        write(folder.path(), form, scale, known);
        let agent = Agent::read(folder.path()).unwrap();
        let spaces = Arc::clone(env.spaces());
        let mut controller = agent.controller(&spaces).unwrap();
        let corrected = controller.actions();
        let first = rollout(env, &mut controller, &mut ()).unwrap().episode_return;
        // As created in a worker, which has no model.
        let mut again = agent.description(&spaces).unwrap().unwrap().controller(&spaces).unwrap();
        assert_eq!(rollout(env, again.as_mut(), &mut ()).unwrap().episode_return, first);
        (corrected, first)
    };
    let without = |left_out: &[NodeType]| -> Vec<NodeType> {
        NodeType::ALL.into_iter().filter(|each| !left_out.contains(each)).collect()
    };
    let mut office = env("OfficeMedium-0007", "occupancy");
    let (all, reactive) = returns(0.0, &NodeType::ALL, &mut office);
    assert_eq!(all, 36);
    let (zones, corrected) = returns(0.3, &without(&[NodeType::AirLoop]), &mut office);
    assert!(zones < all && corrected != reactive, "{zones} corrected actuators, return {corrected}");
    assert_ne!(corrected, returns(0.3, &NodeType::ALL, &mut office).1);
    let nothing = without(&[NodeType::AirLoop, NodeType::VavZone]);
    write(folder.path(), form, 0.3, &nothing);
    let error = Agent::read(folder.path()).unwrap().controller(office.spaces()).unwrap_err();
    assert!(matches!(&error, Error::NothingToSet { building } if building == "OfficeMedium-0007"), "{error}");

    // A node without actuators is not observed.
    let mut small = env("OfficeSmall-0042", "occupancy");
    let (all, seen) = returns(0.3, &NodeType::ALL, &mut small);
    let (same, unseen) = returns(0.3, &without(&[NodeType::UncontrolledZone]), &mut small);
    assert!(same == all && unseen != seen, "{seen} and {unseen}");
}

#[test]
fn the_error_for_an_agent_with_other_features_names_the_first() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), interface(ObservationForm::Raw, Acting::Direct, false), 0.1, &NodeType::ALL);
    let path = folder.path().join("agent.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replace("VAV zone: occupancy", "VAV zone: presence").replace("\"format\": 2", "\"format\": 1"),
    )
    .unwrap();
    let agent = Agent::read(folder.path()).unwrap();
    let said = agent.controller(env("OfficeSmall-0042", "occupancy").spaces()).unwrap_err().to_string();
    assert!(said.contains("VAV zone: occupancy") && said.contains("VAV zone: presence"), "{said}");
}

#[test]
fn every_node_has_the_features_of_its_type_and_every_actuator_a_place() {
    let widths = |interface| NodeSpaces::of(interface).widths();
    for building in ["SingleFamilyHouse-0014", "OfficeMedium-0007", "Warehouse-0003"] {
        for task in ["constant", "occupancy"] {
            let mut env = env(building, task);
            let spaces = Arc::clone(env.spaces());
            let seen = env.reset().unwrap().to_vec();
            for (form, attributes) in [(ObservationForm::Raw, true), (ObservationForm::Features, false)] {
                let interface = interface(form, RESIDUAL, attributes);
                let plan = NodePlan::of(NodeForm { attributes }, &spaces).unwrap();
                let graph = AgentObservation::by_node(interface, &spaces, &plan).unwrap().graph;
                let widths = widths(interface);
                for (node, node_type) in graph.types.iter().enumerate() {
                    let features = graph.features[node + 1] - graph.features[node];
                    assert_eq!(features, widths[*node_type].features, "{building}: {}", graph.names[node]);
                }
                assert_eq!(graph.actions.len(), spaces.action.len());
                for (place, name) in graph.actions.iter().zip(spaces.action.names()) {
                    assert!(name.starts_with(&graph.names[place.node]), "{name}");
                    assert!(place.output < widths[graph.types[place.node]].outputs);
                }
                let mut pilot = Pilot::new(interface, &spaces).unwrap();
                let row = pilot.observe(&seen);
                assert_eq!(row.len(), graph.width());
                assert!(row.iter().all(|value| value.abs() <= 6.0), "{building}, {task}, {form}: {row:?}");
            }
        }
    }
}
