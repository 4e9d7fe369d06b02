//! The folder of a result.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{About, Entry, Measures, UNFINISHED};
use crate::error::at;
use crate::evaluation::{Row, Versions, read_stages, write, write_stages};
use crate::problem::{Problem, Stage};
use crate::subject::hex;
use crate::{Error, Result};

/// What was run, in a folder.
const RESULT: &str = "result.json";
/// Its episodes.
const EPISODES: &str = "episodes.parquet";
/// Its networks.
pub(super) const POLICY: &str = "policy";
/// Raised when the form of a result changes.
const FORMAT: u32 = 1;

/// What was run, and what it came to: `result.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunResult {
    /// Of this form.
    pub format: u32,
    /// Name on the leaderboard.
    pub name: String,
    /// How the policy came about.
    pub description: Option<String>,
    /// Steps that it was trained for, as who ran it says.
    pub training_steps: Option<u64>,
    /// The problem, whole.
    pub problem: Problem,
    /// [`Problem::hash`].
    pub problem_hash: String,
    /// [`Problem::changes`]; `None` for a problem of somebody's own.
    pub problem_changes: Option<Vec<String>>,
    /// Who acted, by stage.
    pub policies: BTreeMap<String, About>,
    /// With which seeds, by stage.
    pub seeds: BTreeMap<String, Vec<u64>>,
    /// What made it.
    pub versions: Versions,
    /// How many rows each stage has in `episodes.parquet`.
    pub episodes: BTreeMap<String, usize>,
    /// SHA-256 of `episodes.parquet`.
    pub episodes_sha256: String,
    /// What the episodes come to.
    pub measures: Measures,
}

impl RunResult {
    /// Of an entry whose stages have run.
    pub(super) fn of(entry: &Entry, stages: &[(Stage, Vec<Row>)]) -> Result<Self> {
        let versions = Versions::current();
        let problem = &entry.problem;
        let measures = Measures::of(stages).ok_or_else(|| Error::Problem {
            name: problem.name.clone(),
            why: "there is no score to measure".into(),
        })?;
        Ok(Self {
            format: FORMAT,
            name: entry.name.clone(),
            description: entry.description.clone(),
            training_steps: entry.training_steps,
            problem: problem.clone(),
            problem_hash: problem.hash(),
            problem_changes: problem.changes(),
            policies: entry
                .stages()
                .into_iter()
                .map(|stage| (stage.to_string(), entry.entrant(stage).about()))
                .collect(),
            seeds: entry
                .stages()
                .into_iter()
                .map(|stage| (stage.to_string(), entry.entrant(stage).seeds(&problem.protocol.seeds)))
                .collect(),
            episodes: stages.iter().map(|(stage, rows)| (stage.to_string(), rows.len())).collect(),
            episodes_sha256: hex(&table(stages, &versions)?),
            versions,
            measures,
        })
    }

    /// Writes the folder: the result itself last, so that a folder with it is whole.
    pub(super) fn write(&self, entry: &Entry, stages: &[(Stage, Vec<Row>)], folder: &Path) -> Result<()> {
        let files: Vec<_> =
            entry.stages().into_iter().flat_map(|stage| entry.entrant(stage).files()).collect();
        if !files.is_empty() {
            let policies = folder.join(POLICY);
            std::fs::create_dir_all(&policies).map_err(at(&policies))?;
            for (path, name) in files {
                let bytes = std::fs::read(path).map_err(at(path))?;
                write(&policies.join(name), |file| std::io::Write::write_all(file, &bytes))?;
            }
        }
        let table = table(stages, &self.versions)?;
        write(&folder.join(EPISODES), |file| std::io::Write::write_all(file, &table))?;
        write(&folder.join(RESULT), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            std::io::Write::write_all(file, b"\n")
        })
    }

    /// Whether a folder's result is that of an entry.
    pub(super) fn refuse_other(&self, here: &Self, folder: &Path) -> Result<()> {
        let value = |result: &Self| serde_json::to_value(result).expect("it is plain data");
        let mut paths = Vec::new();
        crate::problem::differences("", &value(self), &value(here), &mut paths);
        // These follow from the episodes.
        paths.retain(|path| !path.starts_with("measures") && !path.starts_with("episodes"));
        if paths.is_empty() {
            return Ok(());
        }
        Err(Error::OtherEvaluation { folder: folder.to_owned(), differences: paths.join(", ") })
    }
}

