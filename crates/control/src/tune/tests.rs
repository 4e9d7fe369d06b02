//! Tuning on synthetic buildings, whose outcomes are functions of the parameters.

use std::cell::Cell;

use b2b_building::{BuildingType, Class};
use b2b_dataset::Split;

use super::*;
use crate::Objective;

/// Three buildings for the search, two for the validation.
pub(super) fn plan(seed: u64) -> TuningPlan {
    let class = Class::new(BuildingType::OfficeSmall, Some("5B"));
    let buildings = TrainingBuildings::draw(class, 3, 2, seed).unwrap();
    TuningPlan::comfort(class, &buildings, &["01-08..01-08".parse().unwrap()], seed)
}

fn outcome(temperature_penalty: f64) -> CellOutcome {
    CellOutcome { temperature_penalty, steps: 1, energy: 3.0, daily_travel: 1.0 }
}

/// The optimum is at a heating lift of 15 K and a minimum flow of 0.3.
fn synthetic(parameters: &ReactiveParameters, building: PlanBuilding) -> Result<Vec<CellOutcome>> {
    let off = (parameters.unitary.heating_lift - 15.0) / 10.0;
    let flow = parameters.unitary.min_flow - 0.3;
    let loss = |weight: f64| weight * (0.01 + off * off + flow * flow);
    Ok(match building {
        PlanBuilding::Search(index) | PlanBuilding::Constant(index) => {
            vec![outcome(loss([1.0, 5.0, 100.0][index]))]
        }
        PlanBuilding::Validation(_) => vec![outcome(loss(2.0)), outcome(loss(3.0))],
    })
}

/// Returns the number of outcomes of a building.
fn episodes(building: PlanBuilding) -> usize {
    if matches!(building, PlanBuilding::Validation(_)) { 2 } else { 1 }
}

fn run(plan: &TuningPlan, evaluations: usize, file: &Path) -> (Tuned, usize) {
    let count = Cell::new(0);
    let counted = |parameters: &ReactiveParameters, building| {
        count.set(count.get() + 1);
        synthetic(parameters, building)
    };
    (tune(plan, evaluations, file, "b2b tune", counted, |_| ()).unwrap(), count.get())
}

#[test]
fn the_search_approaches_the_optimum_and_is_never_worse_than_the_defaults() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..5 {
        let (tuned, simulations) = run(&plan(seed), 60, &folder.path().join(seed.to_string()));
        let measured = tuned.measured;
        assert!(measured.relative_loss < 0.2, "{}", measured.relative_loss);
        assert!(measured.loss < 0.2 * measured.default_loss && measured.worst_relative_loss < 0.2);
        // Without racing: 60 sets on three buildings, five sets on two.
        assert!(simulations < 140, "{simulations} of 190 simulations");
        let (alone, _) = run(&plan(seed), 1, &folder.path().join(format!("{seed}-alone")));
        assert_eq!((alone.measured.relative_loss, alone.parameters), (1.0, ReactiveParameters::default()));
    }
}

#[test]
fn a_stalled_search_ends_but_on_air_loops_only_after_it_beats_the_defaults() {
    let folder = tempfile::tempdir().unwrap();
    // Every set but the defaults has this loss.
    let evaluations = |constant_targets: bool, of_others: f64| {
        let plan = TuningPlan { constant_targets, ..plan(0) };
        let simulate = |parameters: &ReactiveParameters, building| {
            let is_default = *parameters == ReactiveParameters::default();
            Ok(vec![outcome(if is_default { 1.0 } else { of_others }); episodes(building)])
        };
        let file = folder.path().join(format!("{constant_targets} {of_others}"));
        let tuned = tune(&plan, 100, &file, "", simulate, |_| ()).unwrap();
        // The search resumes at its end.
        let none = |_: &ReactiveParameters, _| unreachable!();
        assert_eq!(tune(&plan, 100, &file, "", none, |_| ()).unwrap(), tuned);
        tuned.evaluations
    };
    let end = search::UNIFORM + PATIENCE + 1;
    assert_eq!([evaluations(false, 1.0), evaluations(true, 0.5), evaluations(true, 1.0)], [end, end, 100]);
}

#[test]
fn an_interrupted_tuning_run_resumes_and_returns_the_same_result() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let (expected, _) = run(&plan(1), 20, &whole);
    let text = std::fs::read_to_string(&whole).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    // Killed in the middle of an evaluation, and in the middle of the validation.
    for kept in [7, lines.len() - 2] {
        let cut = lines[..kept].join("\n") + "\n" + &lines[kept][..12];
        std::fs::write(&parts, cut).unwrap();
        assert_eq!(run(&plan(1), 20, &parts).0, expected);
        assert_eq!(std::fs::read_to_string(&parts).unwrap(), text);
    }
    assert_eq!(run(&plan(1), 20, &parts), (expected, 0));
}

#[test]
fn evaluations_of_another_plan_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("evaluations");
    run(&plan(1), 2, &file);
    let said = |plan: &TuningPlan| tune(plan, 2, &file, "", synthetic, |_| ()).unwrap_err().to_string();
    let other = said(&plan(2));
    assert!(other.contains("another tuning run") && other.contains("\"seed\":1"), "{other}");
    let energy = said(&plan(1).energy(&ReactiveParameters::default(), 3.0));
    assert!(energy.contains("another tuning run"), "{energy}");
    let broken = std::fs::read_to_string(&file).unwrap().replace("\"values\"", "\"value\"");
    std::fs::write(&file, broken).unwrap();
    assert!(said(&plan(1)).contains("value"));
}

