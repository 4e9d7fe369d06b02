//! Sequences of calls made by clients of BOPTEST.

use serde_json::json;

use crate::server::Office;

#[test]
fn a_selected_test_is_separate_and_a_scenario_runs_two_weeks() {
    let office = Office::new();
    let mut server = office.serve(2);
    let anyone = server.client();
    assert_eq!(anyone.send("GET", "/testcases", "").body, r#"[{"testcaseid":"OfficeSmall"}]"#);
    let client = anyone.select("OfficeSmall");
    assert_eq!(anyone.send("GET", &format!("/status{}", client.test()), "").body, "\"Running\"");
    assert_eq!(client.get("name")["name"], "OfficeSmall");
    assert_eq!(client.get("step"), 3600.0);

    let set = client.put("scenario", json!({"time_period": "peak_heat_day", "electricity_price": "dynamic"}));
    assert_eq!(set["electricity_price"], "dynamic");
    assert_eq!(client.get("scenario")["time_period"], "peak_heat_day");
    let start = set["time_period"]["time"].as_f64().unwrap();
    assert_eq!(start % 86_400.0, 0.0);
    client.put("step", json!({"step": 86_400}));
    let mut days = 0;
    loop {
        let measured = client.advance(json!({}));
        let Some(time) = measured["time"].as_f64() else {
            assert_eq!(measured, json!({}), "after the end, there is nothing to measure");
            break;
        };
        days += 1;
        assert_eq!(time, start + 86_400.0 * f64::from(days));
        assert!((230.0..330.0).contains(&measured["outdoor_air_temperature_y"].as_f64().unwrap()));
    }
    assert_eq!(days, 14);
    let indicators = client.get("kpi");
    assert!(indicators["cost_tot"].as_f64().unwrap() > 0.0 && indicators["idis_tot"].is_null());
    assert!(indicators["time_rat"].as_f64().unwrap() >= 0.0);

    let stopped = anyone.send("PUT", &format!("/stop{}", client.test()), "");
    assert_eq!((stopped.status, stopped.body.as_str()), (200, "OK"));
    assert_eq!(anyone.send("GET", &format!("/kpi{}", client.test()), "").status, 400);
    server.stop();
}

#[test]
fn a_forecast_of_the_outdoor_temperature_comes_true() {
    let office = Office::new();
    let mut server = office.serve(1);
    let client = server.client().select("OfficeSmall");
    // A selected test begins at the start of the year by itself.
    let names = json!(["TDryBul", "LowerSetp[Core_ZN]", "PriceElectricPowerDynamic", "Occupancy[Core_ZN]"]);
    let asked = json!({"point_names": names, "horizon": 86_400, "interval": 3600});
    let ahead = client.put("forecast", asked.clone());
    assert_eq!(ahead["time"].as_array().unwrap().len(), 25);
    for hour in 1..=24 {
        let measured = client.advance(json!({}));
        let [here, there] = [&measured["outdoor_air_temperature_y"], &ahead["TDryBul"][hour]]
            .map(|value| value.as_f64().unwrap());
        assert!((here - there).abs() < 0.05, "{hour}: {here} {there}");
        let [here, there] =
            [&measured["Core_ZN_band_heating_setpoint_y"], &ahead["LowerSetp[Core_ZN]"][hour]];
        assert_eq!(here, there, "{hour}");
    }
    let uncertain = json!({"temperature_uncertainty": "high", "solar_uncertainty": "low", "seed": 3});
    let now = |asked: &serde_json::Value| client.put("forecast", asked.clone())["TDryBul"].clone();
    let certain = now(&asked);
    client.put("scenario", uncertain.clone());
    let disturbed = now(&asked);
    assert_ne!(certain, disturbed);
    client.put("scenario", uncertain);
    assert_eq!(disturbed, now(&asked), "a seed has one forecast");
    server.stop();
}