/// The bytes of the table.
fn table(stages: &[(Stage, Vec<Row>)], versions: &Versions) -> Result<Vec<u8>> {
    let named: Vec<_> = stages.iter().map(|(stage, rows)| (stage.to_string(), rows.clone())).collect();
    let mut bytes = Vec::new();
    write_stages(&mut bytes, &named, versions)
        .map_err(|source| Error::Table { path: PathBuf::from(EPISODES), source })?;
    Ok(bytes)
}

/// The episodes of each stage, in order.
pub type Stages = Vec<(Stage, Vec<Row>)>;

/// The result of a folder, with its rows by stage.
///
/// # Errors
/// [`Error::Unfinished`] and [`Error::NoResult`] where there is none; [`Error::Damaged`]; [`Error::Forged`] when the
/// episodes are not those that it says; [`Error::Io`].
pub fn read_result(folder: &Path) -> Result<(RunResult, Stages)> {
    match there(folder)? {
        Some(found) => Ok(found),
        None if folder.join(UNFINISHED).exists() => Err(Error::Unfinished { folder: folder.to_owned() }),
        None => Err(Error::NoResult { folder: folder.to_owned() }),
    }
}

/// The result of a folder, if it has one.
pub(super) fn there(folder: &Path) -> Result<Option<(RunResult, Stages)>> {
    let path = folder.join(RESULT);
    if !path.exists() {
        return Ok(None);
    }
    let damaged = |path: &Path, why: String| Error::Damaged { path: path.to_owned(), why };
    let file = BufReader::new(File::open(&path).map_err(at(&path))?);
    let value: Value = serde_json::from_reader(file).map_err(|error| damaged(&path, error.to_string()))?;
    if value["format"] != FORMAT {
        let why = format!("its format is {}, and this program reads {FORMAT}", value["format"]);
        return Err(damaged(&path, why));
    }
    let result: RunResult =
        serde_json::from_value(value).map_err(|error| damaged(&path, error.to_string()))?;
    let episodes = folder.join(EPISODES);
    let bytes = std::fs::read(&episodes).map_err(at(&episodes))?;
    let file = File::open(&episodes).map_err(at(&episodes))?;
    let read = read_stages(file).map_err(|error| damaged(&episodes, error.to_string()))?;
    if hex(&bytes) != result.episodes_sha256 {
        let what = format!("{EPISODES} is not the one that {RESULT} was made from");
        return Err(Error::Forged { folder: folder.to_owned(), what });
    }
    let mut stages = Stages::new();
    for (name, row) in read {
        let stage: Stage =
            name.parse().map_err(|()| damaged(&episodes, format!("there is no stage `{name}`")))?;
        match stages.last_mut() {
            Some((last, rows)) if *last == stage => rows.push(row),
            _ => stages.push((stage, vec![row])),
        }
    }
    Ok(Some((result, stages)))
}

/// A folder for a new run has nothing but what was left of the same.
pub(super) fn refuse_foreign(folder: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() { Err(Error::Foreign { folder: folder.to_owned() }) } else { Ok(()) };
    };
    for entry in entries {
        let name = entry.map_err(at(folder))?.file_name();
        let name = name.to_string_lossy();
        let ours = [UNFINISHED, POLICY, EPISODES].contains(&&*name) || name.ends_with(".aside");
        if !ours {
            return Err(Error::Foreign { folder: folder.to_owned() });
        }
    }
    Ok(())
}
