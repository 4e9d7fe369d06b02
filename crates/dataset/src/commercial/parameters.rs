//! The parameters of a commercial building and their bounds.

use b2b_building::{BuildingType, Parameter};
use serde::{Deserialize, Serialize};

use super::Prescriptive;
use crate::{Error, Result};

/// The nine parameters of a commercial building. [`bounds`] depend on type and climate zone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommercialParameters {
    /// U-factor of the exterior walls, W/m²K: 0.5 to 1.3 times the code's.
    pub wall_u: f64,
    /// U-factor of the roofs, W/m²K: 0.5 to 1.3 times the code's.
    pub roof_u: f64,
    /// U-factor of the windows, W/m²K: 0.8 to 1.3 times the code's.
    pub window_u: f64,
    /// Solar heat gain coefficient of the windows: from 0.15 to the code's plus 0.10.
    pub window_shgc: f64,
    /// Window and glass door area over gross exterior wall area of the whole building, plenum walls included: 0.5 to
    /// 1.5 times the prototype's, and at most 0.40 as in the code.
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

/// Wall and roof U-factors relative to the maximum of the code in the climate zone. Values above 1 represent older
/// stock; half the maximum is less than the code's maximum for walls three zones further north.
const OPAQUE_U: [f64; 2] = [0.5, 1.3];
/// Window-to-wall ratio relative to the prototype.
const WINDOW_SHARE: (f64, f64) = (0.5, 1.5);
/// Maximum window-to-wall ratio of the prescriptive path (ASHRAE 90.1, 5.5.4.2.1).
const MAX_WINDOW_TO_WALL: f64 = 0.40;

/// Returns the bounds of the parameters of a type in a climate zone, for example `5B`; in the order of the fields of
/// [`CommercialParameters`]. Ranges are from the paper's appendix on dataset generation, except for walls and roofs.
///
/// # Errors
/// [`Error::ClimateZone`] for a zone outside 1A to 8; [`Error::NotCommercial`] for a house.
pub fn bounds(building_type: BuildingType, ashrae_zone: &str) -> Result<[Parameter; 9]> {
    let code = Prescriptive::of(ashrae_zone)?;
    let windows = prototype_window_to_wall(building_type)?;
    let window_to_wall = [WINDOW_SHARE.0 * windows, (WINDOW_SHARE.1 * windows).min(MAX_WINDOW_TO_WALL)];
    Ok([
        opaque("wall_u", code.wall_u),
        opaque("roof_u", code.roof_u),
        Parameter::new("window_u", "W/m²K", 0.8 * code.window_u, 1.3 * code.window_u),
        Parameter::new("window_shgc", "1", 0.15, (code.window_shgc + 0.10).clamp(0.10, 0.80)),
        Parameter::new("window_to_wall", "1", window_to_wall[0], window_to_wall[1]),
        Parameter::new("infiltration", "1", 0.5, code.infiltration),
        Parameter::new("x_scale", "1", 0.7, 1.5),
        Parameter::new("y_scale", "1", 0.7, 1.5),
        Parameter::new("north_axis", "°", 0.0, 360.0),
    ])
}

/// Returns the bounds of a U-factor from the code's maximum.
const fn opaque(name: &'static str, code: f64) -> Parameter {
    Parameter::new(name, "W/m²K", OPAQUE_U[0] * code, OPAQUE_U[1] * code)
}

fn prototype_window_to_wall(building_type: BuildingType) -> Result<f64> {
    let prototype = building_type.data().prototype.as_ref();
    prototype.map(|prototype| prototype.window_to_wall).ok_or(Error::NotCommercial { building_type })
}

impl CommercialParameters {
    /// Names of the parameters, in the order of the fields.
    pub const NAMES: [&str; 9] = [
        "wall_u",
        "roof_u",
        "window_u",
        "window_shgc",
        "window_to_wall",
        "infiltration",
        "x_scale",
        "y_scale",
        "north_axis",
    ];

