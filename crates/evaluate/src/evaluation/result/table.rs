//! `episodes.parquet`: one row per episode.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::sync::Arc;

use arrow_array::types::{Float64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType, ListArray, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use b2b_control::Versions;
use b2b_env::{EpisodeMetrics, Inputs, MetricValue};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;

use super::{EpisodeResult, Scored};
use crate::evaluation::finished::Lost;
use crate::evaluation::info::EpisodeInfo;
use crate::evaluation::step_rewards::StepRewards;
use crate::parquet_file::read_parquet;

/// The metric that is stored as an integer; all others are stored as floating-point numbers.
const INTEGER: &str = "steps";

/// Writes the table of [`episode_table`].
///
/// # Errors
/// The errors of the Parquet library.
pub fn write_episodes(
    file: &mut (impl Write + Send),
    rows: &[EpisodeResult],
    versions: &Versions,
) -> Result<()> {
    write(file, &episode_table(rows, versions)?)
}

fn write(file: &mut (impl Write + Send), table: &RecordBatch) -> Result<()> {
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = ArrowWriter::try_new(file, table.schema(), Some(properties))?;
    writer.write(table)?;
    writer.close()?;
    Ok(())
}

/// Returns the table: rows in the order given, without wall-clock times and speeds.
///
/// # Errors
/// The errors of the Parquet library.
pub fn episode_table(rows: &[EpisodeResult], versions: &Versions) -> Result<RecordBatch> {
    let mut columns = Columns { rows, fields: Vec::new(), arrays: Vec::new() };
    columns.push_all();
    columns.table(versions)
}

/// Writes the same table with the stage of a benchmark run as its first column.
///
/// # Errors
/// The errors of the Parquet library.
pub fn write_stages(
    file: &mut (impl Write + Send),
    stages: &[(String, Vec<EpisodeResult>)],
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

/// Reads a table of [`write_stages`]: each row with its stage, in order.
///
/// # Errors
/// The errors of the Parquet library, also for a table with other columns.
pub fn read_stages(file: File) -> Result<Vec<(String, EpisodeResult)>> {
    read(file, |cells, row| Ok((cells.text("stage", row)?, cells.row(row)?)))
}

/// Reads a table of [`write_episodes`].
///
/// # Errors
/// The errors of the Parquet library, also for a table with other columns.
pub fn read_episodes(file: File) -> Result<Vec<EpisodeResult>> {
    read(file, Cells::row)
}

/// Reads a value from every row.
fn read<T>(file: File, value: impl Fn(&Cells, usize) -> Result<T>) -> Result<Vec<T>> {
    let mut values = Vec::new();
    for batch in read_parquet(file)?.1 {
        let cells = Cells(batch);
        for row in 0..cells.0.num_rows() {
            values.push(value(&cells, row)?);
        }
    }
    Ok(values)
}

struct Columns<'a> {
    rows: &'a [EpisodeResult],
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
}

impl Columns<'_> {
    fn push_all(&mut self) {
        self.text("building", |row| Some(&row.info.building));
        self.text("type", |row| Some(&row.info.building_type));
        self.text("climate_zone", |row| Some(&row.info.climate_zone));
        self.text("place", |row| Some(&row.info.place));
        self.text("split", |row| Some(&row.info.split));
        self.text("task", |row| Some(&row.info.task));
        self.text("task_hash", |row| Some(&row.info.task_hash));
        self.text("period", |row| Some(&row.info.period));
        self.push::<UInt32Type>("steps_per_hour", "1/h", |row| Some(row.info.steps_per_hour));
        self.push::<UInt64Type>("seed", "1", |row| Some(row.info.seed));
        self.text("policy", |row| Some(&row.info.policy));
        for column in EpisodeMetrics::columns() {
            let value = |row: &EpisodeResult| column.get(row.metrics()?).map(MetricValue::as_f64);
            match column.name {
                INTEGER => self.push::<UInt64Type>(INTEGER, column.unit, |row| Some(value(row)? as u64)),
                name => self.push::<Float64Type>(name, column.unit, value),
            }
        }
        self.push::<Float64Type>("baseline_return", "1", |row| row.scored()?.baseline_return);
        self.push::<Float64Type>("baseline_energy_wh_m2", "Wh/m2", |row| row.scored()?.baseline_energy);
        self.push::<Float64Type>("resource", "1", |row| row.scored()?.resource);
        self.push::<Float64Type>("baseline_resource", "1", |row| row.scored()?.baseline_resource);
        self.push::<Float64Type>("baseline_discomfort_k_h", "K h", |row| row.scored()?.baseline_discomfort);
        self.push::<Float64Type>("score", "1", EpisodeResult::score);
        self.push::<Float64Type>("resolved_score", "1", EpisodeResult::resolved_score);
        self.push::<Float64Type>("relative_energy", "1", |row| row.scored()?.relative_energy());
        self.push::<Float64Type>("relative_resource", "1", |row| row.scored()?.relative_resource());
        self.counts("step_rewards", |row| Some(&row.scored()?.step_rewards));
        self.text("model_sha256", |row| Some(&row.scored()?.inputs.model_sha256));
        self.text("weather_sha256", |row| Some(&row.scored()?.inputs.weather_sha256));
        self.text("trajectory_hash", |row| Some(&row.scored()?.trajectory_hash));
        self.text("lost", |row| Some(&row.outcome.as_ref().err()?.reason));
    }

    fn push<T: ArrowPrimitiveType>(
        &mut self,
        name: &str,
        unit: &str,
        value: impl Fn(&EpisodeResult) -> Option<T::Native>,
    ) {
        let unit = HashMap::from([("unit".to_owned(), unit.to_owned())]);
        self.fields.push(Field::new(name, T::DATA_TYPE, true).with_metadata(unit));
        self.arrays.push(Arc::new(self.rows.iter().map(value).collect::<PrimitiveArray<T>>()));
    }

    fn counts(&mut self, name: &str, value: impl Fn(&EpisodeResult) -> Option<&StepRewards>) {
        let values = self.rows.iter().map(|row| Some(value(row)?.counts.iter().copied().map(Some)));
        let array = ListArray::from_iter_primitive::<UInt32Type, _, _>(values);
        self.fields.push(Field::new(name, array.data_type().clone(), true));
        self.arrays.push(Arc::new(array));
    }

    fn text(&mut self, name: &str, value: impl Fn(&EpisodeResult) -> Option<&String>) {
        self.fields.push(Field::new(name, DataType::Utf8, true));
        let values = self.rows.iter().map(value).map(|value| value.map(String::as_str));
        self.arrays.push(Arc::new(values.collect::<StringArray>()));
    }

    fn table(self, versions: &Versions) -> Result<RecordBatch> {
        // Only one entry, because the order of several is not deterministic.
        let versions = serde_json::to_string(versions).expect("plain data always serializes");
        let about = HashMap::from([("versions".to_owned(), versions)]);
        let schema = Arc::new(Schema::new_with_metadata(self.fields, about));
        Ok(RecordBatch::try_new(schema, self.arrays)?)
    }
}

