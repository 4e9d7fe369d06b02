//! The folder of a result.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use b2b_base::aside::{is_unfinished, write_whole};
use b2b_base::digest::sha256;
use b2b_control::Versions;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::definition::Entry;
use super::entry_policy::PolicyDescription;
use super::measures::Measures;
use crate::error::at;
use crate::problem::{Problem, Stage, differences};
use crate::{Error, Result};
use b2b_evaluate::{EpisodeResult, read_stages, write_stages};

/// The result file.
const RESULT: &str = "result.json";
/// The table of episodes.
const EPISODES: &str = "episodes.parquet";
/// The folder of the policies' files.
pub(super) const POLICY: &str = "policy";
/// The folder of stages that have not all ended.
pub(super) const UNFINISHED: &str = "unfinished";
/// Version of the format of a result.
const FORMAT: u32 = 3;

/// The result of a run: `result.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunResult {
    /// Version of the format.
    pub format: u32,
    /// Name on the leaderboard.
    pub name: String,
    /// How the policy was made.
    pub description: Option<String>,
    /// Training steps, as declared by the user.
    pub training_steps: Option<u64>,
    /// The whole problem.
    pub problem: Problem,
    /// [`Problem::hash`].
    pub problem_hash: String,
    /// [`Problem::changes`]; `None` for a custom problem.
    pub problem_changes: Option<Vec<String>>,
    /// Policies by stage.
    pub policies: BTreeMap<String, PolicyDescription>,
    /// Seeds by stage.
    pub seeds: BTreeMap<String, Vec<u64>>,
    /// Versions that the result depends on.
    pub versions: Versions,
    /// [`b2b_base::machine::fingerprint`]: machines with the same one give the same bits.
    pub machine: String,
    /// Number of rows in `episodes.parquet` by stage.
    pub episodes: BTreeMap<String, usize>,
    /// SHA-256 of `episodes.parquet`.
    pub episodes_sha256: String,
    /// Measures over the episodes.
    pub measures: Measures,
}

impl RunResult {
    /// Returns the result of an entry whose stages have run.
    pub(super) fn of(entry: &Entry, stages: &[(Stage, Vec<EpisodeResult>)]) -> Result<Self> {
        let versions = Versions::current();
        let problem = &entry.problem;
        let measures = Measures::of(stages, problem.protocol.consecutive())
            .ok_or_else(|| problem.error("no episode has a score".into()))?;
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
                .map(|stage| (stage.to_string(), entry.policy_of(stage).description()))
                .collect(),
            seeds: entry
                .stages()
                .into_iter()
                .map(|stage| (stage.to_string(), entry.policy_of(stage).seeds(&problem.protocol.seeds)))
                .collect(),
            episodes: stages.iter().map(|(stage, rows)| (stage.to_string(), rows.len())).collect(),
            episodes_sha256: sha256(table(stages, &versions)?),
            versions,
            machine: b2b_base::machine::fingerprint(),
            measures,
        })
    }

    /// Returns the name of a policy in the author's own program, if there is one. Its episodes cannot be run again.
    pub fn external(&self) -> Option<&str> {
        self.policies.values().find_map(|policy| match policy {
            PolicyDescription::External { name, .. } => Some(name.as_str()),
            _ => None,
        })
    }

    /// Returns whether its measures are what its episodes give.
    pub(super) fn has_measures_of(&self, stages: &[(Stage, Vec<EpisodeResult>)]) -> bool {
        Measures::of(stages, self.problem.protocol.consecutive()).is_some_and(|own| own == self.measures)
    }

    /// Errors unless what a leaderboard shows follows from the problem and the episodes.
    ///
    /// # Errors
    /// [`Error::Modified`] with the part that does not.
    pub fn check_shown(&self, stages: &Stages, folder: &Path) -> Result<()> {
        let what = if !self.has_measures_of(stages) {
            "measures"
        } else if self.problem.changes() != self.problem_changes {
            "problem_changes"
        } else {
            return Ok(());
        };
        let what = format!("`{what}` in {RESULT} differs from what the problem and the episodes give");
        Err(Error::Modified { folder: folder.to_owned(), what })
    }

    /// Writes the folder, `result.json` last, so that a folder with it is complete.
    pub(super) fn write(
        &self,
        entry: &Entry,
        stages: &[(Stage, Vec<EpisodeResult>)],
        folder: &Path,
    ) -> Result<()> {
        entry.stages().into_iter().try_for_each(|stage| entry.policy_of(stage).check_files())?;
        let files: Vec<_> =
            entry.stages().into_iter().flat_map(|stage| entry.policy_of(stage).files()).collect();
        if !files.is_empty() {
            let policies = folder.join(POLICY);
            std::fs::create_dir_all(&policies).map_err(at(&policies))?;
            for (path, name) in files {
                let bytes = std::fs::read(&path).map_err(at(&path))?;
                let copy = policies.join(name);
                let parent = copy.parent().unwrap_or(&policies);
                std::fs::create_dir_all(parent).map_err(at(parent))?;
                write_whole(&copy, &bytes).map_err(at(&copy))?;
            }
        }
        let table = table(stages, &self.versions)?;
        let episodes = folder.join(EPISODES);
        write_whole(&episodes, &table).map_err(at(&episodes))?;
        let mut text = serde_json::to_vec_pretty(self).expect("plain data always serializes");
        text.push(b'\n');
        let result = folder.join(RESULT);
        write_whole(&result, &text).map_err(at(&result))
    }

    /// Errors unless the folder's result belongs to this entry.
    pub(super) fn check_same(&self, here: &Self, folder: &Path) -> Result<()> {
        let value = |result: &Self| serde_json::to_value(result).expect("plain data always serializes");
        let mut paths = Vec::new();
        differences("", &value(self), &value(here), &mut paths);
        // Derived from the episodes.
        paths.retain(|path| !path.starts_with("measures") && !path.starts_with("episodes"));
        if paths.is_empty() {
            return Ok(());
        }
        Err(b2b_evaluate::Error::OtherEvaluation { folder: folder.to_owned(), differences: paths.join(", ") }
            .into())
    }
}

