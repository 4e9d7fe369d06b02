//! The search on made-up buildings: what it is told is a function of the parameters.

use std::cell::Cell;

use b2b_building::BuildingType;

use super::*;

fn plan(seed: u64) -> Plan {
    let class = Class::new(BuildingType::OfficeSmall, Some("5B"));
    let buildings = training_buildings(class, 3, seed).unwrap();
    let periods = ["01-08..01-08".parse().unwrap()];
    Plan::new(class, &buildings, &periods, &"occupancy".parse().unwrap(), seed)
}

/// The best is at a lift of 15 K and a least flow of 0.3.
fn made_up(parameters: &ReactiveParameters) -> Result<Vec<Outcome>> {
    let off = (parameters.unitary.heating_lift - 15.0) / 10.0;
    let flow = parameters.unitary.least_flow - 0.3;
    let loss = |weight: f64| -weight * (0.01 + off * off + flow * flow);
    let outcome = |weight| Outcome { episode_return: loss(weight), steps: 1, ..Outcome::default() };
    Ok([1.0, 5.0, 100.0].map(outcome).to_vec())
}

fn run(plan: &Plan, evaluations: usize, file: &Path) -> (Tuned, usize) {
    let count = Cell::new(0);
    let counted = |parameters: &ReactiveParameters| {
        count.set(count.get() + 1);
        made_up(parameters)
    };
    (tune(plan, evaluations, file, "b2b tune", counted, |_, _| ()).unwrap(), count.get())
}

#[test]
fn the_search_comes_near_the_best_and_is_never_worse_than_the_defaults() {
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
fn a_tuning_goes_on_where_it_was_interrupted_and_comes_to_the_same() {
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
    let other = tune(&plan(2), 2, &file, "", made_up, |_, _| ()).unwrap_err().to_string();
    assert!(other.contains("another tuning") && other.contains("\"seed\":1"), "{other}");
    let broken = std::fs::read_to_string(&file).unwrap().replace("\"values\"", "\"value\"");
    std::fs::write(&file, broken).unwrap();
    let said = tune(&plan(1), 2, &file, "", made_up, |_, _| ()).unwrap_err().to_string();
    assert!(said.contains("value"), "{said}");
}

#[test]
fn buildings_to_tune_on_are_training_buildings_of_the_class() {
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
fn the_score_is_a_percentile_over_buildings_that_weigh_alike() {
    let outcomes =
        |returns: [f64; 5]| returns.map(|episode_return| Outcome { episode_return, ..Outcome::default() });
    let defaults = outcomes([-1.0, -10.0, -100.0, -1.0, -2.0]);
    assert_eq!(score(&defaults, &defaults), -1.0);
    // Relative: -2, -1, -0.5, -0.5, -0.5.
    assert_eq!(score(&defaults, &outcomes([-2.0, -10.0, -50.0, -0.5, -1.0])), -1.0);
    assert_eq!(percentile_25(vec![-3.0, -1.0]), -2.5);
}

#[test]
fn parameters_whose_actuators_hunt_are_not_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let chosen = |restless: f64| {
        // The warmer the supply, the better, but beyond a lift of 12 K one building's actuators are restless.
        let evaluate = |parameters: &ReactiveParameters| {
            let lift = parameters.unitary.heating_lift;
            let outcome =
                |daily_travel| Outcome { episode_return: lift - 30.0, steps: 1, energy: 0.0, daily_travel };
            Ok([1.0, 1.0, if lift > 12.0 { restless } else { 1.0 }].map(outcome).to_vec())
        };
        let file = folder.path().join(restless.to_string());
        tune(&plan(0), 30, &file, "", evaluate, |_, _| ()).unwrap()
    };
    let (restless, calm) = (chosen(9.0), chosen(2.0));
    assert!(restless.parameters.unitary.heating_lift <= 12.0 && restless.measured.daily_travel == 1.0);
    assert!(calm.parameters.unitary.heating_lift > 12.0 && calm.measured.score > restless.measured.score);
}
