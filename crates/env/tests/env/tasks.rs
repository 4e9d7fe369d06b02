//! Tasks on the engine: targets follow people or random draws, and rewards and metrics follow from the trajectory.

use std::sync::Arc;

use crate::case::{Case, random_episode, random_episode_from};
use b2b_building::{BuildingType, Class, PreparedBuilding};
use b2b_env::{EnergyScale, Env, Reward, RewardFunction, StepView, Term, Trajectory};

fn office() -> Case {
    Case::at_home(BuildingType::OfficeSmall)
}

/// The observations at the beginning and at the end of each step.
fn steps<'a>(first: &'a [f64], trajectory: &'a Trajectory) -> impl Iterator<Item = (&'a [f64], &'a [f64])> {
    let ends = trajectory.observations.chunks_exact(first.len());
    std::iter::once(first).chain(ends.clone()).zip(ends)
}

fn close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{what}: {found} is not {expected}");
}

/// Slots of a small office's zones and of the energy of a step, by name.
fn slots(env: &Env, what: &str) -> Vec<usize> {
    let slots = env.observation_space().slots().iter().enumerate();
    slots.filter(|(_, slot)| slot.name.ends_with(what)).map(|(index, _)| index).collect()
}

/// Slots of the air temperatures of the controlled zones.
fn temperatures(env: &Env) -> Vec<usize> {
    env.metrics().zones.iter().map(|zone| zone.slot).collect()
}

#[test]
fn an_office_is_set_back_when_it_is_unoccupied() {
    // A Tuesday and a Sunday in January, a Wednesday and a holiday in July, and a Tuesday in April.
    for (day, unoccupied, works) in [
        ("01-03", 18.0, true),
        ("01-08", 18.0, false),
        ("07-05", 26.0, true),
        ("07-04", 26.0, false),
        ("04-04", 21.0, true),
    ] {
        let mut env = office().env_for(&format!("{day}..{day}"), "occupancy");
        let (occupancy, target) = (slots(&env, "occupancy"), slots(&env, "target"));
        let (_, trajectory) = random_episode_from(&mut env, 1);
        assert_eq!((occupancy.len(), target.len()), (5, 5));
        for (occupancy, target) in occupancy.iter().zip(&target) {
            let there: Vec<bool> = trajectory.observed(*occupancy).map(|there| there == 1.0).collect();
            for (there, target) in there.iter().zip(trajectory.observed(*target)) {
                assert_eq!(target, if *there { 21.0 } else { unoccupied }, "{day}");
            }
            let at = |hour: usize| there[hour * 12 - 1];
            assert_eq!((at(3), at(10)), (false, works), "{day}");
        }
    }
}

#[test]
fn targets_of_the_occupancy_task_change_within_a_day_of_every_type() {
    for building_type in BuildingType::ALL {
        let mut env = Case::at_home(building_type).env_for("01-03..01-03", "occupancy");
        let targets = slots(&env, "target");
        let trajectory = random_episode(&mut env, 1);
        let mut different: Vec<f64> = targets.iter().flat_map(|slot| trajectory.observed(*slot)).collect();
        different.sort_by(f64::total_cmp);
        different.dedup();
        assert_eq!(different, [18.0, 21.0], "{building_type}");
    }
}

#[test]
fn a_house_is_empty_at_times_and_occupied_at_night() {
    let mut env = Case::at_home(BuildingType::SingleFamilyHouse).env_for("01-02..01-04", "occupancy");
    let (occupancy, target) = (slots(&env, "occupancy"), slots(&env, "target"));
    let (_, trajectory) = random_episode_from(&mut env, 1);
    let there: Vec<bool> = trajectory.observed(occupancy[0]).map(|there| there == 1.0).collect();
    let targets = trajectory.observed(target[0]);
    assert!(there.iter().zip(targets).all(|(there, target)| target == if *there { 21.0 } else { 18.0 }));
    for day in there.chunks_exact(288) {
        assert!(day[..48].iter().all(|there| *there), "everyone is at home until four");
    }
    assert!(there.contains(&false), "the house is empty at times");
}

/// The reward uses the target observed when the action was chosen.
#[test]
fn rewards_and_metrics_follow_from_the_trajectory() {
    let mut env = office().env_for("01-03..01-03", "occupancy+energy0.5");
    let (first, trajectory) = random_episode_from(&mut env, 2);
    let temperatures = temperatures(&env);
    let targets = slots(&env, "target");
    let [electricity, gas] = ["HVAC electricity", "HVAC non-electric"].map(|name| slots(&env, name)[0]);
    let (mut discomfort, mut penalty, mut energy) = (0.0, 0.0, [0.0; 2]);
    let (mut cost, mut emissions, mut peak) = (0.0, 0.0, 0.0f64);
    for ((before, after), reward) in steps(&first, &trajectory).zip(&trajectory.penalties) {
        let deviations =
            || temperatures.iter().zip(&targets).map(|(zone, slot)| after[*zone] - before[*slot]);
        let squares = deviations().map(|deviation| deviation * deviation).sum::<f64>() / 5.0;
        close(reward[0], squares, "temperature penalty");
        close(reward[1], 0.5 * (after[electricity] + after[gas]), "energy penalty");
        penalty += squares;
        discomfort +=
            deviations().map(|deviation| (deviation.abs() - 1.0).max(0.0) / 12.0).sum::<f64>() / 5.0;
        energy = [energy[0] + after[electricity], energy[1] + after[gas]];
        cost += (after[electricity] * 0.127 + after[gas] * 0.0365) / 1000.0;
        emissions += after[electricity] * 0.373 + after[gas] * 0.181;
        peak = peak.max(after[electricity] * 12.0);
    }
    let metrics = env.metrics();
    close(metrics.temperature_penalty, penalty, "sum of temperature penalties");
    close(metrics.episode_return, -penalty - 0.5 * (energy[0] + energy[1]), "return");
    close(metrics.discomfort(), discomfort, "discomfort");
    close(metrics.total(Term::Cost), cost, "cost");
    close(metrics.total(Term::Emissions), emissions, "emissions");
    close(metrics.total(Term::PeakElectricity), peak, "peak");
    assert!(discomfort > 1.0 && peak > 1.0, "random play is felt: {discomfort} K h, {peak} W/m²");
    let (low, high) = (env.action_space().low(), env.action_space().high());
    for actuator in 0..low.len() {
        let values: Vec<f64> = trajectory.acted(actuator).collect();
        let way: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        close(metrics.travel[actuator], way / (high[actuator] - low[actuator]), "travel");
    }
}

