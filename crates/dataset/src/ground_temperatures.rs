//! Ground temperatures of a site as fields of the model.

use b2b_climate::Site;
use serde_json::{Map, Value, json};

const MONTHS: [&str; 12] = [
    "january",
    "february",
    "march",
    "april",
    "may",
    "june",
    "july",
    "august",
    "september",
    "october",
    "november",
    "december",
];

/// The monthly fields of a `Site:GroundTemperature:…` object.
pub(crate) fn monthly_fields(site: &Site) -> Value {
    let months = MONTHS.iter().zip(site.ground_temperatures);
    let fields: Map<_, _> =
        months.map(|(month, value)| (format!("{month}_ground_temperature"), json!(value))).collect();
    Value::Object(fields)
}
