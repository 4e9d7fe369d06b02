use std::collections::HashSet;

use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Split};
use serde_json::Value;

use super::shipped::SHIPPED;
use super::*;

#[test]
fn every_shipped_problem_is_valid_and_reads_back_as_written() {
    for problem in Problem::all() {
        problem.check().unwrap();
        let text = serde_json::to_string(problem).unwrap();
        assert_eq!(serde_json::from_str::<Problem>(&text).unwrap(), *problem);
        assert_eq!(problem.changes(), Some(vec![]), "{}", problem.name);
        assert!(!problem.test.sizes.is_empty() && !problem.train.sizes.is_empty());
    }
    let names: HashSet<_> = Problem::all().iter().map(|problem| &problem.name).collect();
    let hashes: HashSet<_> = Problem::all().iter().map(Problem::hash).collect();
    assert_eq!((names.len(), hashes.len()), (SHIPPED.len(), SHIPPED.len()));
}

#[test]
fn operation_is_tested_in_five_periods_at_two_tariffs() {
    for problem in Problem::all().iter().filter(|problem| problem.name.starts_with("operate-")) {
        let tasks = || problem.test.tasks.iter().chain(&problem.train.tasks);
        assert!(tasks().all(|task| task.is_operation() && task.preview.is_some()), "{}", problem.name);
        let tariffs: HashSet<_> = tasks().map(|task| task.tariff.as_ref().map(|each| each.name())).collect();
        assert!(tariffs.contains(&None) && tariffs.contains(&Some("tou")), "{}", problem.name);
        assert_eq!(problem.protocol.windows.len(), 5, "{}", problem.name);
    }
}

#[test]
fn no_environment_is_on_both_sides() {
    for problem in Problem::all() {
        let environments = |side: &Side| {
            let restriction = side.restriction.map(|each| each.to_string());
            let tasks: Vec<_> =
                side.tasks.iter().map(|task| (task.to_string(), restriction.clone())).collect();
            let of = |id: BuildingId| tasks.iter().map(move |task| (id, task.clone()));
            side.buildings.ids().into_iter().flat_map(of).collect::<HashSet<_>>()
        };
        let (train, test) = (environments(&problem.train), environments(&problem.test));
        assert!(train.is_disjoint(&test), "{}", problem.name);
        for id in problem.train.buildings.ids() {
            assert_eq!(b2b_dataset::row(id).split, Split::Train, "{}", problem.name);
        }
    }
}

#[test]
fn sides_have_the_documented_numbers_of_buildings() {
    let counts = |name: &str| {
        let problem = Problem::named(name).unwrap();
        (problem.train.buildings.ids().len(), problem.test.buildings.ids().len())
    };
    assert_eq!(counts("dynamics-house"), (900, 100));
    assert_eq!(counts("retail-to-warehouse"), (900, 100));
    assert_eq!(counts("unitary-5-10"), (1, 1));
    assert_eq!(counts("four-types"), (3600, 20));
    assert_eq!(counts("small-to-offices"), (1800, 40));
    assert_eq!(counts("operate-warehouse"), (900, 8));
    assert_eq!(counts("operate-all"), (5400, 48));
    assert_eq!(counts("operate-goal"), (1, 1));
    assert_eq!(counts("adapt-house"), (900, 8));
    assert_eq!(counts("adapt-house-faults"), (900, 20));
    assert_eq!(counts("adapt-office-small-faults"), (900, 20));
    let custom = Problem::cross_domain(
        &[BuildingType::RetailStandalone, BuildingType::RestaurantFastFood],
        &[BuildingType::OfficeSmall, BuildingType::OfficeMedium],
    );
    let custom = custom.unwrap();
    assert_eq!((custom.train.buildings.ids().len(), custom.test.buildings.ids().len()), (1800, 200));
    assert_eq!(custom.changes(), None, "it is not a shipped problem");
}

fn refused(name: &str, changes: Value) -> String {
    let changes: Changes = serde_json::from_value(changes).unwrap();
    Problem::named(name).unwrap().with(&changes).unwrap_err().to_string()
}

#[test]
fn other_tasks_have_observations_of_other_sizes() {
    let sizes = |name: &str, left_out: Option<&str>| {
        let problem = Problem::all().iter().find(|problem| problem.name == name).unwrap().clone();
        let changes = Changes { left_out: left_out.map(str::to_owned), ..Changes::default() };
        problem.with(&changes).unwrap().test.sizes.len()
    };
    let name = "goal-leave-one-out";
    assert!(sizes(name, None) > 0);
    assert_eq!(sizes(name, Some("constant")), 0, "23 slots are of a task by occupancy");
}

