//! The sums from which the return of an episode follows for every weight of energy.

use std::fmt;

use b2b_env::{Metrics, RESOURCES, Resource, Task};
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use crate::scores::Baseline;

/// Name of the sum of temperature penalties.
const TEMPERATURE: &str = "temperature_penalty";
/// Name of the discomfort.
pub(crate) const DISCOMFORT: &str = "discomfort";

/// The sums from which the return of an episode follows for every weight and every resource.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReturnTerms {
    /// Sum of the temperature penalties.
    pub temperature_penalty: f64,
    /// Sum of each resource, in the order of [`Resource::ALL`]; `None` if the sums are from before the resource
    /// existed.
    pub used: [Option<f64>; RESOURCES],
    /// Discomfort in an operation task, K·h per zone.
    pub discomfort: Option<f64>,
}

impl ReturnTerms {
    /// Returns the sum of a resource.
    pub fn used(&self, resource: Resource) -> Option<f64> {
        let place = Resource::ALL.iter().position(|each| *each == resource)?;
        self.used[place]
    }

    /// Returns the return under a task's weight and scale; see [`task_for`](crate::task_for) for the scale. NaN if the
    /// sum of the task's resource is unknown.
    pub fn episode_return(&self, task: &Task) -> f64 {
        let used = self.used(task.resource).unwrap_or(f64::NAN);
        -self.temperature_penalty - task.energy_weight / task.energy_scale.unwrap_or(1.0) * used
    }

    /// Returns the baseline of these sums under a task's weight and scale.
    pub fn baseline(&self, task: &Task) -> Baseline {
        let energy = self.used(Resource::ENERGY).unwrap_or(f64::NAN);
        Baseline {
            episode_return: self.episode_return(task),
            energy,
            resource: self.used(task.resource),
            discomfort: self.discomfort,
        }
    }

    /// Returns the known sums by name: the temperature penalties first, the discomfort last.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let resources = Resource::ALL.into_iter().zip(self.used);
        let used = resources.filter_map(|(resource, used)| Some((resource.penalty().sum, used?)));
        let discomfort = self.discomfort.map(|discomfort| (DISCOMFORT, discomfort));
        std::iter::once((TEMPERATURE, self.temperature_penalty)).chain(used).chain(discomfort)
    }
}

impl From<&Metrics> for ReturnTerms {
    fn from(metrics: &Metrics) -> Self {
        Self {
            temperature_penalty: metrics.temperature_penalty,
            used: Resource::ALL.map(|resource| Some(metrics.total(resource.term()))),
            discomfort: metrics.zone_discomfort(),
        }
    }
}

/// A map from names to sums.
impl Serialize for ReturnTerms {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.values())
    }
}

impl<'de> Deserialize<'de> for ReturnTerms {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Sums;

        impl<'de> Visitor<'de> for Sums {
            type Value = ReturnTerms;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("sums by name")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ReturnTerms, A::Error> {
                let (mut temperature_penalty, mut used, mut discomfort) = (None, [None; RESOURCES], None);
                while let Some(name) = map.next_key::<String>()? {
                    let resource = Resource::ALL.iter().position(|each| each.penalty().sum == name);
                    match resource {
                        Some(place) => used[place] = Some(map.next_value()?),
                        None if name == TEMPERATURE => temperature_penalty = Some(map.next_value()?),
                        None if name == DISCOMFORT => discomfort = Some(map.next_value()?),
                        None => _ = map.next_value::<IgnoredAny>()?,
                    }
                }
                let temperature_penalty =
                    temperature_penalty.ok_or_else(|| A::Error::missing_field(TEMPERATURE))?;
                Ok(ReturnTerms { temperature_penalty, used, discomfort })
            }
        }

        deserializer.deserialize_map(Sums)
    }
}