/// The increases of the peak sum up to the peak.
#[test]
fn cost_emissions_and_peak_penalties_match_the_metrics() {
    let case = office();
    for (task, term) in [
        ("constant+cost1", Term::Cost),
        ("constant+carbon1", Term::Emissions),
        ("constant+peak1", Term::PeakElectricity),
    ] {
        let mut env = case.env_for("01-03..01-03", task);
        random_episode_from(&mut env, 3);
        close(env.metrics().energy_penalty, env.metrics().total(term), task);
        assert!(env.metrics().energy_penalty > 0.0, "{task}");
    }
}

#[test]
fn random_targets_follow_their_seed_and_differ_by_zone_and_day() {
    let case = office();
    let targets = |task: &str| -> Vec<Vec<f64>> {
        let mut env = case.env_for("01-03..01-04", task);
        let slots = slots(&env, "target");
        let (_, trajectory) = random_episode_from(&mut env, 4);
        slots.iter().map(|slot| trajectory.observed(*slot).collect()).collect()
    };
    let (one, again, other) = (targets("random:1"), targets("random:1"), targets("random:2"));
    assert!(one == again && one != other);
    let noon: Vec<u64> = one.iter().flat_map(|zone| [zone[143], zone[287 + 144]]).map(f64::to_bits).collect();
    let different: std::collections::BTreeSet<_> = noon.iter().collect();
    assert_eq!(different.len(), 10, "five zones on two days");
    assert!(one.iter().flatten().all(|target| (14.0..=23.0).contains(target)), "winter offsets go down");
}

#[test]
fn an_episode_starts_near_its_target() {
    let case = office();
    for target in [17.0, 24.0] {
        let mut env = case.env_for("01-03..01-03", &format!("constant:{target}"));
        let zones = temperatures(&env);
        let first = env.reset().unwrap();
        let zones: Vec<f64> = zones.iter().map(|slot| first[*slot]).collect();
        assert!(zones.iter().all(|zone| (zone - target).abs() < 2.0), "{target}: {zones:.1?}");
    }
}

/// A reward from only the warmest zone, with the number of steps.
#[derive(Debug, Default)]
struct Warmest {
    steps: f64,
}

impl RewardFunction for Warmest {
    fn reset(&mut self) {
        self.steps = 0.0;
    }

    fn reward(&mut self, step: &StepView<'_>) -> Reward {
        self.steps += 1.0;
        let warmest = step.zones.iter().map(|zone| zone.temperature).fold(f64::NEG_INFINITY, f64::max);
        Reward { temperature_penalty: warmest, energy_penalty: self.steps }
    }
}

#[test]
fn a_custom_reward_replaces_the_task_s() {
    let mut env = office().env_for("01-03..01-03", "constant").with_reward(Warmest::default());
    let zones = temperatures(&env);
    for _ in 0..2 {
        let (_, trajectory) = random_episode_from(&mut env, 5);
        let rows = trajectory.observations.chunks_exact(env.observation_space().len());
        for (step, (row, penalties)) in rows.zip(&trajectory.penalties).enumerate() {
            let warmest = zones.iter().map(|slot| row[*slot]).fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(*penalties, [warmest, step as f64 + 1.0]);
        }
    }
}

#[test]
fn the_class_scales_the_reward_unless_the_task_has_its_own_scale() {
    let house = Case::at_home(BuildingType::SingleFamilyHouse);
    let class = Class::new(BuildingType::SingleFamilyHouse, None);
    let of_class = PreparedBuilding::clone(&house.building).of_class(Some(class));
    let of_class =
        Case { building: Arc::new(of_class), weather: house.weather.clone(), library: house.library.clone() };
    let penalty = |case: &Case, scale: Option<f64>| {
        let mut episode = case.env_for("01-03..01-03", "constant+energy0.5").episode().clone();
        episode.task.energy_scale = scale;
        let mut env = Env::new(case.library.clone(), Arc::clone(&case.building), episode).unwrap();
        random_episode(&mut env, 1);
        let energy = env.metrics().total(Term::Energy);
        assert!(energy > 0.0);
        env.metrics().energy_penalty / energy
    };
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    near(penalty(&house, None), 0.5);
    near(penalty(&of_class, None), 0.5 / EnergyScale::of(class, 12).unwrap());
    near(penalty(&of_class, Some(4.0)), 0.125);
}
