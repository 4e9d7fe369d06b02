//! A building of a user's own as an environment.

mod case;

use b2b_building::Conditioning;
use b2b_energyplus::Level;
use case::{Case, random_episode};

#[test]
fn zones_left_to_their_own_controls_are_held_by_them_and_not_judged() {
    let case = Case::imported(
        "RefBldgSmallHotelNew2004_Chicago.idf",
        "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw",
    );
    let mut env = case.env("01-08..01-08");
    let trajectory = random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    let zones = &case.building.zones;
    assert_eq!(env.observation_space().zone_temperatures().len(), zones.len());
    for (slot, zone) in zones.iter().enumerate().filter(|(_, zone)| zone.own_controls) {
        let temperatures: Vec<f64> = trajectory.observed(slot).collect();
        assert!(temperatures.iter().all(|t| (12.0..32.0).contains(t)), "{}: {temperatures:?}", zone.name);
        assert!(env.metrics().zones.iter().all(|judged| judged.slot != slot), "{} is judged", zone.name);
    }
    let driven = zones.iter().filter(|zone| zone.conditioning != Conditioning::None).count();
    assert_eq!(env.metrics().zones.len(), driven);
    let meters = env.engine_meters().unwrap();
    assert!((env.metrics().electricity / meters[0] - 1.0).abs() < 1e-9);
}