/// A batch of rows read from a file.
struct Cells(RecordBatch);

impl Cells {
    fn column<T: 'static>(&self, name: &str) -> Result<&T> {
        let column = self.0.column_by_name(name).and_then(|column| column.as_any().downcast_ref());
        column.ok_or_else(|| ParquetError::General(format!("column `{name}` is missing")))
    }

    /// Returns the value of a column that older tables do not have.
    fn younger(&self, name: &str, row: usize) -> Result<Option<f64>> {
        self.0.column_by_name(name).map_or(Ok(None), |_| self.optional::<Float64Type>(name, row))
    }

    fn optional_text(&self, name: &str, row: usize) -> Result<Option<String>> {
        let column: &StringArray = self.column(name)?;
        Ok(column.is_valid(row).then(|| column.value(row).to_owned()))
    }

    fn text(&self, name: &str, row: usize) -> Result<String> {
        self.optional_text(name, row)?.ok_or_else(|| empty(name, row))
    }

    fn optional<T: ArrowPrimitiveType>(&self, name: &str, row: usize) -> Result<Option<T::Native>> {
        let column: &PrimitiveArray<T> = self.column(name)?;
        Ok(column.is_valid(row).then(|| column.value(row)))
    }

    fn value<T: ArrowPrimitiveType>(&self, name: &str, row: usize) -> Result<T::Native> {
        self.optional::<T>(name, row)?.ok_or_else(|| empty(name, row))
    }

    fn counts(&self, name: &str, row: usize) -> Result<Vec<u32>> {
        let column: &ListArray = self.column(name)?;
        let values = column.is_valid(row).then(|| column.value(row)).ok_or_else(|| empty(name, row))?;
        let values = values.as_any().downcast_ref::<PrimitiveArray<UInt32Type>>();
        Ok(values.ok_or_else(|| empty(name, row))?.values().to_vec())
    }

    fn row(&self, row: usize) -> Result<EpisodeResult> {
        let outcome = match self.optional_text("lost", row)? {
            Some(reason) => Err(Lost { reason }),
            None => Ok(self.scored(row)?),
        };
        Ok(EpisodeResult { info: self.info(row)?, outcome })
    }

    fn info(&self, row: usize) -> Result<EpisodeInfo> {
        let text = |name: &str| self.text(name, row);
        Ok(EpisodeInfo {
            building: text("building")?,
            building_type: text("type")?,
            climate_zone: text("climate_zone")?,
            place: text("place")?,
            split: text("split")?,
            task: text("task")?,
            task_hash: text("task_hash")?,
            period: text("period")?,
            steps_per_hour: self.value::<UInt32Type>("steps_per_hour", row)?,
            policy: text("policy")?,
            seed: self.value::<UInt64Type>("seed", row)?,
        })
    }

    fn scored(&self, row: usize) -> Result<Scored> {
        let mut metrics = EpisodeMetrics::default();
        for column in EpisodeMetrics::columns() {
            let value = match column.name {
                INTEGER => Some(self.value::<UInt64Type>(INTEGER, row)? as f64),
                name if column.may_be_unknown => self.younger(name, row)?,
                name => Some(self.value::<Float64Type>(name, row)?),
            };
            if let Some(value) = value {
                column.set(&mut metrics, value);
            }
        }
        Ok(Scored {
            metrics,
            step_rewards: StepRewards { counts: self.counts("step_rewards", row)? },
            inputs: Inputs {
                model_sha256: self.text("model_sha256", row)?,
                weather_sha256: self.text("weather_sha256", row)?,
            },
            trajectory_hash: self.text("trajectory_hash", row)?,
            baseline_return: self.optional::<Float64Type>("baseline_return", row)?,
            baseline_energy: self.optional::<Float64Type>("baseline_energy_wh_m2", row)?,
            resource: self.younger("resource", row)?,
            baseline_resource: self.younger("baseline_resource", row)?,
            baseline_discomfort: self.younger("baseline_discomfort_k_h", row)?,
            score: self.optional::<Float64Type>("score", row)?,
            resolved_score: self.optional::<Float64Type>("resolved_score", row)?,
        })
    }
}

