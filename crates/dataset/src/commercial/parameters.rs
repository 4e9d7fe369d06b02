//! The parameters of a commercial building, and what they may be.

use b2b_building::{BuildingType, Parameter};
use serde::{Deserialize, Serialize};

use super::Prescriptive;
use crate::{Error, Result};

/// The eight parameters of a commercial building. [`bounds`] depend on type and climate zone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommercialParameters {
    /// Multiplier of the code's wall and roof U. From 0.5 to between 2 (zone 1) and 0.597 (zone 8).
    pub envelope: f64,
    /// U of the windows, W/m²K: 0.8 to 1.3 times the code's.
    pub window_u: f64,
    /// Solar heat gain coefficient of the windows: 0.15 to the code's + 0.10.
    pub window_shgc: f64,
    /// Window and glass door area over gross exterior wall area of the whole building, plenum walls included: 0.5 to
    /// 1.5 times the prototype's, and at most the code's 0.40.
    pub window_to_wall: f64,
    /// Multiplier of all leakage through the envelope. From 0.5 to 2 (zones 1 to 3), 1.5 (4, 5) or 1.2 (6 to 8).
    pub infiltration: f64,
    /// Stretch along the building's own x axis: 0.7 to 1.5.
    pub x_scale: f64,
    /// Stretch along the building's own y axis: 0.7 to 1.5.
    pub y_scale: f64,
    /// Angle from true north to the building's y axis, clockwise, degrees: 0 to 360.
    pub north_axis: f64,
}

/// Window-to-wall ratios of the stock prototypes.
const WINDOW_TO_WALL: [(BuildingType, f64); 5] = [
    (BuildingType::OfficeSmall, 0.2120),
    (BuildingType::OfficeMedium, 0.3300),
    (BuildingType::RetailStandalone, 0.0713),
    (BuildingType::RestaurantFastFood, 0.1400),
    (BuildingType::Warehouse, 0.00707),
];
/// Window-to-wall ratio as a share of the prototype's.
const WINDOW_SHARE: (f64, f64) = (0.5, 1.5);
/// Highest window-to-wall ratio of the prescriptive path (ASHRAE 90.1, 5.5.4.2.1).
const MAX_WINDOW_TO_WALL: f64 = 0.40;

/// What the parameters of a type may be in a climate zone, such as `5B`; in the order of the fields of
/// [`CommercialParameters`]. Ranges of the paper's appendix on dataset generation.
///
/// # Errors
/// [`Error::ClimateZone`] for a zone that is none of 1 to 8; [`Error::NotCommercial`] for a house.
pub fn bounds(building_type: BuildingType, ashrae_zone: &str) -> Result<[Parameter; 8]> {
    let code = Prescriptive::of(ashrae_zone)?;
    let windows = prototype_window_to_wall(building_type)?;
    let window_to_wall = [WINDOW_SHARE.0 * windows, (WINDOW_SHARE.1 * windows).min(MAX_WINDOW_TO_WALL)];
    Ok([
        Parameter::new("envelope", "1", 0.5, code.envelope),
        Parameter::new("window_u", "W/m²K", 0.8 * code.window_u, 1.3 * code.window_u),
        Parameter::new("window_shgc", "1", 0.15, (code.window_shgc + 0.10).clamp(0.10, 0.80)),
        Parameter::new("window_to_wall", "1", window_to_wall[0], window_to_wall[1]),
        Parameter::new("infiltration", "1", 0.5, code.infiltration),
        Parameter::new("x_scale", "1", 0.7, 1.5),
        Parameter::new("y_scale", "1", 0.7, 1.5),
        Parameter::new("north_axis", "°", 0.0, 360.0),
    ])
}

fn prototype_window_to_wall(building_type: BuildingType) -> Result<f64> {
    let found = WINDOW_TO_WALL.into_iter().find(|(known, _)| *known == building_type);
    found.map(|(_, ratio)| ratio).ok_or(Error::NotCommercial { building_type })
}

impl CommercialParameters {
    /// Names of the parameters, in the order of the fields.
    pub const NAMES: [&str; 8] = [
        "envelope",
        "window_u",
        "window_shgc",
        "window_to_wall",
        "infiltration",
        "x_scale",
        "y_scale",
        "north_axis",
    ];

