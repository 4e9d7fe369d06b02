//! Every slot of every building type has one place in the morphology.

use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

use crate::case;
use b2b_building::description::Origin;
use b2b_building::morphology::{Layout, NodeType, Observed, Owner};
use b2b_building::{BuildingType, Conditioning, Description, Morphology};
use b2b_env::{Decomposition, Env, EpisodeConfig, Task};

struct Case {
    env: Env,
    morphology: Morphology,
    decomposition: Decomposition,
}

fn cases() -> impl Iterator<Item = Case> {
    BuildingType::ALL.into_iter().map(case)
}

fn case(building_type: BuildingType) -> Case {
    case_of(building_type, Task::default())
}

/// The building is prepared once for all tests.
fn case_of(building_type: BuildingType, task: Task) -> Case {
    static PREPARED: [OnceLock<case::Case>; 6] = [const { OnceLock::new() }; 6];
    let case::Case { library, building, weather } =
        PREPARED[building_type as usize].get_or_init(|| case::Case::at_home(building_type));
    let period = "01-01..01-01".parse().unwrap();
    let episode = EpisodeConfig { weather: weather.clone(), period, steps_per_hour: 12, task };
    let env = Env::new(library.clone(), Arc::clone(building), episode).unwrap();
    let description = Description::of(building, weather, Origin::default()).unwrap();
    let morphology = Morphology::of(building, &description);
    let decomposition = Decomposition::new(&morphology, env.observation_space(), env.action_space()).unwrap();
    Case { env, morphology, decomposition }
}

fn numbers(len: usize) -> Vec<f64> {
    (0..len).map(|number| number as f64 + 0.5).collect()
}

#[test]
fn every_slot_belongs_to_exactly_one_node() {
    let tasks = || Task::NAMED.iter().map(|name| name.parse().unwrap());
    let cases = BuildingType::ALL.into_iter().flat_map(|kind| tasks().map(move |task| case_of(kind, task)));
    for Case { env, morphology, decomposition } in cases {
        for (cells, layout, spaces) in [
            (
                decomposition.observation_cells().collect::<Vec<_>>(),
                decomposition.observation_layout(),
                env.observation_space().len(),
            ),
            (decomposition.action_cells().to_vec(), decomposition.action_layout(), env.action_space().len()),
        ] {
            assert_eq!(cells.len(), spaces, "{}", morphology.name);
            assert_eq!(cells.iter().collect::<HashSet<_>>().len(), cells.len(), "{}", morphology.name);
            assert!(cells.iter().all(|cell| *cell < layout.len()));
        }
        let owners = env.observation_space().slots().iter().map(|slot| slot.owner);
        for owner in owners.chain(env.action_space().owners().iter().copied()) {
            assert_eq!(morphology.nodes.iter().filter(|node| node.owner == owner).count(), 1, "{owner:?}");
        }
    }
}

#[test]
fn every_action_of_every_node_is_driven() {
    for Case { morphology, decomposition, .. } in cases() {
        let driven = decomposition.action_cells().len();
        assert_eq!(driven, decomposition.action_layout().len(), "{}", morphology.name);
    }
}

#[test]
fn split_and_join_undo_each_other() {
    for Case { env, decomposition, .. } in cases() {
        let observation = numbers(env.observation_space().len());
        let mut nodes = vec![f64::NAN; decomposition.observation_layout().len()];
        decomposition.split(&observation, &mut nodes);
        assert!(nodes.iter().all(|value| value.is_finite()));
        let mut back = vec![0.0; observation.len()];
        decomposition.join_observation(&nodes, &mut back);
        assert_eq!(back, observation);

        let action = numbers(env.action_space().len());
        let mut nodes = vec![f64::NAN; decomposition.action_layout().len()];
        decomposition.split_action(&action, &mut nodes);
        let mut back = vec![0.0; action.len()];
        decomposition.join(&nodes, &mut back);
        assert_eq!(back, action);
    }
}