    /// Returns the parameters at a point of the unit cube, whose axes are in the order of the fields.
    ///
    /// # Errors
    /// Same as [`bounds`]; [`Error::Parameter`] when a coordinate is not within 0 and 1.
    pub fn from_unit(unit: [f64; 9], building_type: BuildingType, ashrae_zone: &str) -> Result<Self> {
        let bounds = bounds(building_type, ashrae_zone)?;
        let mut values = [0.0; 9];
        for ((value, share), bound) in values.iter_mut().zip(unit).zip(&bounds) {
            Parameter::new(bound.name, "1", 0.0, 1.0).check(share)?;
            *value = bound.at(share);
        }
        Ok(Self::from_values(values))
    }

    /// The parameters with these values, in the order of the fields. [`CommercialParameters::check`] checks the
    /// bounds.
    pub fn from_values(values: [f64; 9]) -> Self {
        let [
            wall_u,
            roof_u,
            window_u,
            window_shgc,
            window_to_wall,
            infiltration,
            x_scale,
            y_scale,
            north_axis,
        ] = values;
        Self {
            wall_u,
            roof_u,
            window_u,
            window_shgc,
            window_to_wall,
            infiltration,
            x_scale,
            y_scale,
            north_axis,
        }
    }

    /// Returns the code's requirements in a climate zone, with the geometry, window areas and leakage of the prototype.
    ///
    /// # Errors
    /// Same as [`bounds`].
    pub fn of_code(building_type: BuildingType, ashrae_zone: &str) -> Result<Self> {
        let code = Prescriptive::of(ashrae_zone)?;
        Ok(Self {
            wall_u: code.wall_u,
            roof_u: code.roof_u,
            window_u: code.window_u,
            window_shgc: code.window_shgc,
            window_to_wall: prototype_window_to_wall(building_type)?,
            infiltration: 1.0,
            x_scale: 1.0,
            y_scale: 1.0,
            north_axis: 0.0,
        })
    }

    /// Returns the values, in the order of the fields.
    pub fn values(&self) -> [f64; 9] {
        [
            self.wall_u,
            self.roof_u,
            self.window_u,
            self.window_shgc,
            self.window_to_wall,
            self.infiltration,
            self.x_scale,
            self.y_scale,
            self.north_axis,
        ]
    }

    /// Checks that every parameter is a number within its [`bounds`].
    ///
    /// # Errors
    /// Same as [`bounds`]; [`Error::Parameter`] naming the first parameter that is not.
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
                let corner = CommercialParameters::from_unit([share; 9], TYPE, zone).unwrap();
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
        let infiltration = |zone| bounds(TYPE, zone).unwrap()[5].high;
        assert_eq!((infiltration("1A"), infiltration("8")), (2.0, 1.2));
        let windows = |of| bounds(of, "5B").unwrap()[4];
        assert!(windows(TYPE).high < windows(BuildingType::OfficeMedium).low);
        assert_eq!(windows(BuildingType::OfficeMedium).high, 0.40);
    }

    #[test]
    fn walls_and_roofs_range_from_half_to_1_3_times_the_code_in_every_zone() {
        for zone in ["1A", "2B", "3C", "4A", "5B", "6A", "7", "8"] {
            let [wall, roof, ..] = bounds(TYPE, zone).unwrap();
            let code = Prescriptive::of(zone).unwrap();
            for (bound, code) in [(wall, code.wall_u), (roof, code.roof_u)] {
                assert_eq!((bound.low, bound.high), (0.5 * code, 1.3 * code));
            }
        }
    }

    #[test]
    fn the_error_for_a_parameter_out_of_bounds_has_its_name_and_bounds() {
        let middle = CommercialParameters::from_unit([0.5; 9], TYPE, "8").unwrap();
        let error = CommercialParameters { infiltration: 1.7, ..middle }.check(TYPE, "8").unwrap_err();
        let text = error.to_string();
        assert!(text.contains("infiltration") && text.contains("1.7") && text.contains("1.2"), "{text}");
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            let error = CommercialParameters { x_scale: bad, ..middle }.check(TYPE, "8").unwrap_err();
            assert!(error.to_string().contains("x_scale"), "{error}");
            let error = CommercialParameters::from_unit([bad; 9], TYPE, "8").unwrap_err();
            assert!(error.to_string().contains("wall_u"), "{error}");
        }
    }

    #[test]
    fn a_house_has_no_commercial_parameters() {
        let error = bounds(BuildingType::SingleFamilyHouse, "6A").unwrap_err();
        assert!(error.to_string().contains("SingleFamilyHouse"), "{error}");
    }
}