fn empty(column: &str, row: usize) -> ParquetError {
    ParquetError::General(format!("column `{column}` has no value in row {row}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, EpisodePlan, Subject};

    #[test]
    fn a_table_reads_back_unchanged() {
        let episode = EpisodePlan {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: "occupancy".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 7,
            steps_per_hour: 12,
        };
        let info = EpisodeInfo::of(&episode, &BuiltIn::random());
        let mut metrics = EpisodeMetrics::default();
        for (number, column) in EpisodeMetrics::columns().enumerate() {
            column.set(&mut metrics, number as f64 + 1.0);
        }
        metrics.rms_deviation = 0.1 + 0.2;
        let trajectory_hash = "abc".to_owned();
        let step_rewards = StepRewards { counts: vec![0, 3, 1] };
        let baseline_return = Some(-10.0);
        let scored = Scored {
            metrics,
            step_rewards,
            inputs: Inputs { model_sha256: "m".into(), weather_sha256: "w".into() },
            trajectory_hash,
            baseline_return,
            baseline_energy: Some(4.5),
            resource: Some(0.5),
            baseline_resource: Some(2.0),
            baseline_discomfort: Some(3.5),
            score: Some(1.225),
            resolved_score: Some(1.125),
        };
        let ran = EpisodeResult { info: info.clone(), outcome: Ok(scored) };
        let lost = EpisodeResult { info, outcome: Err(Lost { reason: "the worker crashed".into() }) };
        let file = tempfile::NamedTempFile::new().unwrap();
        let stages = [("test".to_owned(), vec![ran.clone()]), ("train".to_owned(), vec![lost.clone()])];
        write_stages(&mut file.reopen().unwrap(), &stages, &Versions::current()).unwrap();
        let read = read_stages(file.reopen().unwrap()).unwrap();
        assert_eq!(read, [("test".to_owned(), ran), ("train".to_owned(), lost)]);
    }

    #[test]
    fn a_table_from_before_a_metric_reads_without_it() {
        let episode = EpisodePlan {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: "occupancy+cost1".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 7,
            steps_per_hour: 12,
        };
        let mut metrics = EpisodeMetrics::default();
        EpisodeMetrics::columns().for_each(|column| column.set(&mut metrics, 3.0));
        let scored = Scored { metrics, resource: Some(1.0), ..Scored::default() };
        let row = EpisodeResult {
            info: EpisodeInfo::of(&episode, &BuiltIn::random()),
            outcome: Ok(scored.clone()),
        };
        let table = episode_table(&[row], &Versions::current()).unwrap();
        let is_old = |name: &str| {
            !name.ends_with("resource")
                && EpisodeMetrics::columns().all(|column| column.name != name || !column.may_be_unknown)
        };
        let old = (0..table.num_columns()).filter(|index| is_old(table.schema().field(*index).name()));
        let old = table.project(&old.collect::<Vec<_>>()).unwrap();
        let read = Cells(old).row(0).unwrap().outcome.unwrap();
        assert_eq!((read.resource, read.metrics.occupied_too_cold), (None, None));
        assert!(read.metrics.energy().is_nan());
        assert_eq!(read.metrics.daily_travel, 3.0);
        assert_eq!(Cells(table).row(0).unwrap().outcome.unwrap(), scored);
    }
}
