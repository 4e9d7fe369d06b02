//! Operation tasks: bands of the model's own thermostats, indicators, bills and the model's own controls.

use std::sync::Arc;

use b2b_building::hvac::Unsupported;
use b2b_building::{BuildingType, PreparedBuilding};
use b2b_dataset::archetype;
use b2b_env::{Env, EpisodeConfig, EpisodeMetrics, PMV_WEIGHT, Term, Trajectory};

use crate::case::{Case, random_episode, random_episode_from};

/// Observations before the first step and after each.
fn rows(first: &[f64], trajectory: &Trajectory, width: usize) -> Vec<Vec<f64>> {
    let rest = trajectory.observations.chunks_exact(width).map(<[f64]>::to_vec);
    std::iter::once(first.to_vec()).chain(rest).collect()
}

fn slot(env: &Env, name: &str) -> usize {
    env.observation_space().slots().iter().position(|slot| slot.name == name).unwrap()
}

/// Heating and cooling setpoint of a zone in the observation at the start of each hour of a day.
fn setpoints(env: &Env, rows: &[Vec<f64>], zone: &str, day: usize) -> Vec<[f64; 2]> {
    let slots = ["heating", "cooling"].map(|word| slot(env, &format!("{zone} band {word} setpoint")));
    (0..24).map(|hour| slots.map(|slot| rows[(24 * day + hour) * 12][slot])).collect()
}

#[test]
fn the_band_of_a_medium_office_is_its_prototype_s() {
    let case = Case::at_home(BuildingType::OfficeMedium);
    // A Monday.
    let mut env = case.env_for("01-09..01-09", "operate");
    let (first, trajectory) = random_episode_from(&mut env, 1);
    let rows = rows(&first, &trajectory, first.len());
    let day = setpoints(&env, &rows, "Core_bottom", 0);
    // PNNL's prototype: 21 and 24 °C from 6 to 22 h on weekdays, 15.6 and 26.7 °C at night, with an hour of recovery
    // before.
    assert!((day[3][0] - 15.6).abs() < 0.05 && (day[3][1] - 26.7).abs() < 0.05, "{day:?}");
    assert!(
        day[8..20].iter().all(|pair| (pair[0] - 21.0).abs() < 0.05 && (pair[1] - 24.0).abs() < 0.05),
        "{day:?}"
    );
    assert!(day.iter().all(|pair| pair[1] - pair[0] > 2.0), "{day:?}");
}

/// Discomfort, bad air, energy, cost, emissions and peak from the observations of an episode alone.
fn by_hand(env: &Env, rows: &[Vec<f64>]) -> [f64; 6] {
    let (hours, space) = (1.0 / 12.0, env.observation_space());
    let zones: Vec<_> = env.building().controlled_zones().map(|zone| zone.name.clone()).collect();
    let (mut discomfort, mut bad_air) = (0.0, 0.0);
    for name in &zones {
        let [temperature, low, high] = ["air temperature", "band heating setpoint", "band cooling setpoint"]
            .map(|word| slot(env, &format!("{name} {word}")));
        for pair in rows.windows(2) {
            let outside = |row: &[f64]| {
                (pair[0][low] - row[temperature]).max(0.0) + (row[temperature] - pair[0][high]).max(0.0)
            };
            discomfort += 0.5 * (outside(&pair[0]) + outside(&pair[1])) * hours / zones.len() as f64;
        }
        let air = slot(env, &format!("{name} CO2 concentration"));
        let above: Vec<f64> = rows.iter().map(|row| (row[air] - 894.0).max(0.0)).collect();
        bad_air +=
            above.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) * hours).sum::<f64>() / zones.len() as f64;
    }
    let energy = |slot: usize| rows[1..].iter().map(|row| row[slot]).sum::<f64>();
    let [electricity, gas] = [space.electricity(), space.gas()].map(energy);
    let quarter = |three: &[Vec<f64>]| three.iter().map(|row| row[space.electricity()]).sum::<f64>() / 0.25;
    let peak = rows[1..].chunks(3).map(quarter).fold(0.0, f64::max);
    let cost = 0.127 * electricity + 0.0365 * gas;
    let emissions = 0.373 * electricity + 0.181 * gas;
    [discomfort, bad_air, (electricity + gas) / 1000.0, cost / 1000.0, emissions / 1000.0, peak / 1000.0]
}

