//! `episodes.parquet`: one row an episode.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;

use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::Result;
use parquet::file::properties::WriterProperties;

use super::{Episode, Record, Versions};
use crate::policy::Policy;

/// A column of numbers: name, unit, and where its values are.
type Number = (&'static str, &'static str, fn(&Record) -> f64);

/// An episode with its score.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its figures; no numbers where it was lost.
    pub record: Record,
    /// Return of the reactive controllers for the same episode.
    pub baseline_return: Option<f64>,
    /// See [`normalized_score`](crate::normalized_score).
    pub score: Option<f64>,
    /// Why it has no figures.
    pub lost: Option<String>,
}

impl Row {
    /// The row of an episode that was lost.
    pub fn lost(episode: &Episode, policy: &dyn Policy, why: String) -> Self {
        let record = Record {
            building: episode.subject.name.to_string(),
            building_type: episode.subject.building_type().to_owned(),
            climate_zone: String::new(),
            place: String::new(),
            split: episode.subject.split(),
            task: episode.task.to_string(),
            task_hash: episode.task.hash(),
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            policy: policy.name(),
            seed: episode.seed,
            steps: 0,
            episode_return: f64::NAN,
            temperature_penalty: f64::NAN,
            energy_penalty: f64::NAN,
            rms_deviation: f64::NAN,
            mean_abs_deviation: f64::NAN,
            hours_outside_band: f64::NAN,
            discomfort: f64::NAN,
            electricity: f64::NAN,
            gas: f64::NAN,
            cost: f64::NAN,
            emissions: f64::NAN,
            peak_electricity: f64::NAN,
            peak_gas: f64::NAN,
            daily_travel: f64::NAN,
            clamped_actions: 0,
            trajectory_hash: String::new(),
        };
        Self { record, baseline_return: None, score: None, lost: Some(why) }
    }
}

/// Writes the table of [`episode_table`].
///
/// # Errors
/// What the library says.
pub fn write_episodes(file: &mut (impl Write + Send), rows: &[Row], versions: &Versions) -> Result<()> {
    let table = episode_table(rows, versions)?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(file, table.schema(), Some(properties))?;
    writer.write(&table)?;
    writer.close()?;
    Ok(())
}

/// The table: rows in the order given, and nothing of when or how fast they came about.
///
/// # Errors
/// What the library says.
pub fn episode_table(rows: &[Row], versions: &Versions) -> Result<RecordBatch> {
    let mut columns = Columns { rows, fields: Vec::new(), arrays: Vec::new() };
    columns.text("building", |row| Some(&row.record.building));
    columns.text("type", |row| Some(&row.record.building_type));
    columns.text("climate_zone", |row| Some(&row.record.climate_zone));
    columns.text("place", |row| Some(&row.record.place));
    columns.text("split", |row| Some(&row.record.split));
    columns.text("task", |row| Some(&row.record.task));
    columns.text("task_hash", |row| Some(&row.record.task_hash));
    columns.text("period", |row| Some(&row.record.period));
    columns.push::<UInt32Type>("steps_per_hour", "1/h", |row| Some(row.record.steps_per_hour));
    columns.push::<UInt64Type>("seed", "1", |row| Some(row.record.seed));
    columns.text("policy", |row| Some(&row.record.policy));
    columns.push::<UInt64Type>("steps", "1", |row| row.if_run(|record| record.steps as u64));
    let numbers: [Number; 15] = [
        ("return", "1", |record| record.episode_return),
        ("temperature_penalty", "K²", |record| record.temperature_penalty),
        ("energy_penalty", "1", |record| record.energy_penalty),
        ("rms_deviation_k", "K", |record| record.rms_deviation),
        ("mean_abs_deviation_k", "K", |record| record.mean_abs_deviation),
        ("hours_outside_band", "h", |record| record.hours_outside_band),
        ("discomfort_k_h", "K h", |record| record.discomfort),
        ("electricity_wh_m2", "Wh/m²", |record| record.electricity),
        ("gas_wh_m2", "Wh/m²", |record| record.gas),
        ("cost_m2", "currency/m²", |record| record.cost),
        ("emissions_kg_m2", "kg/m²", |record| record.emissions),
        ("peak_electricity_w_m2", "W/m²", |record| record.peak_electricity),
        ("peak_gas_w_m2", "W/m²", |record| record.peak_gas),
        ("daily_travel", "1/d", |record| record.daily_travel),
        ("clamped_actions", "1", |record| record.clamped_actions as f64),
    ];
    for (name, unit, value) in numbers {
        columns.push::<Float64Type>(name, unit, |row| row.if_run(value));
    }
    columns.push::<Float64Type>("baseline_return", "1", |row| row.baseline_return);
    columns.push::<Float64Type>("score", "1", |row| row.score);
    columns.text("trajectory_hash", |row| row.lost.is_none().then_some(&row.record.trajectory_hash));
    columns.text("lost", |row| row.lost.as_ref());
    columns.table(versions)
}

impl Row {
    /// A figure of an episode that was not lost.
    fn if_run<T>(&self, value: impl Fn(&Record) -> T) -> Option<T> {
        self.lost.is_none().then(|| value(&self.record))
    }
}

struct Columns<'a> {
    rows: &'a [Row],
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
}

impl Columns<'_> {
    fn push<T: ArrowPrimitiveType>(
        &mut self,
        name: &str,
        unit: &str,
        value: impl Fn(&Row) -> Option<T::Native>,
    ) {
        let unit = HashMap::from([("unit".to_owned(), unit.to_owned())]);
        self.fields.push(Field::new(name, T::DATA_TYPE, true).with_metadata(unit));
        self.arrays.push(Arc::new(self.rows.iter().map(value).collect::<PrimitiveArray<T>>()));
    }

    fn text<'a>(&'a mut self, name: &str, value: impl Fn(&'a Row) -> Option<&'a String>) {
        self.fields.push(Field::new(name, DataType::Utf8, true));
        let values = self.rows.iter().map(value).map(|value| value.map(String::as_str));
        self.arrays.push(Arc::new(values.collect::<StringArray>()));
    }

    fn table(self, versions: &Versions) -> Result<RecordBatch> {
        // One entry alone: several would come in any order.
        let versions = serde_json::to_string(versions).expect("it is plain data");
        let about = HashMap::from([("versions".to_owned(), versions)]);
        let schema = Arc::new(Schema::new_with_metadata(self.fields, about));
        Ok(RecordBatch::try_new(schema, self.arrays)?)
    }
}
