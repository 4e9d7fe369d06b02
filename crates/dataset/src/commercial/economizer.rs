//! Economizers where the code requires them.

use b2b_building::Model;
use serde_json::json;

/// The economizer of the code in a climate zone, and its dry-bulb limit, °C.
struct Economizer {
    control: &'static str,
    limit: Option<f64>,
}

/// ASHRAE 90.1-2019, table 6.5.1-1 (where) and 6.5.1.1.3 (high limits): none in very hot zones; a fixed dry bulb of
/// 65 °F in humid zones 2 to 4; differential dry bulb elsewhere.
fn of_zone(ashrae_zone: &str) -> Economizer {
    match ashrae_zone {
        "1A" | "1B" => Economizer { control: "NoEconomizer", limit: None },
        "2A" | "3A" | "4A" => Economizer { control: "FixedDryBulb", limit: Some(18.3) },
        _ => Economizer { control: "DifferentialDryBulb", limit: None },
    }
}

/// Sets the economizer of the climate zone on every unit that has one in the prototype. The prototype is in zone 5B,
/// where all units of 54,000 Btu/h and more have one; smaller units need none in any zone.
pub(super) fn choose(model: &mut Model, ashrae_zone: &str) {
    const CLASS: &str = "Controller:OutdoorAir";
    const CONTROL: &str = "economizer_control_type";
    let economizer = of_zone(ashrae_zone);
    for name in model.names(CLASS) {
        let Some(fields) = model.get_mut(CLASS, &name) else { continue };
        if fields.get(CONTROL).is_none_or(|control| control == "NoEconomizer") {
            continue;
        }
        fields.insert(CONTROL.into(), economizer.control.into());
        if let Some(limit) = economizer.limit {
            fields.insert("economizer_maximum_limit_dry_bulb_temperature".into(), json!(limit));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_zone(zone: &str, control: &str) -> String {
        let mut model = Model::default();
        model.insert("Controller:OutdoorAir", "C", json!({"economizer_control_type": control}));
        choose(&mut model, zone);
        model.get("Controller:OutdoorAir", "C").unwrap()["economizer_control_type"].as_str().unwrap().into()
    }

    #[test]
    fn the_economizer_follows_the_zone() {
        for (zone, expected) in [
            ("1A", "NoEconomizer"),
            ("2A", "FixedDryBulb"),
            ("2B", "DifferentialDryBulb"),
            ("5A", "DifferentialDryBulb"),
            ("8", "DifferentialDryBulb"),
        ] {
            assert_eq!(in_zone(zone, "DifferentialDryBulb"), expected, "{zone}");
        }
    }

    #[test]
    fn a_small_unit_gets_no_economizer() {
        assert_eq!(in_zone("8", "NoEconomizer"), "NoEconomizer");
    }
}
