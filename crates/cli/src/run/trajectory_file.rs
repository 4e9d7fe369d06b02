//! `trajectory.parquet`: one row per step, one named column per observation, action and penalty.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use arrow_array::Array;
use arrow_array::types::{Float64Type, UInt8Type, UInt32Type};
use arrow_array::{ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch};
use arrow_schema::{Field, Schema};
use b2b_base::calendar::Calendar;
use b2b_base::digest::sha256;
use b2b_control::Versions;
use b2b_env::{Comfort, DecisionLog, EpisodeConfig, Spaces, Trajectory};
use b2b_evaluate::read_parquet;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

/// Name of the file.
pub const NAME: &str = "trajectory.parquet";
/// Key of the metadata entry with the SHA-256 of the other entries.
const DIGEST: &str = "metadata_sha256";
/// Key of the metadata entry with the year of the first day: its days of the week and 29 February are the episode's.
const YEAR: &str = "year";
/// Key of the metadata entry with the discomfort of the episode.
const DISCOMFORT: &str = "tdis_tot";
/// Key of the metadata entry with the amount of the task's resource over the episode.
const RESOURCE: &str = "resource";
/// Number of columns before the observations: step, month, day, hour and minute.
const CALENDAR: usize = 5;
/// Columns after the actions.
const PENALTIES: [&str; 3] = ["temperature penalty", "energy penalty", "reward"];

/// Writes a trajectory, and the controller's decisions behind its columns. Columns are named after the slots of the
/// spaces; units are in the field metadata.
pub fn write(
    file: &mut (impl Write + Send),
    spaces: &Spaces,
    trajectory: &Trajectory,
    decisions: &DecisionLog,
    identity: Identity,
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
    let unit = match spaces.episode.task.comfort {
        Comfort::Squared | Comfort::Deadband { .. } => "K²",
        Comfort::Pmv(_) | Comfort::Band { .. } => "1",
    };
    columns.push::<Float64Type>(PENALTIES[0], unit, penalties.iter().map(|p| p[0]));
    columns.push::<Float64Type>(PENALTIES[1], "1", penalties.iter().map(|p| p[1]));
    columns.push::<Float64Type>(PENALTIES[2], "1", penalties.iter().map(|p| -p[0] - p[1]));
    for (k, slot) in decisions.slots().iter().enumerate() {
        columns.push::<Float64Type>(&format!("{DECISION}{}", slot.name), slot.unit, decisions.values(k));
    }
    columns.write(file, spaces, identity)
}

/// Prefix of the columns with the controller's decisions.
const DECISION: &str = "decision: ";

/// The identity of a trajectory, besides its spaces.
pub struct Identity {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// Name of the controller.
    pub controller: String,
    /// SHA-256 of the weather file.
    pub weather_sha256: String,
    /// SHA-256 of all values.
    pub trajectory_hash: String,
    /// Discomfort of a whole episode with bands, K·h per zone: the integral from the start, which is not in the columns.
    pub discomfort: Option<f64>,
    /// Amount of the task's resource over a whole episode, in the unit of the resource. The penalty lacks it at weight 0.
    pub resource: Option<f64>,
}

/// A trajectory read from a file, with the file's metadata.
pub struct Stored {
    metadata: HashMap<String, String>,
    /// Names of the observations.
    observations: Vec<String>,
    pub trajectory: Trajectory,
}

impl Stored {
    /// Reads a file, or the one in an output folder of `b2b run`. Errors if its content does not match its hashes.
    pub fn read(path: &Path) -> Result<Self> {
        let within = path.is_dir().then(|| path.join(NAME));
        let path = within.as_deref().unwrap_or(path);
        let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        let not_ours = || format!("{} is not a trajectory written by b2b run", path.display());
        let stored = Self::of(file).with_context(not_ours)?;
        if stored.metadata.get(DIGEST) != Some(&digest(&stored.metadata)) {
            bail!(
                "{} was changed: its metadata do not match their SHA-256; run the episode again",
                path.display()
            );
        }
        let (found, expected) =
            (stored.trajectory.hash(), stored.word("trajectory_hash").with_context(not_ours)?);
        if found != expected {
            bail!(
                "{} was changed: its trajectory hash is {found}, expected {expected}; run the episode again",
                path.display()
            );
        }
        Ok(stored)
    }

