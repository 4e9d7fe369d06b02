//! The Parquet file of an episode: one row for every observation, the last without an action.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type};
use arrow_array::{
    Array, ArrayRef, BooleanArray, FixedSizeListArray, Float32Array, Float64Array, RecordBatch, StructArray,
};
use arrow_schema::{DataType, Field};
use b2b_evaluate::read_parquet;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

use crate::error::at;
use crate::{Error, Result};

/// Name of the expert's actions in the column `infos`.
const EXPERT: &str = "expert_actions";

/// The steps of an episode, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EpisodeFile {
    /// Observations before the first and after each step.
    pub observations: Vec<f32>,
    /// Actions.
    pub actions: Vec<f32>,
    /// Rewards.
    pub rewards: Vec<f64>,
    /// The expert's actions for the observations of a corpus; empty in other datasets.
    pub expert: Vec<f32>,
}

/// Returns the path of the steps of an episode.
pub(super) fn path(data: &Path, episode: usize) -> PathBuf {
    data.join(episode.to_string()).join("part-0.parquet")
}

/// Writes the steps of an episode. The row of the last observation has zeros for action and reward.
pub(super) fn write(path: &Path, episode: &EpisodeFile, steps: usize) -> Result<()> {
    let rows = steps + 1;
    let flags = |last: bool| -> ArrayRef {
        Arc::new(BooleanArray::from_iter((0..rows).map(|row| Some(last && row + 1 == steps))))
    };
    let mut rewards = episode.rewards.clone();
    rewards.resize(rows, 0.0);
    let mut columns: Vec<(&str, ArrayRef)> = vec![
        ("observations", lists(&episode.observations, rows, rows)),
        ("actions", lists(&episode.actions, steps, rows)),
        ("rewards", Arc::new(Float64Array::from(rewards))),
        // Every end of an episode is a truncation.
        ("terminations", flags(false)),
        ("truncations", flags(true)),
    ];
    if !episode.expert.is_empty() {
        columns.push(("infos", infos(&episode.expert, steps)));
    }
    let damaged = |error: &dyn std::fmt::Display| Error::Invalid(format!("{}: {error}", path.display()));
    let table = RecordBatch::try_from_iter(columns).map_err(|error| damaged(&error))?;
    let file = File::create(path).map_err(at(path))?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let write = || {
        let mut writer = ArrowWriter::try_new(file, table.schema(), Some(properties))?;
        writer.write(&table)?;
        writer.close()
    };
    write().map(drop).map_err(|error| damaged(&error))
}

/// Returns as many rows of numbers as given as lists of one length, with zeros in the rows after them.
fn lists(numbers: &[f32], given: usize, rows: usize) -> ArrayRef {
    let width = numbers.len() / given.max(1);
    let mut numbers = numbers.to_vec();
    numbers.resize(rows * width, 0.0);
    let field = Arc::new(Field::new_list_field(DataType::Float32, true));
    Arc::new(FixedSizeListArray::new(field, width as i32, Arc::new(Float32Array::from(numbers)), None))
}

/// Returns the column that Minari reads as infos.
fn infos(expert: &[f32], steps: usize) -> ArrayRef {
    let lists = lists(expert, steps, steps + 1);
    let field = Field::new(EXPERT, lists.data_type().clone(), true);
    Arc::new(StructArray::from(vec![(Arc::new(field), lists)]))
}

/// Reads the steps of an episode with these widths of observation and action.
pub(super) fn read(path: &Path, observation: usize, action: usize) -> Result<EpisodeFile> {
    let damaged =
        |why: String| Error::Invalid(format!("{}: {why}; collect the dataset again", path.display()));
    let file = File::open(path).map_err(at(path))?;
    let (_, tables) = read_parquet(file).map_err(|error| damaged(error.to_string()))?;
    let mut episode = EpisodeFile::default();
    for table in tables {
        let column =
            |name: &str| table.column_by_name(name).ok_or_else(|| damaged(format!("no column {name}")));
        let infos = table.column_by_name("infos").and_then(|infos| infos.as_struct_opt());
        let expert = infos.and_then(|infos| infos.column_by_name(EXPERT));
        let mut columns = vec![
            ("observations", column("observations")?, observation, &mut episode.observations),
            ("actions", column("actions")?, action, &mut episode.actions),
        ];
        columns.extend(expert.map(|expert| (EXPERT, expert, action, &mut episode.expert)));
        for (name, column, width, numbers) in columns {
            let lists =
                column.as_fixed_size_list_opt().filter(|lists| lists.value_length() as usize == width);
            let lists = lists.ok_or_else(|| damaged(format!("{name} are not lists of {width} numbers")))?;
            let values = lists.values().as_primitive_opt::<Float32Type>();
            numbers.extend_from_slice(values.ok_or_else(|| damaged(format!("{name} are not f32")))?.values());
        }
        let rewards = column("rewards")?.as_primitive_opt::<Float64Type>();
        episode
            .rewards
            .extend_from_slice(rewards.ok_or_else(|| damaged("rewards are not f64".into()))?.values());
    }
    // The row of the last observation has no action.
    for actions in [&mut episode.actions, &mut episode.expert] {
        actions.truncate(actions.len().saturating_sub(action));
    }
    episode.rewards.pop();
    Ok(episode)
}
