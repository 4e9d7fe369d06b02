//! The reported metrics of an episode.
//!
//! One declaration serves every reader and writer: the record of an evaluation (fields), and results tables, summaries
//! and Python's dictionary (columns).

use serde::{Deserialize, Serialize, Serializer};

use crate::metrics::Metrics;

/// A value of a [`MetricColumn`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MetricValue {
    /// A whole number.
    Count(usize),
    /// Any number.
    Number(f64),
}

/// A named column over [`EpisodeMetrics`].
#[derive(Clone, Copy, Debug)]
pub struct MetricColumn {
    /// Name in tables, summaries and Python.
    pub name: &'static str,
    /// Unit; `1` where there is none.
    pub unit: &'static str,
    /// Reads the column.
    pub get: fn(&EpisodeMetrics) -> MetricValue,
    /// Writes the column; a count is rounded toward zero.
    pub set: fn(&mut EpisodeMetrics, f64),
}

impl MetricValue {
    /// The value as a floating-point number.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::Count(count) => count as f64,
            Self::Number(number) => number,
        }
    }
}

/// The type of a field.
trait Cell {
    fn value(self) -> MetricValue;
    fn from_f64(value: f64) -> Self;
}

impl Cell for usize {
    fn value(self) -> MetricValue {
        MetricValue::Count(self)
    }

    fn from_f64(value: f64) -> Self {
        value as Self
    }
}

impl Cell for f64 {
    fn value(self) -> MetricValue {
        MetricValue::Number(self)
    }

    fn from_f64(value: f64) -> Self {
        value
    }
}

/// Declares the metrics: field, type, name and unit of the column, and how it follows from [`Metrics`].
macro_rules! episode_metrics {
    ($($(#[$doc:meta])* $field:ident: $type:ty = $name:literal, $unit:literal, $of:expr;)*) => {
        /// The metrics of a complete episode. Means are over the zones with both heating and cooling.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct EpisodeMetrics {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl From<&Metrics> for EpisodeMetrics {
            fn from(metrics: &Metrics) -> Self {
                Self { $($field: { let of: fn(&Metrics) -> $type = $of; of(metrics) },)* }
            }
        }

        impl EpisodeMetrics {
            /// All columns, in the order in which they are written.
            pub const COLUMNS: &[MetricColumn] = &[$(MetricColumn {
                name: $name,
                unit: $unit,
                get: |metrics| metrics.$field.value(),
                set: |metrics, value| metrics.$field = Cell::from_f64(value),
            },)*];
        }
    };
}

episode_metrics! {
    /// Steps of the episode.
    steps: usize = "steps", "1", |metrics| metrics.steps;
    /// Return: the sum of the rewards.
    episode_return: f64 = "return", "1", |metrics| metrics.episode_return;
    /// Sum of the temperature penalties, K².
    temperature_penalty: f64 = "temperature_penalty", "K²", |metrics| metrics.temperature_penalty;
    /// Sum of the energy penalties.
    energy_penalty: f64 = "energy_penalty", "1", |metrics| metrics.energy_penalty;
    /// Root mean square deviation from target, K.
    rms_deviation: f64 = "rms_deviation_k", "K", Metrics::rms_deviation;
    /// Root mean square deviation below target of the zones without cooling, K; 0 if there are none.
    rms_heating_only: f64 = "rms_heating_only_k", "K", Metrics::rms_heating_only;
    /// Zones that were never near their target: their rewarded deviation was outside the comfort band in every step.
    zones_never_near_target: usize = "zones_never_near_target", "1", Metrics::zones_never_near_target;
    /// Mean absolute deviation from target, K.
    mean_abs_deviation: f64 = "mean_abs_deviation_k", "K", Metrics::mean_abs_deviation;
    /// Hours outside the task's comfort band.
    hours_outside_band: f64 = "hours_outside_band", "h", Metrics::hours_outside_band;
    /// Thermal discomfort outside the band, mean over all controlled zones, K h.
    discomfort: f64 = "discomfort_k_h", "K h", Metrics::discomfort;
    /// HVAC electricity, Wh/m².
    electricity: f64 = "electricity_wh_m2", "Wh/m²", |metrics| metrics.electricity;
    /// HVAC gas, with other fuels and district energy, Wh/m².
    gas: f64 = "gas_wh_m2", "Wh/m²", |metrics| metrics.gas;
    /// Cost at the task's prices, currency/m².
    cost: f64 = "cost_m2", "currency/m²", |metrics| metrics.cost;
    /// Emissions at the task's factors, kg of CO₂/m².
    emissions: f64 = "emissions_kg_m2", "kg/m²", |metrics| metrics.emissions / 1000.0;
    /// Peak electric HVAC demand, averaged over a step, W/m².
    peak_electricity: f64 = "peak_electricity_w_m2", "W/m²", |metrics| metrics.peak_electricity;
    /// Peak gas demand, averaged over a step, W/m².
    peak_gas: f64 = "peak_gas_w_m2", "W/m²", |metrics| metrics.peak_gas;
    /// Actuator travel, full strokes/day, mean over the actuators.
    daily_travel: f64 = "daily_travel", "1/d", Metrics::daily_travel;
    /// Share of the steps of controlled zones in sustained oscillation: see [`Metrics::oscillating_share`].
    oscillating_share: f64 = "oscillating_share", "1", Metrics::oscillating_share;
    /// Action values that were out of bounds and clamped.
    clamped_actions: usize = "clamped_actions", "1", |metrics| metrics.clamped_actions;
    /// Steps in which the ventilation interlock raised an action.
    ventilation_overrides: usize = "ventilation_overrides", "1", |metrics| metrics.ventilation_overrides;
    /// Outdoor air per person while people are present, L/s; 0 where no system has outdoor air.
    outdoor_air_per_person: f64 = "outdoor_air_l_s_person", "L/s", Metrics::outdoor_air_per_person;
}

impl EpisodeMetrics {
    /// HVAC energy, electricity and gas, Wh/m².
    pub fn energy(&self) -> f64 {
        self.electricity + self.gas
    }

    /// Each column's name with its value.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, MetricValue)> {
        Self::COLUMNS.iter().map(|column| (column.name, (column.get)(self)))
    }

    /// Serializes the columns by name, for `#[serde(flatten, serialize_with = ...)]`.
    ///
    /// # Errors
    /// The errors of the serializer.
    pub fn serialize_columns<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.values())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_reads_and_writes_only_its_own_field() {
        for column in EpisodeMetrics::COLUMNS {
            let mut metrics = EpisodeMetrics::default();
            (column.set)(&mut metrics, 7.0);
            for (name, value) in metrics.values() {
                assert_eq!(value.as_f64(), if name == column.name { 7.0 } else { 0.0 }, "{name}");
            }
        }
        let mut names: Vec<_> = EpisodeMetrics::COLUMNS.iter().map(|column| column.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), EpisodeMetrics::COLUMNS.len());
    }

    #[test]
    fn counts_are_written_without_a_decimal_point() {
        #[derive(Serialize)]
        struct Summary {
            #[serde(flatten, serialize_with = "EpisodeMetrics::serialize_columns")]
            metrics: EpisodeMetrics,
        }
        let metrics = EpisodeMetrics { steps: 288, gas: 1.0, ..EpisodeMetrics::default() };
        let json = serde_json::to_string(&Summary { metrics }).unwrap();
        assert!(
            json.starts_with(r#"{"steps":288,"return":0.0,"#) && json.contains(r#""gas_wh_m2":1.0"#),
            "{json}"
        );
    }
}