    /// The parameters at a point of the unit cube, whose axes are in the order of the fields.
    ///
    /// # Errors
    /// As [`bounds`]; [`Error::Parameter`] when a coordinate is not within 0 and 1.
    pub fn from_unit(unit: [f64; 8], building_type: BuildingType, ashrae_zone: &str) -> Result<Self> {
        let bounds = bounds(building_type, ashrae_zone)?;
        let mut values = [0.0; 8];
        for ((value, share), bound) in values.iter_mut().zip(unit).zip(&bounds) {
            Parameter::new(bound.name, "1", 0.0, 1.0).check(share)?;
            *value = bound.at(share);
        }
        Ok(Self::from_values(values))
    }

    /// The parameters with these values, in the order of the fields. [`CommercialParameters::check`] says whether they
    /// are within bounds.
    pub fn from_values(values: [f64; 8]) -> Self {
        let [envelope, window_u, window_shgc, window_to_wall, infiltration, x_scale, y_scale, north_axis] =
            values;
        Self { envelope, window_u, window_shgc, window_to_wall, infiltration, x_scale, y_scale, north_axis }
    }

    /// What the code asks in a climate zone, with the prototype's shape, window areas and leakage. In cold zones it is
    /// beyond [`bounds`], where the generator insulates better.
    ///
    /// # Errors
    /// As [`bounds`].
    pub fn of_code(building_type: BuildingType, ashrae_zone: &str) -> Result<Self> {
        let code = Prescriptive::of(ashrae_zone)?;
        Ok(Self {
            envelope: 1.0,
            window_u: code.window_u,
            window_shgc: code.window_shgc,
            window_to_wall: prototype_window_to_wall(building_type)?,
            infiltration: 1.0,
            x_scale: 1.0,
            y_scale: 1.0,
            north_axis: 0.0,
        })
    }

    /// The values, in the order of the fields.
    pub fn values(&self) -> [f64; 8] {
        [
            self.envelope,
            self.window_u,
            self.window_shgc,
            self.window_to_wall,
            self.infiltration,
            self.x_scale,
            self.y_scale,
            self.north_axis,
        ]
    }

    /// Whether every parameter is a number within its [`bounds`].
    ///
    /// # Errors
    /// As [`bounds`]; [`Error::Parameter`] naming the first parameter that is not.
    pub fn check(&self, building_type: BuildingType, ashrae_zone: &str) -> Result<()> {
        let bounds = bounds(building_type, ashrae_zone)?;
        Ok(bounds.iter().zip(self.values()).try_for_each(|(bound, value)| bound.check(value))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TYPE: BuildingType = BuildingType::Warehouse;

    #[test]
    fn the_corners_of_the_unit_cube_are_the_bounds() {
        for zone in ["1A", "2B", "3C", "4A", "5B", "6A", "7", "8"] {
            let bounds = bounds(TYPE, zone).unwrap();
            for share in [0.0, 1.0] {
                let corner = CommercialParameters::from_unit([share; 8], TYPE, zone).unwrap();
                corner.check(TYPE, zone).unwrap();
                let expected = bounds.map(|bound| if share == 0.0 { bound.low } else { bound.high });
                assert_eq!(corner.values(), expected);
            }
        }
    }

    #[test]
    fn bounds_are_named_in_the_order_of_the_fields() {
        assert_eq!(bounds(TYPE, "5B").unwrap().map(|bound| bound.name), CommercialParameters::NAMES);
    }

    #[test]
    fn bounds_follow_the_climate_and_the_type() {
        let envelope = |zone| bounds(TYPE, zone).unwrap()[0].high;
        assert_eq!((envelope("1A"), envelope("8")), (2.0, 0.597));
        let windows = |of| bounds(of, "5B").unwrap()[3];
        assert!(windows(TYPE).high < windows(BuildingType::OfficeMedium).low);
        assert_eq!(windows(BuildingType::OfficeMedium).high, 0.40);
    }

    #[test]
    fn a_parameter_out_of_bounds_is_named_with_them() {
        let middle = CommercialParameters::from_unit([0.5; 8], TYPE, "8").unwrap();
        let error = CommercialParameters { envelope: 0.7, ..middle }.check(TYPE, "8").unwrap_err();
        let text = error.to_string();
        assert!(text.contains("envelope") && text.contains("0.7") && text.contains("0.597"), "{text}");
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            let error = CommercialParameters { x_scale: bad, ..middle }.check(TYPE, "8").unwrap_err();
            assert!(error.to_string().contains("x_scale"), "{error}");
            let error = CommercialParameters::from_unit([bad; 8], TYPE, "8").unwrap_err();
            assert!(error.to_string().contains("envelope"), "{error}");
        }
    }

    #[test]
    fn a_house_has_other_parameters() {
        let error = bounds(BuildingType::SingleFamilyHouse, "6A").unwrap_err();
        assert!(error.to_string().contains("SingleFamilyHouse"), "{error}");
    }
}
