//! The numbers of a house that are drawn, by name.

use super::House;

/// A number of a house.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Name of the field of [`House`].
    pub name: &'static str,
    /// Decimals that it is drawn with.
    pub decimals: i32,
    /// The coordinate of [`super::HouseSample::from_unit`] that it follows.
    pub coordinate: usize,
    field: fn(&mut House) -> &mut f64,
}

/// The numbers that are drawn, but for those of the heating system.
pub const NUMBERS: [Number; 17] = [
    number("floor_area", 1, 2, |house| &mut house.floor_area),
    number("aspect", 3, 4, |house| &mut house.aspect),
    number("wall_resistance", 3, 7, |house| &mut house.wall_resistance),
    number("attic_resistance", 3, 7, |house| &mut house.attic_resistance),
    number("foundation_resistance", 3, 7, |house| &mut house.foundation_resistance),
    number("air_changes_50", 3, 8, |house| &mut house.air_changes_50),
    number("window_to_wall", 4, 9, |house| &mut house.window_to_wall),
    number("window_u", 3, 10, |house| &mut house.window_u),
    number("window_shgc", 3, 10, |house| &mut house.window_shgc),
    number("orientation", 1, 11, |house| &mut house.orientation),
    number("occupants", 0, 12, |house| &mut house.occupants),
    number("appliance_use", 3, 13, |house| &mut house.appliance_use),
    number("ventilation", 2, 14, |house| &mut house.ventilation),
    number("heat_recovery", 3, 14, |house| &mut house.heat_recovery),
    number("cooling_cop", 3, 15, |house| &mut house.cooling_cop),
    number("heating_oversizing", 3, 16, |house| &mut house.heating_oversizing),
    number("cooling_oversizing", 3, 17, |house| &mut house.cooling_oversizing),
];

const fn number(
    name: &'static str,
    decimals: i32,
    coordinate: usize,
    field: fn(&mut House) -> &mut f64,
) -> Number {
    Number { name, decimals, coordinate, field }
}

impl Number {
    /// The number in a house.
    pub fn of<'a>(&self, house: &'a mut House) -> &'a mut f64 {
        (self.field)(house)
    }

    /// Lowest and highest value that the models of a house's parts hold for.
    pub fn bounds(&self) -> [f64; 2] {
        let all = House::default().bounded();
        let own = all.iter().find(|(label, ..)| label.split(' ').next() == Some(self.name));
        own.map_or([f64::NEG_INFINITY, f64::INFINITY], |(_, _, bounds)| *bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_bounds_and_a_field_of_its_own() {
        for (index, number) in NUMBERS.iter().enumerate() {
            assert!(number.bounds()[0].is_finite(), "{}", number.name);
            let mut house = House::default();
            *number.of(&mut house) = f64::NAN;
            assert!(house.check().unwrap_err().to_string().contains(number.name));
            assert!(NUMBERS[..index].iter().all(|other| other.name != number.name));
        }
    }
}