/// Returns the bytes of the table.
fn table(stages: &[(Stage, Vec<EpisodeResult>)], versions: &Versions) -> Result<Vec<u8>> {
    let named: Vec<_> = stages.iter().map(|(stage, rows)| (stage.to_string(), rows.clone())).collect();
    let mut bytes = Vec::new();
    write_stages(&mut bytes, &named, versions)
        .map_err(|source| b2b_evaluate::Error::Table { path: PathBuf::from(EPISODES), source })?;
    Ok(bytes)
}

/// The rows of each stage, in order.
pub type Stages = Vec<(Stage, Vec<EpisodeResult>)>;

/// Returns the rows of a stage; `None` if it did not run.
pub fn rows_of(stages: &[(Stage, Vec<EpisodeResult>)], stage: Stage) -> Option<&[EpisodeResult]> {
    stages.iter().find(|(each, _)| *each == stage).map(|(_, rows)| rows.as_slice())
}

/// Returns the result of a folder, and its rows by stage.
///
/// # Errors
/// [`Error::Unfinished`] and [`Error::NoResult`] if there is none; [`Error::Damaged`](b2b_evaluate::Error::Damaged);
/// [`Error::Modified`] if the episodes do not match the result; [`Error::Io`](b2b_evaluate::Error::Io).
pub fn read_result(folder: &Path) -> Result<(RunResult, Stages)> {
    match find_result(folder)? {
        Some(found) => Ok(found),
        None if folder.join(UNFINISHED).exists() => Err(Error::Unfinished { folder: folder.to_owned() }),
        None => Err(Error::NoResult { folder: folder.to_owned() }),
    }
}

/// Returns the result in a folder, if there is one.
pub(super) fn find_result(folder: &Path) -> Result<Option<(RunResult, Stages)>> {
    let path = folder.join(RESULT);
    if !path.exists() {
        return Ok(None);
    }
    let damaged =
        |path: &Path, why: String| b2b_evaluate::Error::Damaged { path: path.to_owned(), why }.into();
    let file = BufReader::new(File::open(&path).map_err(at(&path))?);
    let value: Value = serde_json::from_reader(file).map_err(|error| damaged(&path, error.to_string()))?;
    if value["format"] != FORMAT {
        let why = format!("its format is {}; this program reads format {FORMAT}", value["format"]);
        return Err(damaged(&path, why));
    }
    let result: RunResult =
        serde_json::from_value(value).map_err(|error| damaged(&path, error.to_string()))?;
    let episodes = folder.join(EPISODES);
    let bytes = std::fs::read(&episodes).map_err(at(&episodes))?;
    let file = File::open(&episodes).map_err(at(&episodes))?;
    let read = read_stages(file).map_err(|error| damaged(&episodes, error.to_string()))?;
    if sha256(&bytes) != result.episodes_sha256 {
        let what = format!("{EPISODES} is not the table that {RESULT} was made from");
        return Err(Error::Modified { folder: folder.to_owned(), what });
    }
    let mut stages = Stages::new();
    for (name, row) in read {
        let stage: Stage = name.parse().map_err(|why| damaged(&episodes, why))?;
        match stages.last_mut() {
            Some((last, rows)) if *last == stage => rows.push(row),
            _ => stages.push((stage, vec![row])),
        }
    }
    Ok(Some((result, stages)))
}

/// Errors if a part of a result is a link to another result, which a run would write to or mistake for its own.
pub(super) fn check_no_links(folder: &Path) -> Result<()> {
    if [RESULT, EPISODES, POLICY, UNFINISHED].iter().any(|name| folder.join(name).is_symlink()) {
        return Err(b2b_evaluate::Error::UnrelatedFiles { folder: folder.to_owned() }.into());
    }
    Ok(())
}

/// Errors if the folder of a new run contains anything but leftovers of an interrupted run.
pub(super) fn check_new(folder: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() {
            Err(b2b_evaluate::Error::UnrelatedFiles { folder: folder.to_owned() }.into())
        } else {
            Ok(())
        };
    };
    for entry in entries {
        let name = entry.map_err(at(folder))?.file_name();
        let leftover = [UNFINISHED, POLICY, EPISODES].iter().any(|each| name == *each);
        if !leftover && !is_unfinished(name.as_ref()) {
            return Err(b2b_evaluate::Error::UnrelatedFiles { folder: folder.to_owned() }.into());
        }
    }
    Ok(())
}