#[test]
fn indicators_follow_from_the_observations() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    let mut env = case.env_for("07-10..07-11", "operate:21-24/15.6-28+co2");
    let (first, trajectory) = random_episode_from(&mut env, 3);
    let metrics = EpisodeMetrics::from(env.metrics());
    let EpisodeMetrics { tdis_tot, idis_tot, ener_tot, cost_tot, emis_tot, pele_tot, .. } = metrics;
    let reported = [tdis_tot, idis_tot, ener_tot, cost_tot, emis_tot, pele_tot].map(Option::unwrap);
    let engine: f64 = env.engine_meters().unwrap().iter().sum();
    let error = (engine / 1000.0 - reported[2]).abs();
    assert!(error < 1e-6 * reported[2], "the engine's meters say {engine} Wh/m²");
    for (reported, expected) in
        reported.into_iter().zip(by_hand(&env, &rows(&first, &trajectory, first.len())))
    {
        assert!((reported - expected).abs() <= 1e-6 * expected, "{reported}, expected {expected}");
        assert!(expected > 0.0);
    }
    assert_eq!(metrics.pdih_tot, None, "no district heat");
}

/// The predicted mean vote as ISO 7730 (2005), annex D, computes it: by substitution.
fn vote([air, radiant, humidity]: [f64; 3], met: f64, clo: f64) -> f64 {
    let (metabolism, insulation) = (met * 58.15, clo * 0.155);
    let pressure = humidity * 10.0 * (16.6536 - 4030.183 / (air + 235.0)).exp();
    let area = if insulation <= 0.078 { 1.0 + 1.29 * insulation } else { 1.05 + 0.645 * insulation };
    let (air_k, radiant_k) = (air + 273.0, radiant + 273.0);
    let mut surface = air_k + (35.5 - air) / (3.5 * (6.45 * insulation + 0.1));
    let convective = |surface: f64| (2.38 * (surface - air_k).abs().powf(0.25)).max(12.1 * 0.1f64.sqrt());
    for _ in 0..2000 {
        let radiation = 3.96e-8 * area * (surface.powi(4) - radiant_k.powi(4));
        let loss = radiation + area * convective(surface) * (surface - air_k);
        surface += 0.1 * (35.7 - 0.028 * metabolism - insulation * loss + 273.0 - surface);
    }
    let radiation = 3.96 * area * ((surface / 100.0).powi(4) - (radiant_k / 100.0).powi(4));
    let losses = 3.05e-3 * (5733.0 - 6.99 * metabolism - pressure)
        + 0.42 * (metabolism - 58.15)
        + 1.7e-5 * metabolism * (5867.0 - pressure)
        + 0.0014 * metabolism * (34.0 - air)
        + radiation
        + area * convective(surface) * (surface - air_k);
    (0.303 * (-0.036 * metabolism).exp() + 0.028) * (metabolism - losses)
}

