//! The values of a model's schedules over a year, computed by the engine itself in a run without a building.

use std::collections::BTreeMap;

use b2b_energyplus::Library;
use rusqlite::Connection;
use serde_json::json;

use super::DAYS;
use crate::model::number;
use crate::output_database::OutputDatabase;
use crate::sizing::simulation_control;
use crate::{Error, Model, Result, RunPeriod};

/// Values per day. A change between two values is seen at the next one.
pub(super) const PER_DAY: usize = 96;

/// Prefixes of the classes that the values of schedules depend on.
const NEEDED: [&str; 5] =
    ["Version", "Schedule", "RunPeriodControl:SpecialDays", "Site:Location", "GlobalGeometryRules"];

/// The values of schedules over the calendar year of an episode.
#[derive(Debug)]
pub(super) struct Sampled {
    /// By upper-case name.
    values: BTreeMap<String, Vec<f64>>,
}

impl Sampled {
    /// Computes the values of the named schedules of a model.
    pub(super) fn of(model: &Model, names: &[&str], library: &Library) -> Result<Self> {
        let mut values = BTreeMap::new();
        let mut varying = Vec::new();
        for name in names.iter().filter(|name| !name.is_empty()) {
            match constant(model, name) {
                Some(value) => _ = values.insert(name.to_uppercase(), vec![value]),
                None => varying.push(name.to_uppercase()),
            }
        }
        varying.sort_unstable();
        varying.dedup();
        if !varying.is_empty() {
            let model = schedules_alone(model, &varying);
            let database = OutputDatabase::in_any_weather(&model, library, "b2b-schedules-")?;
            let read = database.read(read_values, |path, source| Error::ScheduleTable { path, source })?;
            values.extend(read);
        }
        Ok(Self { values })
    }

    /// Returns the values of a schedule; 0 for a missing schedule, although the engine rejects such a model.
    pub(super) fn of_schedule(&self, name: &str) -> Values<'_> {
        Values(self.values.get(&name.to_uppercase()).map_or(&[], Vec::as_slice))
    }
}

/// The values of a schedule: one, or one for every quarter of an hour of the year.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values<'a>(&'a [f64]);

impl Values<'_> {
    /// Returns a value by its number in the year.
    pub(super) fn at(self, index: usize) -> f64 {
        self.0.get(index).or_else(|| self.0.last()).copied().unwrap_or(0.0)
    }
}

/// The value of a schedule that never changes.
fn constant(model: &Model, name: &str) -> Option<f64> {
    number(model.get("Schedule:Constant", name)?, "hourly_value")
}

/// Returns the model reduced to its schedules, with their quarter-hourly values over the year as output.
fn schedules_alone(model: &Model, names: &[String]) -> Model {
    let mut alone = model.clone();
    let is_needed = |class: &str| NEEDED.iter().any(|needed| class.starts_with(needed));
    let others: Vec<String> = model.classes().filter(|class| !is_needed(class)).map(str::to_owned).collect();
    others.iter().for_each(|class| alone.remove_class(class));
    alone.insert("Building", "Schedules", json!({}));
    alone.insert("Timestep", "Timestep", json!({"number_of_timesteps_per_hour": PER_DAY / 24}));
    alone.insert("RunPeriod", "Year", RunPeriod::FULL_YEAR.to_epjson());
    let control = simulation_control(&mut alone);
    control.insert("run_simulation_for_weather_file_run_periods".into(), json!("Yes"));
    control.insert("run_simulation_for_sizing_periods".into(), json!("No"));
    OutputDatabase::request(&mut alone);
    for name in names {
        let output = json!({
            "key_value": name,
            "variable_name": "Schedule Value",
            "reporting_frequency": "Timestep",
        });
        alone.insert("Output:Variable", &format!("{name} value"), output);
    }
    alone
}

/// Returns the values by upper-case name, in the order of time.
fn read_values(database: &Connection) -> rusqlite::Result<BTreeMap<String, Vec<f64>>> {
    let mut values = BTreeMap::<String, Vec<f64>>::new();
    let mut rows = database.prepare(
        "SELECT KeyValue, Value FROM ReportData JOIN ReportDataDictionary USING (ReportDataDictionaryIndex) \
         JOIN Time USING (TimeIndex) WHERE IFNULL(WarmupFlag, 0) = 0 ORDER BY TimeIndex",
    )?;
    let pairs = rows.query_map([], |row| Ok((row.get::<_, String>(0)?, row.get::<_, f64>(1)?)))?;
    for pair in pairs {
        let (name, value) = pair?;
        values.entry(name.to_uppercase()).or_insert_with(|| Vec::with_capacity(DAYS * PER_DAY)).push(value);
    }
    Ok(values)
}
