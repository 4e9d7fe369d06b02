//! Terminals without reheat, and units whose air several zones share.

use b2b_building::description::Origin;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::{Edge, EdgeKind, NodeType};
use b2b_building::{Description, Morphology};
use b2b_energyplus::Level;
use b2b_env::authority::measure;

use crate::case::{Case, energy_is_the_engines, random_episode};
use crate::models::office;

const DENVER: &str = "USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw";

fn node_types(case: &Case, node_type: NodeType) -> usize {
    let served = |system: &dyn b2b_building::hvac::System| {
        (0..system.zones().len()).filter(|&zone| system.node_type(zone) == node_type).count()
    };
    case.building.systems.iter().map(|system| served(&**system)).sum()
}

#[test]
fn the_energy_of_an_air_loop_with_and_without_reheat_is_the_engines() {
    let case = office::with_bare_terminals();
    assert_eq!([NodeType::VavZone, NodeType::DamperZone].map(|each| node_types(&case, each)), [12, 3]);
    let mut env = case.env("01-09..01-09");
    random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    energy_is_the_engines(&env);
}

#[test]
fn dampers_of_terminals_without_reheat_follow_their_commands() {
    let case = office::with_bare_terminals();
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    let dampers = report.rows.iter().filter(|row| row.quantity == Quantity::DamperOpening).count();
    assert!(dampers > 0 && dampers.is_multiple_of(15), "{dampers} rows of 15 dampers");
}

#[test]
fn a_unit_gives_its_zones_air_in_proportion_and_outdoor_air_for_the_people_in_any_of_them() {
    let case = Case::imported("ASHRAE901_HotelSmall_STD2019_Denver.idf", DENVER);
    assert_eq!(node_types(&case, NodeType::FollowingZone), 2);
    let description = Description::of(&case.building, &case.weather, Origin::default()).unwrap();
    let graph = Morphology::of(&case.building, &description);
    let follows = |edge: &&Edge| graph.nodes[edge.to].node_type == NodeType::FollowingZone;
    let controls: Vec<&Edge> =
        graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Controls).filter(follows).collect();
    assert_eq!(controls.len(), 2, "from the zone with the thermostat: {controls:?}");
    assert!(
        controls.iter().all(|edge| graph.nodes[edge.from].name.eq_ignore_ascii_case("ExerciseCenterFlr1"))
    );
    let systems = || case.building.laid_out_systems();
    let (number, (system, layout)) =
        systems().enumerate().find(|(_, (system, _))| system.zones().len() == 3).unwrap();
    assert_eq!(system.zones()[0].to_lowercase(), "exercisecenterflr1");
    let minimum = system.ventilation().unwrap().min_outdoor_air;
    let flow = layout.actions.start;
    let mut env = case.env("07-09..07-09");
    env.reset().unwrap();
    let lowest = env.action_space().low().to_vec();
    // The engine ends with the last step.
    for step in 0..12 * 24 - 1 {
        let used = env.step(&lowest).unwrap().action[flow];
        let [outdoor_air, people] = env.outdoor_air()[number].unwrap();
        assert!(
            step == 0 || people == 0.0 || outdoor_air > 0.999 * minimum,
            "{outdoor_air} kg/s for {people}"
        );
        assert!(step == 0 || people == 0.0 || used >= minimum, "{used} of {minimum} kg/s");
    }
    let mut env = case.env("07-09..07-09");
    random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    energy_is_the_engines(&env);
}
