//! The reported metrics of an episode.
//!
//! One declaration serves every reader and writer: the record of an evaluation (fields), and results tables, summaries
//! and Python's dictionary (columns).

use serde::{Deserialize, Serialize, Serializer};

use crate::metrics::Metrics;
use crate::terms::{Column, Display, Resource, Term, TermMetrics};

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
    /// Description.
    pub doc: &'static str,
    /// How `b2b compare` shows it, if it does.
    pub display: Option<Display>,
    /// Whether the value of an episode may be unknown, for example because the episode was recorded before the metric
    /// existed.
    pub may_be_unknown: bool,
    source: Source,
}

/// The location of a column's values.
#[derive(Clone, Copy, Debug)]
enum Source {
    Field { get: fn(&EpisodeMetrics) -> Option<MetricValue>, set: fn(&mut EpisodeMetrics, f64) },
    Term(Term),
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

impl MetricColumn {
    /// Reads the column; `None` if the value is unknown, for example in an episode recorded before the metric existed.
    pub fn get(&self, metrics: &EpisodeMetrics) -> Option<MetricValue> {
        match self.source {
            Source::Field { get, .. } => get(metrics),
            Source::Term(term) => metrics.terms.get(term).map(MetricValue::Number),
        }
    }

    /// Writes the column; a count is rounded toward zero.
    pub fn set(&self, metrics: &mut EpisodeMetrics, value: f64) {
        match self.source {
            Source::Field { set, .. } => set(metrics, value),
            Source::Term(term) => metrics.terms.set(term, value),
        }
    }

    fn of_term(term: Term) -> Option<Self> {
        let Column { name, unit, doc, display, .. } = *term.entry().column.as_ref()?;
        Some(Self { name, unit, doc, display, may_be_unknown: true, source: Source::Term(term) })
    }
}

/// The type of a field.
trait Cell: Copy {
    /// Whether a value may be unknown.
    const MAY_BE_UNKNOWN: bool = false;

    fn value(self) -> Option<MetricValue>;
    fn from_f64(value: f64) -> Self;
}

impl Cell for usize {
    fn value(self) -> Option<MetricValue> {
        Some(MetricValue::Count(self))
    }

    fn from_f64(value: f64) -> Self {
        value as Self
    }
}

impl Cell for f64 {
    fn value(self) -> Option<MetricValue> {
        Some(MetricValue::Number(self))
    }

    fn from_f64(value: f64) -> Self {
        value
    }
}

/// A metric that is missing in some episodes.
impl Cell for Option<f64> {
    const MAY_BE_UNKNOWN: bool = true;

    fn value(self) -> Option<MetricValue> {
        self.map(MetricValue::Number)
    }

