//! Tuning on synthetic buildings, whose outcomes are functions of the parameters.

use std::cell::Cell;

use b2b_building::{BuildingType, Class};
use b2b_dataset::Split;

use super::*;

fn plan(seed: u64) -> Plan {
    let class = Class::new(BuildingType::OfficeSmall, Some("5B"));
    let buildings = training_buildings(class, 3, seed).unwrap();
    let periods = ["01-08..01-08".parse().unwrap()];
    Plan::new(class, &buildings, &periods, &"occupancy".parse().unwrap(), seed)
}

/// The optimum is at a heating lift of 15 K and a minimum flow of 0.3.
fn synthetic(parameters: &ReactiveParameters) -> Result<Vec<Outcome>> {
    let off = (parameters.unitary.heating_lift - 15.0) / 10.0;
    let flow = parameters.unitary.min_flow - 0.3;
    let loss = |weight: f64| -weight * (0.01 + off * off + flow * flow);
    let outcome = |weight| Outcome { episode_return: loss(weight), steps: 1, ..Outcome::default() };
    Ok([1.0, 5.0, 100.0].map(outcome).to_vec())
}

fn run(plan: &Plan, evaluations: usize, file: &Path) -> (Tuned, usize) {
    let count = Cell::new(0);
    let counted = |parameters: &ReactiveParameters| {
        count.set(count.get() + 1);
        synthetic(parameters)
    };
    (tune(plan, evaluations, file, "b2b tune", counted, |_, _| ()).unwrap(), count.get())
}

#[test]
fn the_search_approaches_the_optimum_and_is_never_worse_than_the_defaults() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..5 {
        let (tuned, _) = run(&plan(seed), 40, &folder.path().join(seed.to_string()));
        let measured = tuned.measured;
        assert!(measured.default_score == -1.0 && measured.score > -0.4, "{}", measured.score);
        assert!(measured.penalty < 0.4 * measured.default_penalty);
        let (alone, _) = run(&plan(seed), 1, &folder.path().join(format!("{seed}-alone")));
        assert_eq!((alone.measured.score, alone.parameters), (-1.0, ReactiveParameters::default()));
    }
}

#[test]
fn an_interrupted_tuning_run_resumes_and_returns_the_same_result() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let (expected, count) = run(&plan(1), 12, &whole);
    assert_eq!(count, 12);
    assert_eq!(run(&plan(1), 5, &parts).1, 5);
    // Killed in the middle of a line.
    let mut text = std::fs::read_to_string(&parts).unwrap();
    text.push_str(r#"{"values":[0.1"#);
    std::fs::write(&parts, text).unwrap();
    assert_eq!(run(&plan(1), 12, &parts), (expected.clone(), 7));
    assert_eq!(run(&plan(1), 12, &parts), (expected, 0));
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&parts).unwrap());
}

#[test]
fn evaluations_of_another_plan_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("evaluations");
    run(&plan(1), 2, &file);
    let other = tune(&plan(2), 2, &file, "", synthetic, |_, _| ()).unwrap_err().to_string();
    assert!(other.contains("another tuning run") && other.contains("\"seed\":1"), "{other}");
    let broken = std::fs::read_to_string(&file).unwrap().replace("\"values\"", "\"value\"");
    std::fs::write(&file, broken).unwrap();
    let said = tune(&plan(1), 2, &file, "", synthetic, |_, _| ()).unwrap_err().to_string();
    assert!(said.contains("value"), "{said}");
}

#[test]
fn tuning_uses_training_buildings_of_the_class() {
    for class in Class::all() {
        let drawn = training_buildings(class, 8, 3).unwrap();
        assert_eq!(drawn, training_buildings(class, 8, 3).unwrap());
        assert_ne!(drawn, training_buildings(class, 8, 4).unwrap());
        for id in &drawn {
            let row = b2b_dataset::row(*id);
            assert_eq!((row.split, row.building.class()), (Split::Train, class));
        }
        assert!(drawn.windows(2).all(|pair| pair[0].number() < pair[1].number()));
    }
    let class = Class::new(BuildingType::Warehouse, Some("8"));
    let said = training_buildings(class, 2000, 0).unwrap_err().to_string();
    assert!(said.contains("2000") && said.contains("Warehouse in zone 8"), "{said}");
}

#[test]
fn parameters_under_which_actuators_hunt_are_not_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let chosen = |hunting: f64| {
        // Return rises with the heating lift, but above 12 K the actuators of one building hunt.
        let evaluate = |parameters: &ReactiveParameters| {
            let lift = parameters.unitary.heating_lift;
            let outcome =
                |daily_travel| Outcome { episode_return: lift - 30.0, steps: 1, energy: 0.0, daily_travel };
            Ok([1.0, 1.0, if lift > 12.0 { hunting } else { 1.0 }].map(outcome).to_vec())
        };
        let file = folder.path().join(hunting.to_string());
        tune(&plan(0), 30, &file, "", evaluate, |_, _| ()).unwrap()
    };
    let (hunting, calm) = (chosen(9.0), chosen(2.0));
    assert!(hunting.parameters.unitary.heating_lift <= 12.0 && hunting.measured.daily_travel == 1.0);
    assert!(calm.parameters.unitary.heating_lift > 12.0 && calm.measured.score > hunting.measured.score);
}
