//! Options of an agent's observation.

use std::fmt;
use std::str::FromStr;

use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::Error;

/// The form of an agent's observation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObservationForm {
    /// The observation of the environment, each slot scaled from its bounds to [-1, 1], as in the paper.
    Raw,
    /// Like `raw`, with a slot for every zone role in houses: see [`RoleObservation`](b2b_env::RoleObservation).
    Roles,
    /// Features for control: errors at several scales and their recent mean, changes of temperatures, targets, the
    /// calendar as sines and hours, the previous action and the base controller's. See `docs/training_reference.md`.
    #[default]
    Features,
}

impl fmt::Display for ObservationForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Raw => "raw",
            Self::Roles => "roles",
            Self::Features => "features",
        })
    }
}

impl FromStr for ObservationForm {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        [Self::Raw, Self::Roles, Self::Features]
            .into_iter()
            .find(|form| form.to_string() == text)
            .ok_or_else(|| Error::UnknownObservation { text: text.to_owned() })
    }
}

/// The options of an agent's observation. Deserialized from a table, or from just the name of a form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ObservationOptions {
    /// The form of the environment's observation.
    pub form: ObservationForm,
    /// Whether to append attributes: the building's floor area, climate and envelope
    /// ([`COMMON`](b2b_building::morphology::COMMON)), and the task's energy weight.
    pub attributes: bool,
    /// Hours of outdoor temperature to append as a perfect forecast from the weather file, at most `LONGEST_FORECAST`.
    pub forecast: u32,
    /// Whether to append feedback, from which a recurrent agent learns about its building: the previous action (already
    /// among `features`), the signed square root of the previous reward, and a flag at the first step of an episode.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub feedback: bool,
}

/// Hours of the longest forecast: a week.
pub const LONGEST_FORECAST: u32 = 168;

impl From<ObservationForm> for ObservationOptions {
    fn from(form: ObservationForm) -> Self {
        Self { form, ..Self::default() }
    }
}

/// The options as a table.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Table {
    form: ObservationForm,
    attributes: bool,
    forecast: u32,
    feedback: bool,
}

impl Default for Table {
    fn default() -> Self {
        let ObservationOptions { form, attributes, forecast, feedback } = ObservationOptions::default();
        Self { form, attributes, forecast, feedback }
    }
}

impl<'de> Deserialize<'de> for ObservationOptions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FormOrTable;

        impl<'de> Visitor<'de> for FormOrTable {
            type Value = ObservationOptions;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "raw, roles or features, or a table with `form`, `attributes`, `forecast` and `feedback`",
                )
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                text.parse::<ObservationForm>().map(Into::into).map_err(E::custom)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                let Table { form, attributes, forecast, feedback } =
                    Table::deserialize(MapAccessDeserializer::new(map))?;
                if forecast > LONGEST_FORECAST {
                    let expected = format!("at most {LONGEST_FORECAST} hours");
                    return Err(de::Error::custom(format!("`forecast` is {forecast}; expected {expected}")));
                }
                Ok(ObservationOptions { form, attributes, forecast, feedback })
            }
        }

        deserializer.deserialize_any(FormOrTable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_from_a_table_or_the_name_of_a_form() {
        let read = |text: &str| serde_json::from_str::<ObservationOptions>(text).map_err(|e| e.to_string());
        assert_eq!(read("\"roles\"").unwrap(), ObservationForm::Roles.into());
        let all =
            ObservationOptions { form: ObservationForm::Raw, attributes: true, forecast: 6, feedback: false };
        assert_eq!(read(&serde_json::to_string(&all).unwrap()).unwrap(), all);
        assert!(
            !serde_json::to_string(&all).unwrap().contains("feedback"),
            "files without the option stay the same"
        );
        let with = ObservationOptions { feedback: true, ..all };
        assert_eq!(read(&serde_json::to_string(&with).unwrap()).unwrap(), with);
        assert_eq!(read(r#"{"forecast": 6, "attributes": true, "form": "raw"}"#).unwrap(), all);
        // A slot for each of so many hours would exhaust the memory.
        assert_eq!(read(r#"{"forecast": 168}"#).unwrap().forecast, 168);
        let said = read(r#"{"forecast": 2147483648}"#).unwrap_err().to_string();
        assert!(said.contains("`forecast` is 2147483648; expected at most 168 hours"), "{said}");
        assert!(read("\"row\"").unwrap_err().contains("unknown observation `row`"));
        assert!(read(r#"{"forcast": 6}"#).unwrap_err().contains("unknown field `forcast`"));
    }
}
