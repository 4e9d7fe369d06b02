//! Random presence on the engine: the number of people is drawn around the schedules, for every way in which a model
//! defines people.

use crate::case::{Case, random_episode};
use b2b_building::{BuildingType, Model};
use b2b_env::{Env, Presence, Task};
use serde_json::json;

/// A Tuesday and a Wednesday.
const DAYS: &str = "01-03..01-04";
/// A Tuesday.
const DAY: &str = "01-03..01-03";

/// Returns the people of each system's zones at the end of every step.
fn people(env: &mut Env) -> Vec<Vec<f64>> {
    let action: Vec<f64> = env.action_space().low().to_vec();
    env.reset().unwrap();
    let mut steps = Vec::new();
    for _ in 0..env.episode_steps() - 1 {
        env.step(&action).unwrap();
        steps.push(env.outdoor_air().iter().flatten().map(|[_, people]| *people).collect());
    }
    steps
}

#[test]
fn people_come_and_go_around_the_schedule() {
    let office = Case::at_home(BuildingType::OfficeSmall);
    let scheduled = people(&mut office.env_for(DAYS, "constant"));
    let random = people(&mut office.env_for(DAYS, "constant+presence1"));
    let total = |steps: &[Vec<f64>]| steps.iter().flatten().sum::<f64>();
    assert!((total(&random) / total(&scheduled) - 1.0).abs() < 0.1);
    // Presence follows the schedule one step later.
    let pairs = || random[1..].iter().flatten().zip(scheduled.iter().flatten());
    assert!(
        pairs().all(|(drawn, expected)| *expected > 0.0 || *drawn == 0.0),
        "nobody while nobody is expected"
    );
    let differ = pairs().filter(|(drawn, expected)| (**drawn - **expected).abs() > 0.1).count();
    assert!(differ as f64 > 0.4 * pairs().filter(|(_, expected)| **expected > 0.0).count() as f64);
    // Each zone draws independently.
    assert!(random.iter().any(|zones| (zones[1] > 0.0) != (zones[2] > 0.0)));
}

#[test]
fn heat_gains_and_observed_occupancy_follow_the_drawn_people() {
    let office = Case::at_home(BuildingType::OfficeSmall);
    let run = |task: &str| random_episode(&mut office.env_for(DAYS, task), 3);
    let [scheduled, random] = ["occupancy", "occupancy+presence1"].map(run);
    assert_ne!(scheduled.penalties, random.penalties);
    let mut env = office.env_for(DAYS, "occupancy+presence1");
    let occupancy = env.observation_space().occupancy(1).unwrap();
    let people = people(&mut env);
    let observed: Vec<bool> = random.observed(occupancy).map(|occupied| occupied > 0.0).collect();
    assert!(people.iter().zip(&observed).all(|(zones, observed)| (zones[1] > 0.0) == *observed));
}

#[test]
fn equal_tasks_draw_the_same_people_and_seeds_differ() {
    let office = Case::at_home(BuildingType::OfficeSmall);
    let task = |seed| Task { presence: Presence { seed, hours: 2.0 }, ..Task::default() };
    let hash = |seed| random_episode(&mut office.env_with(DAY, task(seed)), 3).hash();
    let mut env = office.env_with(DAY, task(1));
    let first = random_episode(&mut env, 3).hash();
    assert_eq!(random_episode(&mut env, 3).hash(), first, "after a reset");
    assert_eq!(hash(1), first);
    assert_ne!(hash(2), first);
}

/// Under a schedule of 1, everyone is present, so the numbers must equal the engine's.
#[test]
fn people_of_zone_lists_and_of_spaces_are_all_present() {
    const PLACE: &str = "zone_or_zonelist_or_space_or_spacelist_name";
    let change = |model: &mut Model| {
        let zones = model.names("Zone");
        let find = |name: &str| zones.iter().find(|zone| zone.eq_ignore_ascii_case(name)).unwrap().clone();
        let [core, south, east] = ["Core_ZN", "Perimeter_ZN_1", "Perimeter_ZN_2"].map(find);
        let activity = model.objects("People")[0].1["activity_level_schedule_name"].clone();
        model.remove_class("People");
        model.insert("Schedule:Constant", "Everyone", json!({"hourly_value": 1.0}));
        let mut people = |name: &str, place: &str, (field, value): (&str, f64)| {
            let method = if field == "number_of_people" { "People" } else { "People/Area" };
            let fields = json!({PLACE: place, field: value, "number_of_people_calculation_method": method,
                "number_of_people_schedule_name": "Everyone", "activity_level_schedule_name": activity});
            model.insert("People", name, fields);
        };
        people("Staff", "Perimeter", ("people_per_floor_area", 0.05));
        people("Guests", "Perimeter", ("number_of_people", 3.0));
        people("Clerks", &core, ("number_of_people", 7.0));
        people("Desks", "Desk Area", ("people_per_floor_area", 0.1));
        people("Storekeepers", "Back", ("number_of_people", 2.0));
        model.insert("ZoneList", "Perimeter", json!({"zones": [{"zone_name": south}, {"zone_name": east}]}));
        model.insert("Space", "Desk Area", json!({"zone_name": core, "floor_area": 60.0}));
        model.insert("Space", "Archive", json!({"zone_name": core, "floor_area": 30.0}));
        let surfaces = model.objects_mut().filter(|(class, ..)| *class == "BuildingSurface:Detailed");
        let of_core = surfaces.filter(|(_, _, surface)| surface["zone_name"] == json!(core));
        for (number, (_, _, surface)) in of_core.enumerate() {
            // The engine makes a space of the floor, which is in neither.
            if !surface["surface_type"].as_str().unwrap().eq_ignore_ascii_case("floor") {
                surface.insert("space_name".into(), ["Desk Area", "Archive"][number % 2].into());
            }
        }
        model.insert("SpaceList", "Back", json!({"spaces": [{"space_name": "Archive"}]}));
    };
    let case = Case::imported_after(
        "RefBldgSmallOfficeNew2004_Chicago.idf",
        "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw",
        change,
    );
    let scheduled = people(&mut case.env_for("01-08..01-08", "constant"));
    let drawn = people(&mut case.env_for("01-08..01-08", "constant+presence2"));
    assert!(scheduled[0].iter().filter(|people| **people > 0.0).count() == 3, "{:?}", scheduled[0]);
    for (drawn, scheduled) in drawn.iter().flatten().zip(scheduled.iter().flatten()) {
        assert!((drawn - scheduled).abs() < 1e-9, "{drawn} people, expected {scheduled}");
    }
}
