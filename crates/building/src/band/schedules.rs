//! A model's holidays and the values of its schedules over years, computed by the engine in a run without zones.

use std::collections::BTreeMap;

use b2b_base::calendar::Calendar;
use b2b_energyplus::Library;
use rusqlite::Connection;
use serde_json::json;

use super::Off;
use crate::model::number;
use crate::output_database::OutputDatabase;
use crate::sizing::simulation_control;
use crate::{Error, Model, Result, RunPeriod};

/// Values per day. A change takes effect at the next value.
pub(super) const PER_DAY: usize = 96;

/// Days that a model declares to be of a special type.
const SPECIAL_DAYS: &str = "RunPeriodControl:SpecialDays";
/// Prefixes of the classes on which schedule values depend.
const NEEDED: [&str; 5] = ["Version", "Schedule", SPECIAL_DAYS, "Site:Location", "GlobalGeometryRules"];
/// EnergyPlus's output variables of a schedule and of the day type.
const OUTPUTS: [&str; 2] = ["Schedule Value", "Site Day Type Index"];
/// EnergyPlus's first day type of a special day, a holiday; lower ones are days of the week.
const FIRST_SPECIAL: f64 = 8.0;

/// The values of schedules over one or more years.
#[derive(Debug, Default)]
pub(super) struct Sampled {
    /// Values by upper-case name.
    values: BTreeMap<String, Vec<f64>>,
    /// Special days, from 1 on 1 January of the first year.
    holidays: Vec<u32>,
}

impl Sampled {
    /// Computes the values of a model's schedules over consecutive years.
    pub(super) fn of(model: &Model, names: &[&str], years: &[Calendar], library: &Library) -> Result<Self> {
        let mut sampled = Self::default();
        let mut varying = Vec::new();
        for name in names.iter().filter(|name| !name.is_empty()) {
            match constant(model, name) {
                Some(value) => _ = sampled.values.insert(name.to_uppercase(), vec![value]),
                None => varying.push(name.to_uppercase()),
            }
        }
        varying.sort_unstable();
        varying.dedup();
        if !varying.is_empty() || !model.objects(SPECIAL_DAYS).is_empty() {
            let mut before = 0;
            for year in years {
                sampled.add(&schedules_alone(model, &varying, *year), *year, before, library)?;
                before += year.days();
            }
        }
        Ok(sampled)
    }

    /// Adds a year that begins after `before` days.
    fn add(&mut self, model: &Model, year: Calendar, before: u32, library: &Library) -> Result<()> {
        let database = OutputDatabase::in_any_weather(model, year.is_leap(), library, "b2b-schedules-")?;
        let failed = |path, source| Error::ScheduleTable { path, source };
        for (name, values) in database.read(read_values, failed)? {
            self.values.entry(name).or_default().extend(values);
        }
        self.holidays.extend(database.read(read_holidays, failed)?.into_iter().map(|day| before + day));
        Ok(())
    }

    /// Returns the days, from 1 on 1 January of the first year and in order, that the model declares special, such as
    /// holidays.
    pub(super) fn into_holidays(self) -> Vec<u32> {
        self.holidays
    }

    /// Returns the values of a schedule; 0 for a missing schedule, although the engine rejects such a model.
    pub(super) fn of_schedule(&self, name: &str) -> Values<'_> {
        Values(self.values.get(&name.to_uppercase()).map_or(&[], Vec::as_slice))
    }
}

/// The values of a schedule: one if it is constant, otherwise one for every quarter-hour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Values<'a>(&'a [f64]);

impl Values<'_> {
    /// Returns a value by its index.
    pub(super) fn at(self, index: usize) -> f64 {
        self.0.get(index).or_else(|| self.0.last()).copied().unwrap_or(0.0)
    }

    /// Returns the share of the time in which it is zero, overall and by month of the first year, `year`.
    pub(super) fn share_off(self, year: Calendar) -> Off {
        let of_month = |month: usize| {
            let first = year.month_start(month) as usize - 1;
            let days = first..first + year.month_days(month) as usize;
            share_off(self.0.get(days.start * PER_DAY..days.end * PER_DAY).unwrap_or(self.0))
        };
        Off { share: share_off(self.0), by_month: std::array::from_fn(of_month) }
    }
}

