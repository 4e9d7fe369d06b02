//! The process of a job, which carries out the order of one action.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use b2b_benchmark::Problem;
use b2b_benchmark::entry::{EntryPolicy, RunOutcome};
use b2b_benchmark::problem::{Changes, Stage};
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_env::Task;
use b2b_evaluate::{ActionScale, Baselines, EpisodePlan, Evaluation, Folder, Policy, Results, Subject};
use b2b_learn::train::{Monitor, RunOptions, TrainConfig};
use b2b_workers::{Jobs, Launcher, WorkerOptions};
use serde::Serialize;

use super::order::Order;
use crate::job::{Entry, Episodes, Measurement};

/// Any error of an action.
type Fault = Box<dyn std::error::Error + Send + Sync>;

const STEPS_PER_HOUR: u32 = 12;

/// A program that carries out the actions of jobs.
pub struct Program {
    /// Starts the program as a worker.
    pub launcher: Launcher,
    /// Returns whether to stop.
    pub interrupted: fn() -> bool,
    /// Runs a benchmark of the program, and returns its result as JSON.
    pub measure: fn(&Measurement) -> Result<String, Fault>,
}

impl Program {
    /// Carries out the order of an action in the current folder, and returns its result as JSON.
    ///
    /// # Errors
    /// A damaged order; the errors of training runs, evaluations, entries and benchmarks.
    pub fn carry_out(&self, order: &str) -> Result<String, Fault> {
        match serde_json::from_str(order)? {
            Order::Train { config, out } => self.train(Path::new(&config), Path::new(&out)),
            Order::Evaluate { policy, episodes, out } => self.evaluate(&policy, &episodes, Path::new(&out)),
            Order::Enter { entry, name, out } => self.enter(entry, name, Path::new(&out)),
            Order::Measure(measurement) => (self.measure)(&measurement),
        }
    }

    fn train(&self, config: &Path, out: &Path) -> Result<String, Fault> {
        let config = TrainConfig::of_json("{}", None, Some(config))?;
        config.check()?;
        let options = RunOptions {
            out: out.to_owned(),
            catalog: Arc::new(self.catalog()?),
            launcher: self.launcher.clone(),
            jobs: 1,
            interrupted: self.interrupted,
            monitor: &mut Log,
        };
        json(&b2b_learn::train::train(&config, options)?)
    }

    fn evaluate(&self, policy: &str, episodes: &Episodes, out: &Path) -> Result<String, Fault> {
        let policy = <dyn Policy>::named(policy, ActionScale::Rescaled)?;
        let episodes = list(episodes)?;
        let summary = Folder::open(out, policy.as_ref(), &episodes)?.carry_out(|folder| {
            let catalog = self.catalog()?;
            let evaluation = self.evaluation(&catalog);
            let baselines = Baselines::open()?;
            let results = Results::of(&evaluation, folder, &episodes, policy.as_ref(), &baselines, &())?;
            let summary = results.summary(policy.as_ref());
            results.write(folder, &summary)?;
            Ok::<_, Fault>(summary)
        })?;
        match summary.lost.first() {
            Some(lost) => Err(format!("{} episodes failed, first {lost}", summary.lost.len()).into()),
            None => json(&summary),
        }
    }

    fn enter(&self, entry: Entry, name: String, out: &Path) -> Result<String, Fault> {
        let Entry { problem, policy, steps: training_steps, seeds, test, .. } = entry;
        let test = test.iter().map(|id| id.parse()).collect::<Result<_, _>>()?;
        let problem = Problem::named(&problem)?.with(&Changes { seeds, test, ..Changes::default() })?;
        let seeds = &problem.protocol.seeds;
        let episodes = problem.episodes(Stage::Test, &seeds[..1]);
        let policy = EntryPolicy::read(&policy, ActionScale::Rescaled, seeds, &episodes)?;
        let entry = b2b_benchmark::entry::Entry {
            problem,
            name,
            description: None,
            training_steps,
            policy,
            train_policy: None,
            adapted: BTreeMap::new(),
            upper_bound: None,
        };
        let catalog = self.catalog()?;
        match entry.run(out, &self.evaluation(&catalog), &Baselines::open()?, &())? {
            RunOutcome::Complete(result, _) => json(&result),
            RunOutcome::Incomplete(rows) => {
                let first = rows.first().map_or_else(String::new, |row| {
                    let why =
                        row.outcome.as_ref().map_or_else(ToString::to_string, |_| "undefined score".into());
                    format!(", first {}: {why}", row.info)
                });
                Err(format!("{} episodes failed{first}", rows.len()).into())
            }
        }
    }

    /// Loads the engine. Worker processes read and size models, so that a crash is an error.
    fn catalog(&self) -> Result<Catalog, Fault> {
        let catalog = Catalog::open(&mut Quiet)?;
        let options = WorkerOptions::new(self.launcher.clone(), catalog.library().path());
        let jobs = Jobs::new(WorkerOptions { interrupted: self.interrupted, ..options });
        Ok(catalog.hosted_by(Arc::new(jobs)))
    }

    fn evaluation<'a>(&self, catalog: &'a Catalog) -> Evaluation<'a> {
        Evaluation { catalog, launcher: self.launcher.clone(), jobs: 1, interrupted: self.interrupted }
    }
}

/// Writes the warnings of a training run to the log.
struct Log;

impl Monitor for Log {
    fn warn(&mut self, text: &str) {
        eprintln!("warning: {text}");
    }
}

/// Returns the episodes of a job.
fn list(episodes: &Episodes) -> Result<Vec<EpisodePlan>, Fault> {
    let Episodes { buildings, tasks, periods } = episodes;
    let subjects = buildings
        .iter()
        .map(|name| Ok(Subject::at_home(name.parse()?)))
        .collect::<Result<Vec<_>, Fault>>()?;
    let periods = periods.iter().map(|text| Ok(text.parse()?)).collect::<Result<Vec<_>, Fault>>()?;
    let tasks = tasks.iter().map(|text| Ok(Task::from_text(text)?)).collect::<Result<Vec<_>, Fault>>()?;
    Ok(EpisodePlan::combinations(&subjects, &periods, &tasks, &[0], STEPS_PER_HOUR))
}

fn json(result: &impl Serialize) -> Result<String, Fault> {
    Ok(serde_json::to_string_pretty(result)?)
}
