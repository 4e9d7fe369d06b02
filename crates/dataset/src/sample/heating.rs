//! The heating system of a house where settings say what it is.

use crate::Result;
use crate::house::{CUTOFF, FUEL, HEAT_PUMP_COP, HEAT_PUMP_CUTOFF, HEATER_EFFICIENCY, Heater, Heating};
use crate::setting::{self, Setting};

/// Returns a heating system after the settings of its parameters, at a relative position in their ranges. A COP gives the
/// house a heat pump, and `none` takes it away.
pub(super) fn set(drawn: Heating, share: f64, settings: &[Setting]) -> Result<Heating> {
    let given = |name| setting::of(settings, name);
    let heaters = [("electric", Heater::Electric), ("fuel", FUEL)];
    let mut heater = given("heater").map_or(Ok(drawn.heater()), |setting| setting.word(&heaters))?;
    if let Some(setting) = given("heater_efficiency") {
        let Heater::Fuel { efficiency } = &mut heater else {
            return Err(setting.wrong("a house has an electric heater; add heater=fuel".to_owned()));
        };
        *efficiency = setting.number(share, 3, HEATER_EFFICIENCY)?;
    }
    let drawn = match drawn {
        Heating::HeatPump { cop, cutoff, .. } => Some((cop, cutoff)),
        Heating::Furnace(_) => None,
    };
    let mut pump = match given("heat_pump_cop") {
        None => drawn,
        Some(setting) if setting.is("none") => None,
        Some(setting) => {
            let cutoff = drawn.map_or(CUTOFF, |(_, cutoff)| cutoff);
            Some((setting.number(share, 3, HEAT_PUMP_COP)?, cutoff))
        }
    };
    if let Some(setting) = given("heat_pump_cutoff") {
        let Some((_, cutoff)) = &mut pump else {
            return Err(setting.wrong("a house has no heat pump; add heat_pump_cop".to_owned()));
        };
        *cutoff = setting.number(share, 1, HEAT_PUMP_CUTOFF)?;
    }
    Ok(pump.map_or(Heating::Furnace(heater), |(cop, cutoff)| Heating::HeatPump {
        cop,
        cutoff,
        backup: heater,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PUMP: Heating = Heating::HeatPump { cop: 3.0, cutoff: -12.0, backup: Heater::Electric };

    fn after(drawn: Heating, settings: &[&str]) -> Result<Heating> {
        let settings: Vec<Setting> = settings.iter().map(|text| text.parse().unwrap()).collect();
        set(drawn, 0.5, &settings)
    }

    #[test]
    fn a_cop_gives_a_house_a_heat_pump_and_none_a_furnace() {
        let furnace = Heating::Furnace(FUEL);
        assert_eq!(after(PUMP, &[]).unwrap(), PUMP);
        let pump = after(furnace, &["heat_pump_cop=3..4", "heat_pump_cutoff=-20"]).unwrap();
        assert_eq!(pump, Heating::HeatPump { cop: 3.5, cutoff: -20.0, backup: FUEL });
        let best = after(PUMP, &["heat_pump_cop=none", "heater=fuel", "heater_efficiency=0.95"]).unwrap();
        assert_eq!(best, Heating::Furnace(Heater::Fuel { efficiency: 0.95 }));
        assert_eq!(after(furnace, &["heater=electric"]).unwrap(), Heating::Furnace(Heater::Electric));
    }

    #[test]
    fn what_a_house_does_not_have_is_an_error_with_the_remedy() {
        let said = |drawn, text: &str| after(drawn, &[text]).unwrap_err().to_string();
        assert!(said(PUMP, "heater_efficiency=0.9").contains("add heater=fuel"));
        assert!(said(Heating::Furnace(FUEL), "heat_pump_cutoff=-20").contains("add heat_pump_cop"));
        assert!(said(PUMP, "heater=wood").contains("electric or fuel"));
        assert!(said(PUMP, "heat_pump_cop=9").contains("1.5 to 8"));
    }
}