#[test]
fn a_problem_that_cannot_measure_generalization_is_an_error_that_names_the_fault() {
    use serde_json::json;
    let cases = [
        (
            "dynamics-house",
            json!({"train": ["SingleFamilyHouse-1", "SingleFamilyHouse-2"], "test": ["SingleFamilyHouse-2"]}),
            ["buildings are on both sides", "SingleFamilyHouse-0002"],
        ),
        ("dynamics-office-small", json!({"train": ["OfficeSmall-0515"]}), ["test split", "OfficeSmall-0515"]),
        (
            "goal-energy-weight",
            json!({"test_tasks": ["occupancy"]}),
            ["tasks are on both sides", "occupancy"],
        ),
        ("goal-leave-one-out", json!({"left_out": "constant+cost2"}), ["constant+cost2", "random+energy0.5"]),
        ("unitary-5-10", json!({"test": ["OfficeSmall-0003"]}), ["same buildings", "unitary-5-10"]),
        ("dynamics-house", json!({"fallback": "pin"}), ["no actuators are withheld", "dynamics-house"]),
        ("dynamics-house", json!({"seeds": [1, 1]}), ["seed 1", "twice"]),
        ("dynamics-house", json!({"steps_per_hour": 7}), ["steps_per_hour is 7", "60"]),
        (
            "adapt-house",
            json!({"windows": ["01-08..01-14", "01-14..01-20"]}),
            ["keep their memory", "01-08..01-14 does not end before 01-14..01-20"],
        ),
        (
            "operate-house",
            json!({"memory": "building"}),
            ["keep their memory", "peak-heating does not end before typical-heating"],
        ),
        (
            "dynamics-house",
            json!({"test": ["SingleFamilyHouse-1", "SingleFamilyHouse-1"]}),
            ["twice", "SingleFamilyHouse-0001"],
        ),
        ("dynamics-house", json!({"test": ["OfficeSmall-515"]}), ["SingleFamilyHouse", "OfficeSmall"]),
    ];
    for (name, changes, expected) in cases {
        let said = refused(name, changes);
        assert!(expected.iter().all(|word| said.contains(word)), "{said}");
    }
    let types = [BuildingType::Warehouse, BuildingType::OfficeSmall];
    let said = Problem::cross_domain(&types[1..], &types[1..]).unwrap_err().to_string();
    assert!(said.contains("OfficeSmall alone") && said.contains("dynamics"), "{said}");
    Problem::cross_domain(&types, &types).unwrap();
}

#[test]
fn an_unknown_name_is_an_error_with_similar_names() {
    for (name, near) in [
        ("dynamics-hous", "dynamics-house"),
        ("unitary-5-11", "unitary-5-10"),
        ("Dynamics_House", "dynamics-house"),
        ("goal-setpoints", "goal-setpoint-mode"),
    ] {
        let said = Problem::named(name).unwrap_err().to_string();
        assert!(said.contains(name) && said.contains(near), "{said}");
    }
    let said = Problem::named("xyz").unwrap_err().to_string();
    assert!(said.contains("xyz") && said.contains("b2b benchmark list"), "{said}");
}

#[test]
fn an_invalid_file_is_an_error_that_names_the_fault() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.json");
    let mut value = serde_json::to_value(Problem::named("dynamics-house").unwrap()).unwrap();
    value["name"] = "mine".into();
    let write = |value: &Value| std::fs::write(&path, value.to_string()).unwrap();
    write(&value);
    assert_eq!(Problem::read(&path).unwrap().name, "mine");
    for (pointer, wrong, word) in [
        ("/train/buildings/types/0", Value::from("SingleFamilyHous"), "SingleFamilyHouse"),
        ("/test/tasks/0", "constnt".into(), "constnt"),
        ("/test/buildings/split", "validation".into(), "test_small"),
        ("/protocol/windows/0", "winters".into(), "winters"),
        ("/family", "goals".into(), "goal_adaptation"),
        ("/train/buildings/split", "test".into(), "test split"),
    ] {
        let mut other = value.clone();
        *other.pointer_mut(pointer).unwrap() = wrong;
        write(&other);
        let said = Problem::read(&path).unwrap_err().to_string();
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}

#[test]
fn a_changed_problem_has_another_hash_and_lists_its_changes() {
    let problem = Problem::named("dynamics-house").unwrap();
    let changes: Changes =
        serde_json::from_str(r#"{"windows": ["01-10..01-11"], "attributes": "given"}"#).unwrap();
    let other = problem.clone().with(&changes).unwrap();
    assert_ne!(other.hash(), problem.hash());
    let changed = other.changes().unwrap();
    assert_eq!(changed, ["protocol.attributes", "protocol.training_period", "protocol.windows"]);
    let reworded = Problem { question: "Does it?".into(), ..problem.clone() };
    assert_eq!((reworded.hash(), reworded.changes()), (problem.hash(), Some(vec![])));
}

#[test]
fn a_test_building_is_not_for_training() {
    let house = Problem::named("dynamics-house").unwrap();
    let id = house.test.buildings.ids()[0];
    let said = house.check_training_building(id).unwrap_err().to_string();
    assert!(said.contains(&id.to_string()) && said.contains("test building"), "{said}");
    house.check_training_building(house.train.buildings.ids()[0]).unwrap();
    let office = Problem::named("unitary-5-10").unwrap();
    assert!(office.check_training_building(id).is_err());
}