    fn from_f64(value: f64) -> Self {
        Some(value)
    }
}

fn is_unknown(cell: &impl Cell) -> bool {
    cell.value().is_none()
}

/// Declares the metrics that are not terms: documentation, field, type, name and unit of the column, its computation
/// from [`Metrics`], and how `b2b compare` shows it. The columns of the terms are between the two groups.
macro_rules! episode_metrics {
    (
        before { $($(#[doc = $doc:literal])* $field:ident: $type:ty = $name:literal, $unit:literal, $of:expr, $display:expr;)* }
        after { $($(#[doc = $doc2:literal])* $field2:ident: $type2:ty = $name2:literal, $unit2:literal, $of2:expr, $display2:expr;)* }
    ) => {
        /// The metrics of a complete episode. Means are over the zones with both heating and cooling.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct EpisodeMetrics {
            $($(#[doc = $doc])* #[doc = concat!("\n\nUnit: ", $unit)]
            #[serde(skip_serializing_if = "is_unknown")]
            pub $field: $type,)*
            /// The terms.
            #[serde(flatten)]
            pub terms: TermMetrics,
            $($(#[doc = $doc2])* #[doc = concat!("\n\nUnit: ", $unit2)]
            #[serde(skip_serializing_if = "is_unknown")]
            pub $field2: $type2,)*
        }

        impl From<&Metrics> for EpisodeMetrics {
            fn from(metrics: &Metrics) -> Self {
                Self {
                    $($field: { let of: fn(&Metrics) -> $type = $of; of(metrics) },)*
                    terms: (&metrics.terms).into(),
                    $($field2: { let of: fn(&Metrics) -> $type2 = $of2; of(metrics) },)*
                }
            }
        }

        impl EpisodeMetrics {
            /// Returns all columns, in the order in which they are written.
            pub fn columns() -> impl Iterator<Item = MetricColumn> {
                let before = [$(column!($field: $type, $name, $unit, $display, $($doc)*),)*];
                let after = [$(column!($field2: $type2, $name2, $unit2, $display2, $($doc2)*),)*];
                let terms = Term::ALL.into_iter().filter_map(MetricColumn::of_term);
                before.into_iter().chain(terms).chain(after)
            }
        }
    };
}

/// The column of a field.
macro_rules! column {
    ($field:ident: $type:ty, $name:literal, $unit:literal, $display:expr, $($doc:literal)*) => {
        MetricColumn {
            name: $name,
            unit: $unit,
            doc: concat!($($doc),*),
            display: $display,
            may_be_unknown: <$type as Cell>::MAY_BE_UNKNOWN,
            source: Source::Field {
                get: |metrics| metrics.$field.value(),
                set: |metrics, value| metrics.$field = Cell::from_f64(value),
            },
        }
    };
}

const HIGHER_RETURN: Option<Display> =
    Some(Display { label: "return", scale: 1.0, decimals: 1, higher_is_better: Some(true) });
const OUTDOOR_AIR: Option<Display> =
    Some(Display { label: "outdoor air per person (L/s)", scale: 1.0, decimals: 1, higher_is_better: None });

episode_metrics! {
    before {
        /// steps of the episode
        steps: usize = "steps", "1", |metrics| metrics.steps, None;
        /// sum of the rewards, -temperature_penalty - energy_penalty
        episode_return: f64 = "return", "1", |metrics| metrics.episode_return, HIGHER_RETURN;
        /// sum of the temperature penalties (operation: 12 × K, or 36 × vote)
        temperature_penalty: f64 = "temperature_penalty", "K²", |metrics| metrics.temperature_penalty, None;
        /// sum of the energy penalties
        energy_penalty: f64 = "energy_penalty", "1", |metrics| metrics.energy_penalty, None;
        /// RMS deviation from the target, mean over the zones with heating and cooling
        rms_deviation: f64 = "rms_deviation_k", "K", Metrics::rms_deviation,
            Display::lower("RMS deviation (K)", 1.0, 2);
        /// RMS deviation below the target, mean over the zones without cooling; 0 if there are none
        rms_heating_only: f64 = "rms_heating_only_k", "K", Metrics::rms_heating_only,
            Display::lower("RMS deviation below target, zones without cooling (K)", 1.0, 2);
        /// zones whose rewarded deviation was outside the comfort band in every step
        zones_never_near_target: usize = "zones_never_near_target", "1", Metrics::zones_never_near_target, None;
        /// mean absolute deviation from the target, mean over the zones with heating and cooling
        mean_abs_deviation: f64 = "mean_abs_deviation_k", "K", Metrics::mean_abs_deviation,
            Display::lower("mean absolute deviation (K)", 1.0, 2);
        /// hours above or below the comfort band, mean over the zones with heating and cooling
        hours_outside_band: f64 = "hours_outside_band", "h", Metrics::hours_outside_band,
            Display::lower("outside comfort band (h)", 1.0, 1);
        /// deviation beyond the comfort band, integrated over time, mean over the controlled zones; without cooling,
        /// only below
        discomfort: f64 = "discomfort_k_h", "K h", Metrics::discomfort,
            Display::lower("discomfort outside the band (K·h)", 1.0, 1);
    }
    after {
        /// actuator travel in full strokes, mean over the actuators
        daily_travel: f64 = "daily_travel", "1/d", Metrics::daily_travel,
            Display::lower("actuator travel (strokes/day)", 1.0, 1);
        /// share of zone-steps of controlled zones in sustained oscillation, which indicates a limit cycle
        oscillating_share: f64 = "oscillating_share", "1", Metrics::oscillating_share,
            Display::lower("sustained oscillation (% of zone-steps)", 100.0, 1);
        /// action values that were out of bounds and clamped
        clamped_actions: usize = "clamped_actions", "1", |metrics| metrics.clamped_actions, None;
        /// steps in which the [ventilation interlock](#ventilation) raised an action
        ventilation_overrides: usize = "ventilation_overrides", "1", |metrics| metrics.ventilation_overrides, None;
        /// mean outdoor air flow per person while people are present; 0 where no system has outdoor air
        outdoor_air_per_person: f64 = "outdoor_air_l_s_person", "L/s", Metrics::outdoor_air_per_person, OUTDOOR_AIR;
        /// share of occupied zone-hours below the comfort band; unknown if no controlled zone is ever occupied
        occupied_too_cold: Option<f64> = "occupied_too_cold_share", "1", Metrics::occupied_too_cold,
            Display::lower("occupied hours too cold (%)", 100.0, 1);
        /// share of occupied zone-hours above the comfort band, without zones that have no cooling
        occupied_too_warm: Option<f64> = "occupied_too_warm_share", "1", Metrics::occupied_too_warm,
            Display::lower("occupied hours too warm (%)", 100.0, 1);
        /// operation: deviation outside the band, integrated over time, per zone
        tdis_tot: Option<f64> = "tdis_tot", "K h", Metrics::zone_discomfort,
            Display::lower("thermal discomfort (K·h per zone)", 1.0, 2);
        /// operation with `+co2`: CO₂ above the limit, integrated over time, per zone
        idis_tot: Option<f64> = "idis_tot", "ppm h", Metrics::zone_bad_air,
            Display::lower("CO₂ above the limit (ppm·h per zone)", 1.0, 0);
        /// operation: HVAC energy
        ener_tot: Option<f64> = "ener_tot", "kWh/m²", Metrics::operation_energy,
            Display::lower("HVAC energy (kWh/m²)", 1.0, 2);
        /// operation: cost of HVAC energy
        cost_tot: Option<f64> = "cost_tot", "currency/m²", Metrics::operation_cost,
            Display::lower("cost (currency/m²)", 1.0, 3);
        /// operation: emissions of HVAC energy
        emis_tot: Option<f64> = "emis_tot", "kg CO₂/m²", Metrics::operation_emissions, None;
        /// operation: largest mean of electric demand over a quarter-hour, or a step of 30 or 60 minutes
        pele_tot: Option<f64> = "pele_tot", "kW/m²", |metrics| metrics.operation_peak(0),
            Display::lower("peak electric demand, 15 min or a step (W/m²)", 1000.0, 1);
        /// operation: the same of gas and other fuels
        pgas_tot: Option<f64> = "pgas_tot", "kW/m²", |metrics| metrics.operation_peak(1), None;
        /// operation: the same of district heat
        pdih_tot: Option<f64> = "pdih_tot", "kW/m²", |metrics| metrics.operation_peak(2), None;
    }
}

impl EpisodeMetrics {
    /// HVAC energy, electricity and gas, Wh/m²; NaN if it is unknown.
    pub fn energy(&self) -> f64 {
        self.used(Resource::ENERGY).unwrap_or(f64::NAN)
    }

    /// Returns the total of a resource, in the unit of its steps; `None` if it is unknown.
    pub fn used(&self, resource: Resource) -> Option<f64> {
        match resource.term() {
            Term::Energy => Some(self.terms.get(Term::Electricity)? + self.terms.get(Term::Gas)?),
            term => Some(self.terms.get(term)? * term.entry().column.as_ref()?.divisor),
        }
    }

    /// Each column's name with its value, if it is known.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, Option<MetricValue>)> {
        Self::columns().map(|column| (column.name, column.get(self)))
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
        for column in EpisodeMetrics::columns() {
            let mut metrics = EpisodeMetrics::default();
            column.set(&mut metrics, 7.0);
            for (name, value) in metrics.values() {
                let value = value.map_or(0.0, MetricValue::as_f64);
                assert_eq!(value, if name == column.name { 7.0 } else { 0.0 }, "{name}");
            }
        }
        let mut names: Vec<_> = EpisodeMetrics::columns().map(|column| column.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), EpisodeMetrics::columns().count());
    }

    #[test]
    fn counts_are_written_without_a_decimal_point() {
        #[derive(Serialize)]
        struct Summary {
            #[serde(flatten, serialize_with = "EpisodeMetrics::serialize_columns")]
            metrics: EpisodeMetrics,
        }
        let mut metrics = EpisodeMetrics { steps: 288, ..EpisodeMetrics::default() };
        metrics.terms.set(Term::Gas, 1.0);
        let json = serde_json::to_string(&Summary { metrics }).unwrap();
        assert!(
            json.starts_with(r#"{"steps":288,"return":0.0,"#) && json.contains(r#""gas_wh_m2":1.0"#),
            "{json}"
        );
    }

    #[test]
    fn a_record_reads_back_even_without_newer_terms() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct Record {
            building: String,
            #[serde(flatten)]
            metrics: EpisodeMetrics,
        }
        let mut metrics = EpisodeMetrics { steps: 3, daily_travel: 0.1 + 0.2, ..EpisodeMetrics::default() };
        metrics.terms.set(Term::Emissions, 0.7);
        let record = Record { building: "Library".to_owned(), metrics };
        let json = serde_json::to_string(&record).unwrap();
        assert!(json.contains(r#""discomfort":0.0,"emissions":0.7,"daily_travel":"#), "{json}");
        assert_eq!(serde_json::from_str::<Record>(&json).unwrap(), record);
    }
}
