//! Monthly energy of a model under its own controls.

use std::path::Path;

use b2b_base::calendar::Calendar;
use b2b_climate::Site;
use b2b_energyplus::Library;
use rusqlite::Connection;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::calibration::Fuel;
use crate::model::{Fields, number, text};
use crate::output_database::OutputDatabase;
use crate::sizing::simulation_control;
use crate::{Error, Model, Result, RunPeriod, import};

/// What the first run period of a model takes from the weather file: holidays and daylight saving time.
const OF_WEATHER: [&str; 2] =
    ["use_weather_file_holidays_and_special_days", "use_weather_file_daylight_saving_period"];
/// J in one kWh.
const JOULES: f64 = 3.6e6;

/// The energy of a whole building by calendar month, kWh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MonthlyEnergy {
    /// Electricity that the building uses, purchased or produced on site.
    pub electricity: [f64; 12],
    /// Natural gas.
    pub gas: [f64; 12],
}

impl MonthlyEnergy {
    /// Simulates a model over a year, with its own controls and sizing. Uses the model's run period if it is one whole
    /// year that gives its days of the week, otherwise a year in the calendar of the model and the weather file
    /// ([`import::calendar`]).
    ///
    /// # Errors
    /// [`Error::PartOfYear`]; [`Error::Engine`] with the engine's messages when it rejects the model; [`Error::Climate`]
    /// when the weather file
    /// cannot be read; [`Error::EnergyTable`] when the engine's output cannot be read; [`Error::Io`] when temporary
    /// files cannot be written.
    pub fn of(model: &Model, weather: &Path, library: &Library) -> Result<Self> {
        check_weather(weather)?;
        let year = metered_year(model, import::calendar::of(model, &Site::read(weather)?));
        let database = OutputDatabase::of(year, weather, library, "b2b-year-")?;
        let read = |database: &Connection| {
            let [electricity, gas] =
                [Fuel::Electricity, Fuel::Gas].map(|fuel| read_meter(database, fuel.meter()));
            Ok(Self { electricity: electricity?, gas: gas? })
        };
        database.read(read, |path, source| Error::EnergyTable { path, source })
    }

    /// Returns the energy of a fuel.
    pub fn fuel(&self, fuel: Fuel) -> &[f64; 12] {
        match fuel {
            Fuel::Electricity => &self.electricity,
            Fuel::Gas => &self.gas,
        }
    }
}

/// Checks that a weather file has every day of a year.
fn check_weather(weather: &Path) -> Result<()> {
    match RunPeriod::of_part(weather)? {
        None => Ok(()),
        Some(days) => Err(Error::PartOfYear { weather: weather.to_owned(), days }),
    }
}

/// The model with a run period of a year and monthly meters as its only output.
fn metered_year(model: &Model, calendar: Calendar) -> Model {
    let mut year = model.clone();
    OutputDatabase::request(&mut year);
    for fuel in Fuel::ALL {
        let meter = json!({"key_name": fuel.meter(), "reporting_frequency": "Monthly"});
        year.insert("Output:Meter", fuel.meter(), meter);
    }
    let control = simulation_control(&mut year);
    control.insert("run_simulation_for_weather_file_run_periods".into(), json!("Yes"));
    control.insert("run_simulation_for_sizing_periods".into(), json!("No"));
    if !matches!(&year.objects("RunPeriod")[..], [(_, period)] if is_whole_year(period) && has_weekdays(period))
    {
        year.remove_class("RunPeriod");
        let mut period = RunPeriod::FULL_YEAR.in_calendar(calendar).to_epjson(model);
        for (_, own) in model.objects("RunPeriod").into_iter().take(1) {
            for field in OF_WEATHER {
                period[field] = text(own, field).unwrap_or("Yes").into();
            }
        }
        year.insert("RunPeriod", "Year", period);
    }
    year
}

fn has_weekdays(period: &Fields) -> bool {
    ["begin_year", "day_of_week_for_start_day"].into_iter().any(|field| period.contains_key(field))
}

fn is_whole_year(period: &Fields) -> bool {
    let is = |field: &str, value: f64| number(period, field) == Some(value);
    let one_year = number(period, "end_year").is_none() || period.get("begin_year") == period.get("end_year");
    one_year
        && is("begin_month", 1.0)
        && is("begin_day_of_month", 1.0)
        && is("end_month", 12.0)
        && is("end_day_of_month", 31.0)
}

/// Reads a monthly meter, kWh; zero if the model does not use the fuel.
fn read_meter(database: &Connection, meter: &str) -> rusqlite::Result<[f64; 12]> {
    let mut rows = database.prepare(
        "SELECT Time.Month, ReportData.Value FROM ReportData \
         JOIN Time USING (TimeIndex) JOIN ReportDataDictionary USING (ReportDataDictionaryIndex) \
         WHERE ReportDataDictionary.Name = ?1 AND ReportDataDictionary.ReportingFrequency = 'Monthly'",
    )?;
    let mut months = [0.0; 12];
    let values = rows.query_map([meter], |row| Ok((row.get::<_, u32>(0)?, row.get::<_, f64>(1)?)))?;
    for value in values {
        let (month, joules) = value?;
        if let Some(energy) = months.get_mut((month as usize).wrapping_sub(1)) {
            *energy += joules / JOULES;
        }
    }
    Ok(months)
}

#[cfg(test)]
mod tests {
    use b2b_base::calendar::is_leap_year;

    use super::*;

    #[test]
    fn a_year_without_its_own_days_has_those_of_the_calendar() {
        // 2024 begins on a Monday and has a 29 February.
        let year = metered_year(&Model::default(), Calendar::new(0, true));
        let period = year.get("RunPeriod", "Year").unwrap();
        let begins = number(period, "begin_year").unwrap() as u32;
        assert!(is_leap_year(begins) && period["day_of_week_for_start_day"] == "Monday", "{period:?}");
    }

    #[test]
    fn the_run_period_of_a_model_is_kept_if_it_is_a_year() {
        let period = |month: u32, year: u32| {
            json!({"begin_month": 1, "begin_day_of_month": 1, "begin_year": 2019, "end_month": month,
                "end_day_of_month": 31, "end_year": year})
        };
        let name = |periods: &[serde_json::Value]| {
            let mut model = Model::default();
            for (number, period) in periods.iter().enumerate() {
                model.insert("RunPeriod", &format!("Own {number}"), period.clone());
            }
            metered_year(&model, Calendar::default()).names("RunPeriod")
        };
        assert_eq!(name(&[period(12, 2019)]), ["Own 0"]);
        let mut without_days = period(12, 2019);
        for field in ["begin_year", "end_year"] {
            without_days.as_object_mut().unwrap().remove(field);
        }
        assert_eq!(name(&[without_days]), ["Year"]);
        for others in
            [vec![], vec![period(1, 2019)], vec![period(12, 2020)], vec![period(12, 2019), period(1, 2019)]]
        {
            assert_eq!(name(&others), ["Year"]);
        }
    }
}