#[test]
fn the_vote_and_the_air_are_the_zone_s_own_and_observing_them_changes_nothing() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    let [mut plain, mut env] = ["operate:21-24/15.6-28", "operate:21-24/15.6-28+pmv+co2"]
        .map(|task| case.env_for("07-10..07-10", task));
    let without = random_episode(&mut plain, 3);
    let (first, trajectory) = random_episode_from(&mut env, 3);
    let names: Vec<String> = env.building().controlled_zones().map(|zone| zone.name.clone()).collect();
    for own in plain.observation_space().slots() {
        let [here, there] = [&env, &plain].map(|env| slot(env, &own.name));
        assert!(trajectory.observed(here).eq(without.observed(there)), "{}", own.name);
    }
    let rows = rows(&first, &trajectory, first.len());
    let (mut cold_and_warm, mut occupied) = ([0.0; 2], 0.0);
    for (step, pair) in rows.windows(2).enumerate() {
        let mut penalty = 0.0;
        for name in names.iter().filter(|name| pair[0][slot(&env, &format!("{name} occupancy"))] == 1.0) {
            let air = ["air temperature", "mean radiant temperature", "relative humidity"];
            let vote = vote(air.map(|word| pair[1][slot(&env, &format!("{name} {word}"))]), 1.2, 0.5);
            penalty += PMV_WEIGHT * (vote.abs() - 0.5).max(0.0) / names.len() as f64;
            occupied += 1.0;
            cold_and_warm[0] += f64::from(u8::from(vote < -0.5));
            cold_and_warm[1] += f64::from(u8::from(vote > 0.5));
        }
        let rewarded = trajectory.penalties[step][0];
        assert!((rewarded - penalty).abs() < 1e-6 * penalty.max(1.0), "step {step}: {rewarded}, {penalty}");
    }
    let metrics = EpisodeMetrics::from(env.metrics());
    let shares = [metrics.occupied_too_cold, metrics.occupied_too_warm].map(Option::unwrap);
    assert_eq!(shares, cold_and_warm.map(|steps| steps / occupied));
    let air = slot(&env, "Core_ZN CO2 concentration");
    let [night, noon] = [4, 12].map(|hour| rows[12 * hour][air]);
    assert!(400.0 < night && night + 200.0 < noon, "people exhale: {night} ppm at night, {noon} at noon");
}

#[test]
fn energy_of_operation_is_the_sum_of_its_end_uses_without_the_transformer() {
    let case = Case::at_home(BuildingType::OfficeMedium);
    let energy = |task: &str| {
        let mut env = case.env_for("01-09..01-09", task);
        random_episode(&mut env, 2);
        let of_end_uses: f64 = Term::END_USES.into_iter().map(|term| env.metrics().total(term)).sum();
        [env.metrics().total(Term::Energy), of_end_uses]
    };
    let [operation, of_end_uses] = energy("operate");
    assert!((operation - of_end_uses).abs() < 1e-9 * operation, "{operation}, {of_end_uses}");
    let [tracking, the_same] = energy("constant");
    assert!((the_same - of_end_uses).abs() < 0.05 * of_end_uses, "the warm-up differs a little");
    assert!(
        tracking - the_same > 0.5,
        "the losses of the transformer are in the meter: {tracking}, {the_same}"
    );
}

#[test]
fn the_cost_of_the_steps_is_the_bill() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    let mut env = case.env_for("07-10..07-11", "operate+fpl-gsdt-1");
    random_episode(&mut env, 5);
    let bill = env.engine_report().bill;
    let sum: f64 = bill.iter().map(|part| part.cost).sum();
    let cost = env.metrics().total(Term::Cost) * env.building().conditioned_floor_area;
    assert!((sum - cost).abs() < 1e-9 * cost, "{sum}, {cost}");
    assert!(
        bill.iter().any(|part| part.unit == "kW") && bill.iter().any(|part| part.unit == "kWh"),
        "{bill:?}"
    );
}

#[test]
fn the_preview_is_what_follows() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    let mut env = case.env_for("07-10..07-11", "operate+tou+preview");
    let (first, trajectory) = random_episode_from(&mut env, 1);
    let rows = rows(&first, &trajectory, first.len());
    let [now, next, hours] = ["band heating setpoint", "next band heating setpoint", "hours to next band"]
        .map(|word| slot(&env, &format!("Core_ZN {word}")));
    for step in (0..200).step_by(7) {
        let wait = (rows[step][hours] * 12.0).round() as usize;
        assert!((rows[step + wait][now] - rows[step][next]).abs() < 1e-9, "step {step}");
        assert!(rows[step..step + wait].iter().all(|row| row[now] == rows[step][now]), "step {step}");
    }
    let outdoor = env.observation_space().outdoor_temperature();
    let ahead = slot(&env, "outdoor temperature 5 h ahead");
    // The engine interpolates between the hours of the file.
    assert!((rows[10 * 12][ahead] - rows[15 * 12][outdoor]).abs() < 0.6);
    let price = |hour: usize| rows[0][slot(&env, &format!("electricity price {hour} h ahead"))];
    // Mid-peak at 9 h, on-peak at 15 h.
    assert_eq!([price(10), price(16)], [0.0711, 0.16969]);
}

