//! A client gets the same indicators as an episode in this process under the same actions.

use std::sync::Arc;

use b2b_control::{AnyController, Case, kind};
use b2b_env::{Env, EpisodeConfig, EpisodeMetrics, Metrics};
use serde_json::{Value, json};

use crate::server::Office;

/// A day from 9 January on under the guideline's sequences, whose actions are changed. The run period is the server's,
/// because the engine averages the sun over the next 20 days of it.
fn day(office: &Office, task: &str, change: impl Fn(usize, &mut [f64])) -> Metrics {
    let (weather, period) = (office.weather.clone(), "01-09..12-31".parse().unwrap());
    let config = EpisodeConfig { weather, period, steps_per_hour: 12, task: task.parse().unwrap() };
    let mut env = Env::new(office.library.clone(), Arc::clone(&office.building), config).unwrap();
    let spaces = Arc::clone(env.spaces());
    let kind = kind("guideline36").unwrap();
    let values = kind.tuned(&spaces.building, &spaces.episode.task);
    let case = Case { spaces: &spaces, action: &spaces.action, seed: 0, values: &values };
    let mut controller: Box<dyn AnyController> = kind.make(&case).unwrap();
    controller.reset();
    let mut action = vec![0.0; spaces.action.len()];
    env.truncate_after(288);
    let mut observation = env.reset().unwrap().to_vec();
    for number in 0.. {
        controller.act(&observation, &mut action);
        change(number, &mut action);
        let step = env.step(&action).unwrap();
        observation.copy_from_slice(step.observation);
        if step.truncated {
            break;
        }
    }
    env.metrics().clone()
}

fn assert_same(indicators: &Value, metrics: &Metrics) {
    let metrics = EpisodeMetrics::from(metrics);
    for (name, value) in [
        ("tdis_tot", metrics.tdis_tot),
        ("ener_tot", metrics.ener_tot),
        ("cost_tot", metrics.cost_tot),
        ("emis_tot", metrics.emis_tot),
        ("pele_tot", metrics.pele_tot),
        ("pgas_tot", metrics.pgas_tot),
        ("pdih_tot", metrics.pdih_tot),
    ] {
        let same = match (indicators[name].as_f64(), value) {
            (Some(here), Some(there)) => (here - there).abs() <= 1e-9 * there.abs().max(1.0),
            (here, there) => here == there,
        };
        assert!(same, "{name}: {} and {value:?}", indicators[name]);
    }
}

#[test]
fn the_indicators_of_a_day_equal_an_episodes_under_the_same_actions() {
    let office = Office::new();
    let mut server = office.serve(1);
    let client = server.client();
    // 9 January, a Monday; the client overrides an actuator from noon on.
    client.put("initialize", json!({"start_time": 8 * 86_400, "warmup_period": 0}));
    let inputs = client.get("inputs");
    let (name, about) = inputs.as_object().unwrap().iter().find(|(name, _)| name.ends_with("_u")).unwrap();
    let [low, high] = ["Minimum", "Maximum"].map(|bound| about[bound].as_f64().unwrap());
    let (unit, value) = (about["Unit"].as_str().unwrap(), 0.7 * low + 0.3 * high);
    let own = if unit == "K" { value - 273.15 } else { value };
    let activation = name.replace("_u", "_activate");
    for hour in 0..24 {
        let arguments = if hour < 12 { json!({}) } else { json!({name: value, activation.clone(): 1}) };
        let measured = client.advance(arguments);
        assert_eq!(measured["time"].as_f64(), Some(8.0 * 86_400.0 + 3600.0 * f64::from(hour + 1)));
        if hour >= 12 {
            assert_eq!(measured[&activation], 1.0);
        }
    }
    let office_alone = |task| {
        let actuator = office.building.actuators().position(|each| {
            name.trim_end_matches("_u").eq_ignore_ascii_case(&each.name.replace([' ', '-', ':'], "_"))
        });
        let actuator = actuator.expect(name);
        day(&office, task, |step, action| {
            if step >= 144 {
                action[actuator] = own;
            }
        })
    };
    let metrics = office_alone("operate+flat");
    assert!(metrics.operation_energy().unwrap() > 0.0);
    assert_same(&client.get("kpi"), &metrics);
    // The prices of a scenario count from the start of the test, as in BOPTEST.
    client.put("scenario", json!({"electricity_price": "highly_dynamic"}));
    assert_same(&client.get("kpi"), &office_alone("operate+dynamic"));
    server.stop();
}

#[test]
fn what_happens_in_the_warm_up_is_not_counted() {
    let office = Office::new();
    let mut server = office.serve(1);
    let client = server.client();
    let began = client.put("initialize", json!({"start_time": 9 * 86_400 + 43_200, "warmup_period": 86_400}));
    assert_eq!(began["time"], 9.0 * 86_400.0 + 43_200.0);
    let indicators = client.get("kpi");
    assert_eq!([&indicators["ener_tot"], &indicators["tdis_tot"]], [0.0, 0.0]);
    let names = json!(["Core_ZN_air_temperature_y", "time"]);
    let all = json!({"point_names": names, "start_time": 0, "final_time": 4e7});
    let times = client.put("results", all)["time"].as_array().unwrap().clone();
    assert_eq!((times.len(), times[0].as_f64()), (289, Some(8.0 * 86_400.0 + 43_200.0)));
    client.put("step", json!({"step": 300}));
    client.advance(json!({}));
    let whole_day = day(&office, "operate+flat", |_, _| ());
    let counted = client.get("kpi")["ener_tot"].as_f64().unwrap();
    assert!(counted > 0.0 && counted < 0.05 * whole_day.operation_energy().unwrap(), "{counted}");
    server.stop();
}
