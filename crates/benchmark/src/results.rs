//! An evaluation as a whole: its rows with their scores, and what they sum up to.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use b2b_env::Task;
use serde::Serialize;

use crate::baseline::{Baselines, Key, task_for};
use crate::evaluation::{
    Episode, Evaluation, Finished, Folder, Outcome, Progress, Record, Row, Versions, write_episodes,
};
use crate::policy::Policy;
use crate::statistics::{Aggregate, aggregate};
use crate::{Result, Surroundings, normalized_score, report};

const EPISODES: &str = "episodes.parquet";
const SUMMARY: &str = "summary.json";
const REPORT: &str = "report.html";
/// Seed of the bootstrap.
const SEED: u64 = 0;

/// The rows of an evaluation, in the order of its episodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// One an episode.
    pub rows: Vec<Row>,
}

/// What the rows sum up to: the object that `b2b evaluate --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// What made the results.
    pub versions: Versions,
    /// Name of the policy.
    pub policy: String,
    /// How many episodes there are.
    pub episodes: usize,
    /// Those that were lost, each with its reason.
    pub lost: Vec<Lost>,
    /// One for each task and run period.
    pub windows: Vec<Window>,
}

/// An episode without figures.
#[derive(Clone, Debug, Serialize)]
pub struct Lost {
    /// The building.
    pub building: String,
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// Seed of the policy.
    pub seed: u64,
    /// Why.
    pub why: String,
}

/// The episodes of a task on the same days.
#[derive(Clone, Debug, Serialize)]
pub struct Window {
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// By type, in the order of the episodes.
    pub types: Vec<Group>,
    /// All, each type a stratum.
    pub all: Group,
}

/// Some episodes in a few numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// What they have in common.
    pub name: String,
    /// Their scores; `None` when no episode has one.
    pub scores: Option<Aggregate>,
    /// Root mean square deviation from target, mean over episodes, K.
    pub rms_deviation_k: f64,
    /// HVAC energy, mean over episodes, Wh/m².
    pub energy_wh_m2: f64,
    /// Way of the actuators a day, in times their ranges, mean over episodes.
    pub daily_travel: f64,
}

/// An episode that ran, on its way to a row.
struct Unscored {
    record: Record,
    key: Key,
    task: Task,
}

impl Results {
    /// Runs what a folder does not hold yet of some episodes, and scores all of them; baselines that are not known are
    /// run, too.
    ///
    /// # Errors
    /// Those of [`Evaluation::run`] and [`Baselines::compute`].
    pub fn of(
        evaluation: &Evaluation<'_>,
        folder: &Folder,
        episodes: &[Episode],
        policy: &dyn Policy,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut lost = run_missing(evaluation, folder, episodes, policy, progress)?;
        let mut ran = Vec::new();
        for (number, episode) in episodes.iter().enumerate() {
            let finished =
                folder.read(number).map(|finished| Unscored::of(episode, finished, policy, baselines));
            ran.push(finished.transpose()?);
        }
        let keys = ran
            .iter()
            .zip(episodes)
            .filter_map(|(each, episode)| Some((each.as_ref()?.key.clone(), episode.clone())));
        let unknown = baselines.missing(keys);
        baselines.compute(evaluation, &unknown, progress)?;
        let row = |(number, (ran, episode)): (usize, (Option<Unscored>, &Episode))| match ran {
            Some(ran) => ran.row(baselines),
            None => {
                let why =
                    lost.remove(&number).unwrap_or_else(|| "what was kept of it cannot be read".to_owned());
                Row::lost(episode, policy, why)
            }
        };
        Ok(Self { rows: ran.into_iter().zip(episodes).enumerate().map(row).collect() })
    }

    /// Writes the table, the summary and the report into the folder that the episodes are in. Gives where they are.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io).
    pub fn write(&self, folder: &Folder, summary: &Summary) -> Result<[PathBuf; 3]> {
        folder.write(EPISODES, |file| {
            write_episodes(file, &self.rows, &summary.versions).map_err(std::io::Error::other)
        })?;
        folder.write(REPORT, |file| report::write(file, self, summary, &|number| folder.read(number)))?;
        folder.write(SUMMARY, |file| Ok(serde_json::to_writer_pretty(file, summary)?))?;
        Ok([EPISODES, SUMMARY, REPORT].map(|name| folder.path_of(name)))
    }