#[test]
fn tuning_uses_training_buildings_of_the_class_and_others_for_validation() {
    for class in Class::all() {
        let drawn = TrainingBuildings::draw(class, 5, 5, 3).unwrap();
        assert_eq!(drawn, TrainingBuildings::draw(class, 5, 5, 3).unwrap());
        assert_ne!(drawn, TrainingBuildings::draw(class, 5, 5, 4).unwrap());
        for id in drawn.all() {
            let row = b2b_dataset::row(id);
            assert_eq!((row.split, row.building.class()), (Split::Train, class));
        }
        assert!(drawn.search.windows(2).all(|pair| pair[0].number() < pair[1].number()));
        assert!(drawn.search.iter().all(|id| !drawn.validation.contains(id)));
    }
    let class = Class::new(BuildingType::Warehouse, Some("8"));
    let said = TrainingBuildings::draw(class, 2000, 5, 0).unwrap_err().to_string();
    assert!(said.contains("2005") && said.contains("Warehouse in zone 8"), "{said}");
}

#[test]
fn parameters_under_which_actuators_hunt_are_not_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let chosen = |hunting: Option<PlanBuilding>| {
        // The loss falls with the heating lift, but above 12 K the actuators of one building hunt.
        let simulate = |parameters: &ReactiveParameters, building| {
            let lift = parameters.unitary.heating_lift;
            let daily_travel = if lift > 12.0 && hunting == Some(building) { 9.0 } else { 1.0 };
            let one = CellOutcome { daily_travel, ..outcome(30.0 - lift) };
            Ok(vec![one; episodes(building)])
        };
        let file = folder.path().join(format!("{hunting:?}"));
        tune(&plan(0), 40, &file, "", simulate, |_| ()).unwrap()
    };
    let steady = chosen(None);
    assert!(steady.parameters.unitary.heating_lift > 15.0);
    for building in [PlanBuilding::Search(2), PlanBuilding::Validation(1)] {
        let hunting = chosen(Some(building));
        assert!(hunting.parameters.unitary.heating_lift <= 12.0 && hunting.measured.daily_travel == 1.0);
    }
}

#[test]
fn a_set_that_does_not_hold_constant_targets_is_not_chosen_on_air_loops() {
    let folder = tempfile::tempdir().unwrap();
    let chosen = |building_type: BuildingType| {
        let class = Class::new(building_type, Some("5B"));
        let buildings = TrainingBuildings::draw(class, 3, 2, 0).unwrap();
        let plan = TuningPlan::comfort(class, &buildings, &["01-08..01-08".parse().unwrap()], 0);
        // The loss by occupancy falls with the gain; above 1.5, constant targets are no longer held.
        let simulate = |parameters: &ReactiveParameters, building| {
            let gain = parameters.air_loop.gains.proportional.max(parameters.unitary.gains.proportional);
            let (constant, occupancy) = (outcome(if gain > 1.5 { 0.5 } else { 0.1 }), outcome(5.0 - gain));
            Ok(match building {
                PlanBuilding::Search(_) => vec![occupancy],
                PlanBuilding::Constant(_) => vec![constant],
                PlanBuilding::Validation(_) => vec![constant, occupancy],
            })
        };
        let file = folder.path().join(building_type.to_string());
        tune(&plan, 60, &file, "", simulate, |_| ()).unwrap().parameters
    };
    let gain = chosen(BuildingType::OfficeMedium).air_loop.gains.proportional;
    assert!((1.3..=1.5).contains(&gain), "{gain}");
    // Otherwise, validation rejects the best sets, until one further down is eligible.
    let gain = chosen(BuildingType::OfficeSmall).unitary.gains.proportional;
    assert!(gain > 0.2 && gain <= 1.5, "{gain}");
}

#[test]
fn the_energy_objective_weighs_energy_and_starts_from_the_comfort_set() {
    let folder = tempfile::tempdir().unwrap();
    let mut comfort = ReactiveParameters::default();
    comfort.unitary.heating_lift = 15.0;
    let plan = plan(0).energy(&comfort, 2.0);
    assert_eq!((plan.objective, plan.starts.len()), (Objective::Energy, 4));
    // Energy grows with the flow.
    let simulate = |parameters: &ReactiveParameters, building| {
        let off = (parameters.unitary.heating_lift - 15.0) / 10.0;
        let one = CellOutcome { energy: 0.5 + parameters.unitary.min_flow, ..outcome(off * off) };
        Ok(vec![one; episodes(building)])
    };
    let tuned = tune(&plan, 40, &folder.path().join("file"), "", simulate, |_| ()).unwrap();
    assert_eq!(tuned.energy_scale, Some(2.0));
    assert!(tuned.parameters.unitary.min_flow < 0.1, "{}", tuned.parameters.unitary.min_flow);
    assert!((tuned.measured.default_loss - (0.25 + 0.25)).abs() < 1e-12);
}
