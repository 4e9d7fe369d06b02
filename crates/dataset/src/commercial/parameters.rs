//! The parameters of a commercial building, and what they may be.

use b2b_building::BuildingType;
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

/// What one parameter may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Name of the field of [`CommercialParameters`].
    pub name: &'static str,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
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
const MOST_WINDOW: f64 = 0.40;

/// What the parameters of a type may be in a climate zone, such as `5B`; in the order of the fields of
/// [`CommercialParameters`]. Ranges of the paper's appendix on dataset generation.
///
/// # Errors
/// [`Error::ClimateZone`] for a zone that is none of 1 to 8; [`Error::NotCommercial`] for a house.
pub fn bounds(building_type: BuildingType, ashrae_zone: &str) -> Result<[Bound; 8]> {
    let code = Prescriptive::of(ashrae_zone)?;
    let windows = prototype_window_to_wall(building_type)?;
    let ranges = [
        (0.5, code.envelope),
        (0.8 * code.window_u, 1.3 * code.window_u),
        (0.15, (code.window_shgc + 0.10).clamp(0.10, 0.80)),
        (WINDOW_SHARE.0 * windows, (WINDOW_SHARE.1 * windows).min(MOST_WINDOW)),
        (0.5, code.infiltration),
        (0.7, 1.5),
        (0.7, 1.5),
        (0.0, 360.0),
    ];
    let bound =
        |index: usize| Bound { name: Bound::NAMES[index], low: ranges[index].0, high: ranges[index].1 };
    Ok(std::array::from_fn(bound))
}

fn prototype_window_to_wall(building_type: BuildingType) -> Result<f64> {
    let found = WINDOW_TO_WALL.into_iter().find(|(known, _)| *known == building_type);
    found.map(|(_, ratio)| ratio).ok_or(Error::NotCommercial { building_type })
}

impl Bound {
    /// Names of the parameters of the commercial types, in order.
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

    /// The value at a share of the way from the lowest (0) to the highest (1).
    fn at(&self, share: f64) -> f64 {
        (self.low + share * (self.high - self.low)).clamp(self.low, self.high)
    }

    /// Whether a value is a number within it.
    ///
    /// # Errors
    /// [`Error::Parameter`] when it is not.
    pub fn check(&self, value: f64) -> Result<()> {
        if (self.low..=self.high).contains(&value) {
            return Ok(());
        }
        Err(Error::Parameter { name: self.name, value, low: self.low, high: self.high })
    }
}

impl CommercialParameters {
    /// The parameters at a point of the unit cube, whose axes are in the order of the fields.
    ///
    /// # Errors
    /// As [`bounds`]; [`Error::Parameter`] when a coordinate is not within 0 and 1.
    pub fn from_unit(unit: [f64; 8], building_type: BuildingType, ashrae_zone: &str) -> Result<Self> {
        let bounds = bounds(building_type, ashrae_zone)?;
        let mut values = [0.0; 8];
        for ((value, share), bound) in values.iter_mut().zip(unit).zip(&bounds) {
            Bound { name: bound.name, low: 0.0, high: 1.0 }.check(share)?;
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
        bounds.iter().zip(self.values()).try_for_each(|(bound, value)| bound.check(value))
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
