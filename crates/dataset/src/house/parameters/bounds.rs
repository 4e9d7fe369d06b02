//! The bounds of a house's parameters, within which the models of its parts are valid.

use b2b_building::Parameter;
use b2b_building::parameter::Field;

use super::{Heater, Heating, House};
use crate::Result;

/// A number of a house.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// The field of [`House`].
    pub field: Field<House>,
    /// Decimals of a drawn value.
    pub decimals: i32,
    /// The coordinate of [`crate::house::HouseSample::from_unit`] that determines it.
    pub coordinate: usize,
}

/// The numeric parameters that are drawn, without the heating system's.
pub const NUMBERS: [Number; 17] = [
    number("floor_area", "m²", [40.0, 1000.0], 1, 2, |house| &mut house.floor_area),
    number("aspect", "1", [1.0, 4.0], 3, 4, |house| &mut house.aspect),
    number("wall_resistance", "m²K/W", [0.6, 15.0], 3, 7, |house| &mut house.wall_resistance),
    number("attic_resistance", "m²K/W", [0.6, 20.0], 3, 7, |house| &mut house.attic_resistance),
    number("foundation_resistance", "m²K/W", [0.6, 10.0], 3, 7, |house| &mut house.foundation_resistance),
    number("air_changes_50", "1/h", [0.1, 40.0], 3, 8, |house| &mut house.air_changes_50),
    number("window_to_wall", "1", [0.01, 0.6], 4, 9, |house| &mut house.window_to_wall),
    number("window_u", "W/m²K", [0.5, 7.0], 3, 10, |house| &mut house.window_u),
    number("window_shgc", "1", [0.05, 0.9], 3, 10, |house| &mut house.window_shgc),
    number("orientation", "°", [0.0, 360.0], 1, 11, |house| &mut house.orientation),
    number("occupants", "1", [0.0, 12.0], 0, 12, |house| &mut house.occupants),
    number("appliance_use", "1", [0.0, 5.0], 3, 13, |house| &mut house.appliance_use),
    number("ventilation", "L/s", [0.0, 200.0], 2, 14, |house| &mut house.ventilation),
    number("heat_recovery", "1", [0.0, 0.95], 3, 14, |house| &mut house.heat_recovery),
    number("cooling_cop", "1", [1.5, 8.0], 3, 15, |house| &mut house.cooling_cop),
    number("heating_oversizing", "1", [1.0, 3.0], 3, 16, |house| &mut house.heating_oversizing),
    number("cooling_oversizing", "1", [0.5, 3.0], 3, 17, |house| &mut house.cooling_oversizing),
];

const fn number(
    name: &'static str,
    unit: &'static str,
    [low, high]: [f64; 2],
    decimals: i32,
    coordinate: usize,
    field: fn(&mut House) -> &mut f64,
) -> Number {
    Number { field: Field::new(Parameter::new(name, unit, low, high), field), decimals, coordinate }
}

impl Number {
    /// Name of the field of [`House`].
    pub fn name(&self) -> &'static str {
        self.field.parameter.name
    }
}

pub(crate) const HEAT_PUMP_COP: Parameter = Parameter::new("heat_pump_cop", "1", 1.5, 8.0);
pub(crate) const HEAT_PUMP_CUTOFF: Parameter = Parameter::new("heat_pump_cutoff", "°C", -30.0, 10.0);
pub(crate) const HEATER_EFFICIENCY: Parameter = Parameter::new("heater_efficiency", "1", 0.5, 1.0);
const FLOW: Parameter = Parameter::new("capacities.flow", "m³/s", 0.02, 5.0);
const COOLING: Parameter = Parameter::new("capacities.cooling", "W", 500.0, 1e5);
const HEATING: Parameter = Parameter::new("capacities.heating", "W", 500.0, 1e5);
const BACKUP: Parameter = Parameter::new("capacities.backup", "W", 500.0, 1e5);

impl House {
    /// Bounds of the number of storeys.
    pub const STOREYS: Parameter = Parameter::new("storeys", "1", 1.0, 2.0);

    /// Checks that every parameter is a number within its bounds.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<()> {
        Self::STOREYS.check(f64::from(self.storeys))?;
        NUMBERS.iter().try_for_each(|number| number.field.check(self))?;
        if let Heating::HeatPump { cop, cutoff, .. } = self.heating {
            HEAT_PUMP_COP.check(cop)?;
            HEAT_PUMP_CUTOFF.check(cutoff)?;
        }
        if let Heater::Fuel { efficiency } = self.heating.heater() {
            HEATER_EFFICIENCY.check(efficiency)?;
        }
        if let Some(sizes) = self.capacities {
            FLOW.check(sizes.flow)?;
            COOLING.check(sizes.cooling)?;
            HEATING.check(sizes.heating)?;
            BACKUP.check(sizes.backup)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_its_own_field() {
        for (index, number) in NUMBERS.iter().enumerate() {
            let mut house = House::default();
            number.field.set(&mut house, f64::NAN);
            assert!(house.check().unwrap_err().to_string().contains(number.name()));
            assert!(NUMBERS[..index].iter().all(|other| other.name() != number.name()));
        }
    }
}