/// A building under its own controls, prepared from the same model.
fn under_own_controls(building_type: BuildingType) -> (Case, Case) {
    let controlled = Case::at_home(building_type);
    let engine = b2b_energyplus::install::Engine::ensure(&mut b2b_energyplus::install::Quiet).unwrap();
    let site = b2b_climate::Site::read(&controlled.weather).unwrap();
    let model = archetype::base_model(building_type, &engine, &controlled.library, &site).unwrap();
    let (weather, library) = (controlled.weather.clone(), controlled.library.clone());
    let own = PreparedBuilding::under_own_controls(
        building_type.name(),
        model,
        &weather,
        &library,
        Unsupported::Refused,
        |_, _| {},
    );
    (controlled, Case { library, building: Arc::new(own.unwrap()), weather })
}

#[test]
fn a_building_under_its_own_controls_keeps_its_own_band() {
    let (controlled, own) = under_own_controls(BuildingType::OfficeSmall);
    assert_eq!((own.building.actuators().count(), &own.building.years), (0, &controlled.building.years));
    let mut env = own.env_for("01-09..01-09", "operate");
    random_episode(&mut env, 0);
    let metrics = EpisodeMetrics::from(env.metrics());
    let discomfort = metrics.tdis_tot.unwrap();
    assert!(discomfort < 1.5, "the model holds its setpoints: {discomfort} K h");
    assert!(metrics.ener_tot.unwrap() > 0.04 && metrics.outdoor_air_per_person > 2.0, "{metrics:?}");
}

#[test]
fn operation_needs_bands_for_a_preview_and_a_valid_tariff() {
    for (text, words) in [
        ("constant+preview", "comfort bands"),
        ("constant+co2", "comfort bands"),
        ("operate+co2+co2", "given twice"),
        ("operate+tuo", "did you mean tou?"),
        ("operate:24-21/15-28", "at least 0.5 K above"),
        ("operate:21-24", "unknown task"),
        ("operate+tou+flat", "second tariff"),
    ] {
        let said = text.parse::<b2b_env::Task>().unwrap_err().to_string();
        assert!(said.contains(words), "{text}: {said}");
    }
}

#[test]
fn days_that_the_weather_does_not_have_are_refused() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    let folder = tempfile::tempdir().unwrap();
    let weather = folder.path().join("january.epw");
    let whole = std::fs::read_to_string(&case.weather).unwrap();
    // Eight lines of header and the hours of January.
    let lines: Vec<&str> = whole.lines().take(8 + 31 * 24).collect();
    std::fs::write(&weather, lines.join("\n")).unwrap();
    let (period, task) = ("01-31..02-01".parse().unwrap(), "operate+preview".parse().unwrap());
    let episode = EpisodeConfig { weather, period, steps_per_hour: 12, task };
    let said = Env::new(case.library.clone(), Arc::clone(&case.building), episode).unwrap_err().to_string();
    assert!(said.contains("january.epw does not have 02-01"), "{said}");
}

#[test]
fn no_column_of_a_trajectory_has_the_name_of_another() {
    let case = Case::at_home(BuildingType::OfficeMedium);
    let env = case.env_for("07-10..07-10", "operate+tou+preview");
    let slots = env.observation_space().slots().iter().map(|slot| slot.name.clone());
    let actuators = env.building().actuators().map(|actuator| actuator.name.clone());
    let names: Vec<String> = slots.chain(actuators).collect();
    let different: std::collections::BTreeSet<&String> = names.iter().collect();
    assert_eq!(different.len(), names.len());
}