#[test]
fn a_zone_observes_its_own_temperature_occupancy_and_target() {
    let moving = BuildingType::ALL.map(|kind| case_of(kind, "occupancy".parse().unwrap()));
    let bands = BuildingType::ALL.map(|kind| case_of(kind, "operate+preview".parse().unwrap()));
    for Case { env, morphology, decomposition } in cases().chain(moving).chain(bands) {
        let observation = numbers(env.observation_space().len());
        let mut nodes = vec![0.0; decomposition.observation_layout().len()];
        decomposition.split(&observation, &mut nodes);
        for (number, node) in morphology.nodes.iter().enumerate() {
            let Owner::Zone(zone) = node.owner else { continue };
            let block = decomposition.observation_layout().block(node.node_type);
            let seen = |quantity| {
                let slots = node.node_type.observation();
                let column = slots.iter().position(|slot| slot.quantity == quantity)?;
                Some(nodes[block.cell(morphology.row(number), column)])
            };
            let temperature = observation[env.observation_space().zone_temperatures().start + zone];
            assert_eq!(seen(Observed::AirTemperature), Some(temperature), "{}", node.name);
            let zones = &env.building().zones;
            let controlled = zones[zone].conditioning != Conditioning::None;
            let before = zones[..zone].iter().filter(|zone| zone.conditioning != Conditioning::None).count();
            let space = env.observation_space();
            let target = || space.target(before).of(&observation);
            let occupancy = || space.occupancy(before).map_or(1.0, |slot| observation[slot]);
            assert_eq!(seen(Observed::TargetTemperature), controlled.then(target));
            assert_eq!(seen(Observed::Occupancy), controlled.then(occupancy));
        }
    }
}

#[test]
fn a_node_drives_the_actuators_with_its_name() {
    for Case { env, morphology, decomposition } in cases() {
        for (name, cell) in env.action_space().names().iter().zip(decomposition.action_cells()) {
            let node = morphology.nodes.iter().enumerate().find(|(number, node)| {
                let block = decomposition.action_layout().block(node.node_type);
                block.slots > 0
                    && block.cell(morphology.row(*number), 0) + block.slots > *cell
                    && block.cell(morphology.row(*number), 0) <= *cell
            });
            let (_, node) = node.unwrap();
            assert!(name.starts_with(&node.name), "{name} is driven by {}", node.name);
        }
    }
}

#[test]
fn slots_of_one_building_do_not_fit_the_morphology_of_another() {
    let office = case(BuildingType::OfficeSmall);
    let house = case(BuildingType::SingleFamilyHouse);
    let (observation, action) = (office.env.observation_space(), office.env.action_space());
    let error = Decomposition::new(&house.morphology, observation, action).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("SingleFamilyHouse") && text.contains("Perimeter_ZN_"), "{text}");
}

#[test]
fn vectors_have_the_documented_sizes_and_arrays_the_sizes_of_their_nodes() {
    let case = case(BuildingType::OfficeMedium);
    let shape = |node_type| {
        let block = case.decomposition.observation_layout().block(node_type);
        [block.nodes, block.slots]
    };
    assert_eq!(shape(NodeType::VavZone), [15, 3]);
    assert_eq!(shape(NodeType::AirLoop), [3, 0]);
    assert_eq!(case.decomposition.action_layout().block(NodeType::AirLoop).slots, 2);
}

#[test]
fn different_buildings_stack_in_padded_arrays() {
    let cases: Vec<_> = cases().collect();
    let observation = Layout::covering(cases.iter().map(|case| case.decomposition.observation_layout()));
    let action = Layout::covering(cases.iter().map(|case| case.decomposition.action_layout()));
    assert_eq!(observation.block(NodeType::VavZone).nodes, 15);
    for Case { env, decomposition, .. } in &cases {
        let padded = decomposition.padded(&observation, &action);
        let seen = numbers(env.observation_space().len());
        let (mut own, mut row) =
            (vec![0.0; decomposition.observation_layout().len()], vec![0.0; observation.len()]);
        decomposition.split(&seen, &mut own);
        padded.split(&seen, &mut row);
        for node_type in NodeType::ALL {
            let own = &own[decomposition.observation_layout().block(node_type).range()];
            let stacked = &row[observation.block(node_type).range()];
            assert_eq!(own, &stacked[..own.len()], "{node_type:?}");
            assert!(stacked[own.len()..].iter().all(|padding| *padding == 0.0));
            let slots = observation.block(node_type).slots;
            assert_eq!(padded.nodes(node_type) * slots, own.len());
        }
        let mut undone = vec![0.0; seen.len()];
        padded.join_observation(&row, &mut undone);
        assert_eq!(undone, seen);
        let acted = numbers(env.action_space().len());
        let mut row = vec![f64::NAN; action.len()];
        padded.split_action(&acted, &mut row);
        let mut undone = vec![0.0; acted.len()];
        padded.join(&row, &mut undone);
        assert_eq!(undone, acted);
    }
}
