//! `episodes.parquet`: one row an episode.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::sync::Arc;

use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::errors::{ParquetError, Result};
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
    write(file, &episode_table(rows, versions)?)
}

fn write(file: &mut (impl Write + Send), table: &RecordBatch) -> Result<()> {
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(file, table.schema(), Some(properties))?;
    writer.write(table)?;
    writer.close()?;
    Ok(())
}

/// The table: rows in the order given, and nothing of when or how fast they came about.
///
/// # Errors
/// What the library says.
pub fn episode_table(rows: &[Row], versions: &Versions) -> Result<RecordBatch> {
    let mut columns = Columns { rows, fields: Vec::new(), arrays: Vec::new() };
    columns.push_all();
    columns.table(versions)
}

/// Writes the same table with the stage of a benchmark run before it.
///
/// # Errors
/// What the library says.
pub fn write_stages(
    file: &mut (impl Write + Send),
    stages: &[(String, Vec<Row>)],
    versions: &Versions,
) -> Result<()> {
    let names: Vec<_> =
        stages.iter().flat_map(|(name, rows)| rows.iter().map(move |_| name.as_str())).collect();
    let rows: Vec<_> = stages.iter().flat_map(|(_, rows)| rows).cloned().collect();
    let stage = Arc::new(names.into_iter().map(Some).collect::<StringArray>());
    let fields = vec![Field::new("stage", DataType::Utf8, false)];
    let mut columns = Columns { rows: &rows, fields, arrays: vec![stage] };
    columns.push_all();
    write(file, &columns.table(versions)?)
}

/// Reads a table of [`write_stages`]: the stage of each row, and the rows, in order.
///
/// # Errors
/// What the library says; what is no such table.
pub fn read_stages(file: File) -> Result<Vec<(String, Row)>> {
    let mut rows = Vec::new();
    for batch in ParquetRecordBatchReaderBuilder::try_new(file)?.build()? {
        let cells = Cells(batch.map_err(|error| ParquetError::General(error.to_string()))?);
        for row in 0..cells.0.num_rows() {
            rows.push((cells.text("stage", row)?.unwrap_or_default(), cells.row(row)?));
        }
    }
    Ok(rows)
}

