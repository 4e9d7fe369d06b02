//! `trajectory.parquet`: one row per step, one named column per observation, action and penalty.

use std::collections::HashMap;
use std::io::Write;
use std::sync::Arc;

use anyhow::Result;
use arrow_array::types::{Float64Type, UInt8Type, UInt32Type};
use arrow_array::{ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch};
use arrow_schema::{Field, Schema};
use b2b_building::Date;
use b2b_env::{Spaces, Trajectory};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

use super::summary::Summary;

/// Name of the file.
pub const NAME: &str = "trajectory.parquet";

/// Writes a trajectory. Columns are named after the slots of the spaces; units are in the field metadata.
pub fn write(
    file: &mut (impl Write + Send),
    spaces: &Spaces,
    trajectory: &Trajectory,
    summary: &Summary,
) -> Result<()> {
    let mut columns = Columns::default();
    columns.calendar(spaces, trajectory.len());
    for (k, slot) in spaces.observation.slots().iter().enumerate() {
        columns.push::<Float64Type>(&slot.name, slot.unit, trajectory.observed(k));
    }
    let actions = &spaces.action;
    for (k, (name, quantity)) in actions.names().iter().zip(actions.quantities()).enumerate() {
        columns.push::<Float64Type>(name, quantity.unit(), trajectory.acted(k));
    }
    let penalties = &trajectory.penalties;
    columns.push::<Float64Type>("temperature penalty", "K²", penalties.iter().map(|p| p[0]));
    columns.push::<Float64Type>("energy penalty", "1", penalties.iter().map(|p| p[1]));
    columns.push::<Float64Type>("reward", "1", penalties.iter().map(|p| -p[0] - p[1]));
    columns.write(file, summary)
}

#[derive(Default)]
struct Columns {
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
}

impl Columns {
    fn push<T: ArrowPrimitiveType>(
        &mut self,
        name: &str,
        unit: &str,
        values: impl Iterator<Item = T::Native>,
    ) {
        let unit = HashMap::from([("unit".to_owned(), unit.to_owned())]);
        self.fields.push(Field::new(name, T::DATA_TYPE, false).with_metadata(unit));
        self.arrays.push(Arc::new(PrimitiveArray::<T>::from_iter_values(values)));
    }

    /// Adds the step number, counted from 1, and the date and time at its end.
    fn calendar(&mut self, spaces: &Spaces, steps: usize) {
        let per_hour = spaces.episode.steps_per_hour as usize;
        let first = spaces.episode.period.first().day_of_year() as usize;
        let ends = || 1..=steps;
        let date = |step: usize| Date::of_day(((first - 1 + step / (24 * per_hour)) % 365 + 1) as u32);
        self.push::<UInt32Type>("step", "1", ends().map(|step| step as u32));
        self.push::<UInt8Type>("month", "1", ends().map(|step| date(step).month() as u8));
        self.push::<UInt8Type>("day", "1", ends().map(|step| date(step).day() as u8));
        self.push::<UInt8Type>("hour", "h", ends().map(|step| (step / per_hour % 24) as u8));
        self.push::<UInt8Type>("minute", "min", ends().map(|step| (step % per_hour * 60 / per_hour) as u8));
    }

    fn write(self, file: &mut (impl Write + Send), summary: &Summary) -> Result<()> {
        let metadata = [
            ("building", summary.building.clone()),
            ("place", summary.info.place.clone()),
            ("period", summary.period.clone()),
            ("controller", summary.info.controller.to_owned()),
            ("task", summary.task.clone()),
            ("task_hash", summary.task_hash.clone()),
            ("versions", serde_json::to_string(&summary.versions)?),
            ("task_definition", serde_json::to_string(&summary.task_definition)?),
        ];
        let metadata = metadata.map(|(key, value)| (key.to_owned(), value));
        let schema = Arc::new(Schema::new_with_metadata(self.fields, HashMap::from(metadata)));
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let mut writer = ArrowWriter::try_new(file, Arc::clone(&schema), Some(properties))?;
        writer.write(&RecordBatch::try_new(schema, self.arrays)?)?;
        writer.close()?;
        Ok(())
    }
}
