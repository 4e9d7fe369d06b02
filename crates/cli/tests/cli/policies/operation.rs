//! How controllers rank in an operation task, in one small office for a week of January and of July.

use serde_json::Value;

use crate::program::json;

/// The figures of a policy in January and in July.
struct Read {
    score: f64,
    /// Cost divided by the baseline's.
    cost: f64,
    /// K·h per zone.
    discomfort: f64,
    /// Whether discomfort exceeds the baseline's by more than the free allowance.
    marked: bool,
}

fn read(folder: &std::path::Path, policy: &str) -> [Read; 2] {
    let summary = json(
        folder,
        &format!(
            "evaluate OfficeSmall-0509 --policy {policy} --task operate --period 01-09..01-15 07-10..07-16 --out {policy}"
        ),
    );
    let windows = summary["windows"].as_array().expect("an array of windows");
    let of = |window: &Value| {
        let all = &window["all"];
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        Read {
            score: number(&all["scores"]["median"]["value"]),
            cost: number(&all["relative_resource"]),
            discomfort: number(&all["discomfort_k_h"]),
            marked: all["uncomfortable"] == 1,
        }
    };
    [of(&windows[0]), of(&windows[1])]
}

#[test]
fn nobody_gains_by_freezing_people_or_by_holding_one_temperature() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let of = |policy| read(folder.path(), policy);
    let (guideline, own, reactive) = (of("guideline36"), of("own"), of("reactive"));
    let (hold, off) = (of("hold"), of("off"));
    for season in 0..2 {
        let scores = [&guideline, &own, &reactive, &hold, &off].map(|read| read[season].score);
        assert!((scores[0] - 1.0).abs() < 1e-12 && !guideline[season].marked, "{scores:?}");
        // Everything off costs least, and is the worst of all.
        assert!(off[season].cost < 0.5 && off[season].marked, "{}", off[season].cost);
        assert!(scores[..4].iter().all(|score| *score < 0.5 * scores[4]), "{scores:?}");
        // 22.5 °C day and night is comfortable, and costs more than setbacks.
        assert!(!hold[season].marked && hold[season].discomfort < 2.0, "{}", hold[season].discomfort);
        assert!(scores[3] > 1.2 && scores[2] > 1.2, "{scores:?}");
        assert!((scores[3] - hold[season].cost).abs() < 1e-9, "comfort gains nothing");
    }
    // The model's own thermostats cost no more in January, but let people freeze in the morning, which does not pay.
    assert!(own[0].cost < 1.0 && own[0].marked && own[0].score > 1.1, "{} {}", own[0].cost, own[0].score);
}

/// Exhaust fans draw outdoor air, which the load of a thermostat includes.
#[test]
fn thermostats_hold_a_kitchen_with_exhaust_fans_at_its_setpoint() {
    let folder = tempfile::tempdir().unwrap();
    for controls in ["--controller own", "--control setpoints"] {
        let day = "run RestaurantFastFood --period 01-09..01-09 --out x";
        let said = json(folder.path(), &format!("{day} {controls}"));
        for zone in said["zones"].as_array().unwrap() {
            let discomfort = zone["discomfort_k_h"].as_f64().unwrap();
            assert!(discomfort < 2.0, "{controls}: {discomfort} K·h in {}", zone["name"]);
        }
        assert!(said["heating_wh_m2"].as_f64().unwrap() > 500.0, "{controls}: the air is heated");
    }
}