/// Columns of numbers.
const NUMBERS: [Number; 15] = [
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
    fn push_all(&mut self) {
        self.text("building", |row| Some(&row.record.building));
        self.text("type", |row| Some(&row.record.building_type));
        self.text("climate_zone", |row| Some(&row.record.climate_zone));
        self.text("place", |row| Some(&row.record.place));
        self.text("split", |row| Some(&row.record.split));
        self.text("task", |row| Some(&row.record.task));
        self.text("task_hash", |row| Some(&row.record.task_hash));
        self.text("period", |row| Some(&row.record.period));
        self.push::<UInt32Type>("steps_per_hour", "1/h", |row| Some(row.record.steps_per_hour));
        self.push::<UInt64Type>("seed", "1", |row| Some(row.record.seed));
        self.text("policy", |row| Some(&row.record.policy));
        self.push::<UInt64Type>("steps", "1", |row| row.if_run(|record| record.steps as u64));
        for (name, unit, value) in NUMBERS {
            self.push::<Float64Type>(name, unit, |row| row.if_run(value));
        }
        self.push::<Float64Type>("baseline_return", "1", |row| row.baseline_return);
        self.push::<Float64Type>("score", "1", |row| row.score);
        self.text("trajectory_hash", |row| row.lost.is_none().then_some(&row.record.trajectory_hash));
        self.text("lost", |row| row.lost.as_ref());
    }

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

    fn text(&mut self, name: &str, value: impl Fn(&Row) -> Option<&String>) {
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

/// A part of a table that was read.
struct Cells(RecordBatch);

impl Cells {
    fn column<T: 'static>(&self, name: &str) -> Result<&T> {
        let column = self.0.column_by_name(name).and_then(|column| column.as_any().downcast_ref());
        column.ok_or_else(|| ParquetError::General(format!("it has no column `{name}` of episodes")))
    }

    fn text(&self, name: &str, row: usize) -> Result<Option<String>> {
        let column: &StringArray = self.column(name)?;
        Ok(column.is_valid(row).then(|| column.value(row).to_owned()))
    }

    fn value<T: ArrowPrimitiveType>(&self, name: &str, row: usize) -> Result<Option<T::Native>> {
        let column: &PrimitiveArray<T> = self.column(name)?;
        Ok(column.is_valid(row).then(|| column.value(row)))
    }

    fn row(&self, row: usize) -> Result<Row> {
        let text = |name: &str| -> Result<String> { Ok(self.text(name, row)?.unwrap_or_default()) };
        let number =
            |name: &str| -> Result<f64> { Ok(self.value::<Float64Type>(name, row)?.unwrap_or(f64::NAN)) };
        let record = Record {
            building: text("building")?,
            building_type: text("type")?,
            climate_zone: text("climate_zone")?,
            place: text("place")?,
            split: text("split")?,
            task: text("task")?,
            task_hash: text("task_hash")?,
            period: text("period")?,
            steps_per_hour: self.value::<UInt32Type>("steps_per_hour", row)?.unwrap_or_default(),
            policy: text("policy")?,
            seed: self.value::<UInt64Type>("seed", row)?.unwrap_or_default(),
            steps: self.value::<UInt64Type>("steps", row)?.unwrap_or_default() as usize,
            episode_return: number("return")?,
            temperature_penalty: number("temperature_penalty")?,
            energy_penalty: number("energy_penalty")?,
            rms_deviation: number("rms_deviation_k")?,
            mean_abs_deviation: number("mean_abs_deviation_k")?,
            hours_outside_band: number("hours_outside_band")?,
            discomfort: number("discomfort_k_h")?,
            electricity: number("electricity_wh_m2")?,
            gas: number("gas_wh_m2")?,
            cost: number("cost_m2")?,
            emissions: number("emissions_kg_m2")?,
            peak_electricity: number("peak_electricity_w_m2")?,
            peak_gas: number("peak_gas_w_m2")?,
            daily_travel: number("daily_travel")?,
            clamped_actions: number("clamped_actions")? as usize,
            trajectory_hash: text("trajectory_hash")?,
        };
        Ok(Row {
            record,
            baseline_return: self.value::<Float64Type>("baseline_return", row)?,
            score: self.value::<Float64Type>("score", row)?,
            lost: self.text("lost", row)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, Subject};

    #[test]
    fn a_table_reads_back_as_it_was_written() {
        let episode = Episode {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: "occupancy".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 7,
            steps_per_hour: 12,
        };
        let lost = Row::lost(&episode, &BuiltIn::Random, "it crashed".into());
        let record = Record {
            episode_return: -12.25,
            rms_deviation: 0.1 + 0.2,
            steps: 576,
            clamped_actions: 3,
            gas: 0.0,
            temperature_penalty: 12.25,
            energy_penalty: 0.0,
            mean_abs_deviation: 0.2,
            hours_outside_band: 1.0,
            discomfort: 0.5,
            electricity: 4.0,
            cost: 1.0,
            emissions: 2.0,
            peak_electricity: 3.0,
            peak_gas: 0.0,
            daily_travel: 9.0,
            trajectory_hash: "abc".into(),
            ..lost.record.clone()
        };
        let ran = Row { record, baseline_return: Some(-10.0), score: Some(1.225), lost: None };
        let file = tempfile::NamedTempFile::new().unwrap();
        let stages = [("test".to_owned(), vec![ran.clone()]), ("train".to_owned(), vec![lost])];
        write_stages(&mut file.reopen().unwrap(), &stages, &Versions::current()).unwrap();
        let read = read_stages(file.reopen().unwrap()).unwrap();
        assert_eq!(read[0], ("test".to_owned(), ran));
        assert_eq!((read[1].0.as_str(), read[1].1.lost.as_deref()), ("train", Some("it crashed")));
        assert!(read[1].1.record.episode_return.is_nan() && read[1].1.score.is_none());
    }
}