/// Returns the share of values that are zero.
fn share_off(values: &[f64]) -> f64 {
    let off = values.iter().filter(|value| **value == 0.0).count();
    off as f64 / values.len().max(1) as f64
}

/// Returns the value of a constant schedule; `None` for others.
fn constant(model: &Model, name: &str) -> Option<f64> {
    number(model.get("Schedule:Constant", name)?, "hourly_value")
}

/// Returns the model reduced to its schedules, with their quarter-hourly values over a year as outputs.
fn schedules_alone(model: &Model, names: &[String], year: Calendar) -> Model {
    let mut alone = model.clone();
    let is_needed = |class: &str| NEEDED.iter().any(|needed| class.starts_with(needed));
    let others: Vec<String> = model.classes().filter(|class| !is_needed(class)).map(str::to_owned).collect();
    others.iter().for_each(|class| alone.remove_class(class));
    alone.insert("Building", "Schedules", json!({}));
    alone.insert("Timestep", "Timestep", json!({"number_of_timesteps_per_hour": PER_DAY / 24}));
    alone.insert("RunPeriod", "Year", RunPeriod::FULL_YEAR.in_calendar(year).to_epjson(model));
    let control = simulation_control(&mut alone);
    control.insert("run_simulation_for_weather_file_run_periods".into(), json!("Yes"));
    control.insert("run_simulation_for_sizing_periods".into(), json!("No"));
    OutputDatabase::request(&mut alone);
    let [value, day_type] = OUTPUTS;
    let mut output = |key: &str, variable: &str, frequency: &str| {
        let fields = json!({"key_value": key, "variable_name": variable, "reporting_frequency": frequency});
        alone.insert("Output:Variable", &format!("{key} {variable}"), fields);
    };
    names.iter().for_each(|name| output(name, value, "Timestep"));
    output("*", day_type, "Daily");
    alone
}

/// Returns the values by upper-case name, in order of time.
fn read_values(database: &Connection) -> rusqlite::Result<BTreeMap<String, Vec<f64>>> {
    let mut values = BTreeMap::<String, Vec<f64>>::new();
    let mut rows = database.prepare(
        "SELECT KeyValue, Value FROM ReportData JOIN ReportDataDictionary USING (ReportDataDictionaryIndex) \
         JOIN Time USING (TimeIndex) WHERE Name = ?1 AND IFNULL(WarmupFlag, 0) = 0 ORDER BY TimeIndex",
    )?;
    let pairs = rows.query_map([OUTPUTS[0]], |row| Ok((row.get::<_, String>(0)?, row.get::<_, f64>(1)?)))?;
    for pair in pairs {
        let (name, value) = pair?;
        values.entry(name.to_uppercase()).or_default().push(value);
    }
    Ok(values)
}

/// Returns the special days of the year.
fn read_holidays(database: &Connection) -> rusqlite::Result<Vec<u32>> {
    let mut rows = database.prepare(
        "SELECT Value FROM ReportData JOIN ReportDataDictionary USING (ReportDataDictionaryIndex) \
         JOIN Time USING (TimeIndex) WHERE Name = ?1 AND IFNULL(WarmupFlag, 0) = 0 ORDER BY TimeIndex",
    )?;
    let types: Vec<f64> = rows.query_map([OUTPUTS[1]], |row| row.get(0))?.collect::<rusqlite::Result<_>>()?;
    let special = types.into_iter().zip(1..).filter(|(day_type, _)| *day_type >= FIRST_SPECIAL);
    Ok(special.map(|(_, day)| day).collect())
}
