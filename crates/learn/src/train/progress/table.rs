//! A row for every update, as `progress.csv` and as TensorBoard events.

use std::path::Path;

use b2b_base::aside::write_whole;

use super::journal::Journal;
use super::tensorboard::EventFile;
use crate::error::{Error, Result, at};

/// Name of the table.
pub const TABLE: &str = "progress.csv";
/// Name of the folder of TensorBoard events.
const EVENTS: &str = "tensorboard";
/// The first column.
const STEPS: &str = "steps";

/// An update as named numbers, with the same names in every row of a run. Unknown numbers are NaN, and empty cells in
/// the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgressRow {
    /// Environment steps so far.
    pub steps: u64,
    /// The numbers.
    pub values: Vec<(&'static str, f64)>,
}

impl ProgressRow {
    /// Returns the number with a name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(each, value)| *each == name && value.is_finite()).map(|(_, value)| *value)
    }
}

/// Writes the rows of a run.
pub(crate) struct ProgressFiles {
    table: Journal,
    /// `None` when the folder cannot be written.
    events: Option<EventFile>,
}

impl ProgressFiles {
    /// Opens the files in a run's folder, dropping the table's rows after `steps` from an earlier part of the run. The
    /// second value is a warning about events that cannot be written.
    pub(crate) fn open(folder: &Path, steps: u64) -> Result<(Self, Option<String>)> {
        let path = folder.join(TABLE);
        let kept = kept_lines(&path, steps)?;
        write_whole(&path, kept.as_bytes()).map_err(at(&path))?;
        let table = Journal::open(&path)?;
        let (events, warning) = match EventFile::create(&folder.join(EVENTS)) {
            Ok(events) => (Some(events), None),
            Err(error) => (None, Some(format!("no TensorBoard events are written: {error}"))),
        };
        Ok((Self { table, events }, warning))
    }

    /// Adds a row.
    pub(crate) fn write(&mut self, row: &ProgressRow) -> Result<()> {
        let mut text = String::new();
        if self.table.is_empty() {
            let names: Vec<&str> = row.values.iter().map(|(name, _)| *name).collect();
            text = format!("{STEPS},{}\n", names.join(","));
        }
        let cell = |value: f64| if value.is_finite() { value.to_string() } else { String::new() };
        let cells: Vec<String> = row.values.iter().map(|(_, value)| cell(*value)).collect();
        text += &format!("{},{}\n", row.steps, cells.join(","));
        let written = self.table.append(text.as_bytes());
        let events = self.events.as_mut().map_or(Ok(()), |events| events.scalars(row.steps, &row.values));
        written.and(events)
    }
}

/// Returns the lines of a table up to a number of steps, with their header; empty if there are none.
fn kept_lines(path: &Path, steps: u64) -> Result<String> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(String::new()),
        Err(error) => return Err(at(path)(error)),
    };
    // Without a checkpoint, a run starts over with its first evaluation.
    let is_kept = |line: &&str| steps > 0 && steps_of(line).is_some_and(|at| at <= steps);
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    let kept: Vec<&str> = lines.filter(is_kept).collect();
    Ok(if kept.is_empty() { String::new() } else { format!("{header}\n{}\n", kept.join("\n")) })
}

fn steps_of(line: &str) -> Option<u64> {
    line.split(',').next()?.parse().ok()
}

/// Reads a column of a run's table: steps and numbers, without empty cells.
///
/// # Errors
/// [`Error::Io`]; [`Error::Invalid`] when the table has no such column.
pub fn read_column(folder: &Path, name: &str) -> Result<Vec<(u64, f64)>> {
    let path = folder.join(TABLE);
    let text = std::fs::read_to_string(&path).map_err(at(&path))?;
    let mut lines = text.lines();
    let mut names = lines.next().unwrap_or_default().split(',');
    let column = names.position(|each| each == name);
    let column =
        column.ok_or_else(|| Error::Invalid(format!("{} has no column `{name}`", path.display())))?;
    let cell = |line: &str| Some((steps_of(line)?, line.split(',').nth(column)?.parse().ok()?));
    Ok(lines.filter_map(cell).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_continues_from_the_steps_of_a_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let row = |steps, score| ProgressRow { steps, values: vec![("loss", 0.5), ("score", score)] };
        let (mut progress, warning) = ProgressFiles::open(folder.path(), 0).unwrap();
        assert_eq!(warning, None);
        for (steps, score) in [(10, f64::NAN), (20, 0.9), (30, 0.8)] {
            progress.write(&row(steps, score)).unwrap();
        }
        drop(progress);
        let (mut progress, _) = ProgressFiles::open(folder.path(), 20).unwrap();
        progress.write(&row(30, 0.7)).unwrap();
        let text = std::fs::read_to_string(folder.path().join(TABLE)).unwrap();
        assert_eq!(text, "steps,loss,score\n10,0.5,\n20,0.5,0.9\n30,0.5,0.7\n");
        assert_eq!(read_column(folder.path(), "score").unwrap(), [(20, 0.9), (30, 0.7)]);
        assert!(read_column(folder.path(), "none").is_err());
    }

    #[test]
    fn a_folder_of_events_that_cannot_be_written_is_a_warning() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(EVENTS), "in the way").unwrap();
        let (mut progress, warning) = ProgressFiles::open(folder.path(), 0).unwrap();
        assert!(warning.unwrap().contains("TensorBoard"));
        progress.write(&ProgressRow { steps: 1, values: vec![("loss", 1.0)] }).unwrap();
    }
}