    fn of(file: File) -> Result<Self> {
        let (schema, batches) = read_parquet(file)?;
        let metadata = schema.metadata().clone();
        let names: Vec<String> = schema.fields().iter().map(|field| field.name().clone()).collect();
        let width = names.iter().take_while(|name| !name.starts_with(DECISION)).count();
        let observed: usize = metadata.get("observations").context("no number of observations")?.parse()?;
        let acted = width.checked_sub(CALENDAR + PENALTIES.len() + observed).context("too few columns")?;
        let mut trajectory = Trajectory::default();
        for batch in batches {
            let columns: Vec<&[f64]> =
                batch.columns()[CALENDAR..].iter().map(values).collect::<Result<_>>()?;
            for row in 0..batch.num_rows() {
                let step: Vec<f64> = columns.iter().map(|column| column[row]).collect();
                trajectory.observations.extend(&step[..observed]);
                trajectory.actions.extend(&step[observed..observed + acted]);
                trajectory.penalties.push([step[observed + acted], step[observed + acted + 1]]);
            }
        }
        let observations = names[CALENDAR..CALENDAR + observed].to_vec();
        Ok(Self { metadata: metadata.into(), observations, trajectory })
    }

    /// Returns an entry of the metadata.
    pub fn word(&self, key: &str) -> Result<&str> {
        Ok(self.metadata.get(key).with_context(|| format!("its metadata have no `{key}`"))?)
    }

    /// Returns the discomfort of the episode, K·h per zone; `None` in older files, of targets or of a part.
    pub fn discomfort(&self) -> Option<f64> {
        self.number(DISCOMFORT)
    }

    /// Returns the amount of the task's resource; `None` in older files, or of a part.
    pub fn resource(&self) -> Option<f64> {
        self.number(RESOURCE)
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.word(key).ok()?.parse().ok()
    }

    /// Returns the calendar of the first day; the usual one in older files.
    pub fn calendar(&self) -> Calendar {
        let year = self.word(YEAR).ok().and_then(|year| year.parse().ok());
        year.map_or_else(Calendar::default, Calendar::of_year)
    }

    /// Returns the values of an observation by its name, one at the end of each step.
    pub fn observed(&self, name: &str) -> Option<Vec<f64>> {
        let slot = self.observations.iter().position(|each| each == name)?;
        Some(self.trajectory.observed(slot).collect())
    }
}

fn values(column: &ArrayRef) -> Result<&[f64]> {
    let column =
        column.as_any().downcast_ref::<PrimitiveArray<Float64Type>>().context("a column of another type")?;
    if column.null_count() > 0 {
        bail!("a column with missing values");
    }
    Ok(column.values())
}

/// Returns the SHA-256 of the metadata: a line `KEY=VALUE` for each entry except the digest, ordered by key.
fn digest(metadata: &HashMap<String, String>) -> String {
    let mut entries: Vec<_> = metadata.iter().filter(|(key, _)| **key != DIGEST).collect();
    entries.sort();
    // Arrow adds an entry with its schema.
    let ours = entries.into_iter().filter(|(key, _)| !key.starts_with("ARROW:"));
    sha256(ours.map(|(key, value)| format!("{key}={value}\n")).collect::<String>())
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
        let period = spaces.episode.period;
        let ends = || 1..=steps;
        let date = |step: usize| period.date((step / (24 * per_hour)) as u32);
        self.push::<UInt32Type>("step", "1", ends().map(|step| step as u32));
        self.push::<UInt8Type>("month", "1", ends().map(|step| date(step).month() as u8));
        self.push::<UInt8Type>("day", "1", ends().map(|step| date(step).day() as u8));
        self.push::<UInt8Type>("hour", "h", ends().map(|step| (step / per_hour % 24) as u8));
        self.push::<UInt8Type>("minute", "min", ends().map(|step| (step % per_hour * 60 / per_hour) as u8));
    }

    fn write(self, file: &mut (impl Write + Send), spaces: &Spaces, identity: Identity) -> Result<()> {
        let EpisodeConfig { period, task, .. } = &spaces.episode;
        let metadata = [
            ("building", spaces.building.name.clone()),
            ("place", identity.place),
            ("period", period.to_string()),
            ("controller", identity.controller),
            ("task", task.to_string()),
            ("task_hash", task.hash()),
            ("versions", serde_json::to_string(&Versions::current())?),
            ("task_definition", serde_json::to_string(task)?),
            ("weather_sha256", identity.weather_sha256),
            ("trajectory_hash", identity.trajectory_hash),
            ("observations", spaces.observation.len().to_string()),
            (YEAR, period.years()[0].to_string()),
        ];
        let mut metadata = HashMap::from(metadata.map(|(key, value)| (key.to_owned(), value)));
        for (key, amount) in [(DISCOMFORT, identity.discomfort), (RESOURCE, identity.resource)] {
            metadata.extend(amount.map(|amount| (key.to_owned(), amount.to_string())));
        }
        let digest = digest(&metadata);
        metadata.insert(DIGEST.to_owned(), digest);
        let schema = Arc::new(Schema::new_with_metadata(self.fields, metadata));
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let mut writer = ArrowWriter::try_new(file, Arc::clone(&schema), Some(properties))?;
        writer.write(&RecordBatch::try_new(schema, self.arrays)?)?;
        writer.close()?;
        Ok(())
    }
}