    /// What they sum up to.
    pub fn summary(&self, policy: &dyn Policy) -> Summary {
        let lost = self.rows.iter().filter_map(|row| {
            let Record { building, task, period, seed, .. } = row.record.clone();
            Some(Lost { building, task, period, seed, why: row.lost.clone()? })
        });
        let ran: Vec<&Row> = self.rows.iter().filter(|row| row.lost.is_none()).collect();
        let windows = grouped(&ran, |row| (row.record.task.clone(), row.record.period.clone()));
        Summary {
            versions: Versions::current(),
            policy: policy.name(),
            episodes: self.rows.len(),
            lost: lost.collect(),
            windows: windows
                .into_iter()
                .map(|((task, period), rows)| Window::of(task, period, &rows))
                .collect(),
        }
    }
}

/// Why episodes were lost, by number.
fn run_missing(
    evaluation: &Evaluation<'_>,
    folder: &Folder,
    episodes: &[Episode],
    policy: &dyn Policy,
    progress: &dyn Progress,
) -> Result<HashMap<usize, String>> {
    let missing: Vec<_> = episodes.iter().enumerate().filter(|(n, _)| folder.read(*n).is_none()).collect();
    progress.begin("episodes", missing.len(), missing.iter().map(|(_, episode)| episode.days()).sum());
    let lost = Mutex::new(HashMap::new());
    evaluation.run(&missing, policy, progress, &|number, outcome| match outcome {
        Outcome::Finished(finished) => folder.keep(number, &finished),
        Outcome::Lost(why) => {
            lost.lock().unwrap_or_else(PoisonError::into_inner).insert(number, why);
            Ok(())
        }
    })?;
    Ok(lost.into_inner().unwrap_or_else(PoisonError::into_inner))
}

impl Unscored {
    /// What the reactive controllers got is a baseline from now on.
    fn of(episode: &Episode, finished: Finished, policy: &dyn Policy, baselines: &Baselines) -> Result<Self> {
        let Finished { record, terms, .. } = finished;
        let surroundings =
            Surroundings { place: record.place.clone(), climate_zone: record.climate_zone.clone() };
        let key = Key::of(episode, &surroundings)?;
        if policy.is_baseline() && baselines.get(&key).is_none() {
            baselines.keep(&key, terms)?;
        }
        let task = task_for(&episode.subject, &surroundings, &episode.task, episode.steps_per_hour);
        Ok(Self { record, key, task })
    }

    fn row(self, baselines: &Baselines) -> Row {
        let baseline_return = baselines.get(&self.key).map(|terms| terms.episode_return(&self.task));
        let score =
            baseline_return.and_then(|baseline| normalized_score(self.record.episode_return, baseline));
        Row { record: self.record, baseline_return, score, lost: None }
    }
}

impl Window {
    fn of(task: String, period: String, rows: &[&Row]) -> Self {
        let types = grouped(rows, |row| row.record.building_type.clone());
        let strata: Vec<&[&Row]> = types.iter().map(|(_, rows)| rows.as_slice()).collect();
        let all = Group::of("all".to_owned(), &strata);
        let own = |name: &str| if name.is_empty() { "own models" } else { name }.to_owned();
        let types = types.iter().map(|(name, rows)| Group::of(own(name), &[rows])).collect();
        Self { task, period, types, all }
    }
}

impl Group {
    fn of(name: String, strata: &[&[&Row]]) -> Self {
        let scores: Vec<Vec<f64>> =
            strata.iter().map(|rows| rows.iter().filter_map(|row| row.score).collect()).collect();
        let mean = |value: fn(&Record) -> f64| {
            let values: Vec<f64> = strata.iter().copied().flatten().map(|row| value(&row.record)).collect();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        };
        Self {
            name,
            scores: aggregate(&scores, SEED),
            rms_deviation_k: mean(|record| record.rms_deviation),
            energy_wh_m2: mean(|record| record.electricity + record.gas),
            daily_travel: mean(|record| record.daily_travel),
        }
    }
}

/// Rows by a key, in the order in which keys come first.
fn grouped<'a, K: PartialEq>(rows: &[&'a Row], key: impl Fn(&Row) -> K) -> Vec<(K, Vec<&'a Row>)> {
    let mut groups: Vec<(K, Vec<&Row>)> = Vec::new();
    for row in rows {
        let key = key(row);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key, vec![row])),
        }
    }
    groups
}
