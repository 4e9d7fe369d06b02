//! Measured speeds of training runs and environments, for estimates.

use std::collections::BTreeMap;

use b2b_building::BuildingType;
use b2b_evaluate::statistics::quantile;
use serde_json::Value;
use toml::Table;

use crate::definition::{Budget, Experiment};
use crate::error::Result;
use crate::folder::{Folder, JobResult};
use crate::job::{Action, Job};

/// The shipped table, which `b2b experiment rates` printed. Rows timed by `bench` are the steps per CPU second of the
/// design `fragments` in `b2b bench train`.
const SHIPPED: &str = include_str!("../data/rates.csv");
/// Name used instead of a preset for an environment without a learner, measured in CPU time of one core.
pub(crate) const ENVIRONMENT: &str = "environment";
/// Name used instead of a type for training runs on several types.
const SEVERAL: &str = "several";
/// The quantile of a type's training runs that counts, because they differ mostly by the other load on the machine.
const QUANTILE: f64 = 0.75;
/// The preset whose rates are used for options without a preset, or with a preset that was not measured.
const DEFAULT: &str = "residual";

/// A measured speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Rate {
    /// Building type, or `several`.
    pub building_type: String,
    /// Preset of the training, or `environment`.
    pub preset: String,
    /// Environment steps per second.
    pub steps_per_s: f64,
    /// Number of trainings.
    pub count: usize,
    /// What was timed: `training` without evaluations, whole `job`s, or `steps`.
    pub timed: &'static str,
}

/// Returns the speeds in folders of results, by type and preset: of trainings if their job folders are available,
/// otherwise of whole jobs; and of environments, from the experiment `speed`.
///
/// # Errors
/// Errors from reading the files of jobs that are marked as done.
pub fn rates(folders: &[(Folder, Experiment, Budget)]) -> Result<Vec<Rate>> {
    let mut timed: BTreeMap<(String, String, &'static str), Vec<f64>> = BTreeMap::new();
    for (folder, experiment, budget) in folders {
        for job in experiment.jobs(budget) {
            let Some(result) = folder.result(&job, experiment.report)? else { continue };
            for (building_type, rate) in environments(&result) {
                timed.entry((ENVIRONMENT.into(), building_type, "steps")).or_default().push(rate);
            }
            if let Some((preset, building_type, what, rate)) = training(folder, &job, &result) {
                timed.entry((preset, building_type, what)).or_default().push(rate);
            }
        }
    }
    let has_trainings: Vec<String> =
        timed.keys().filter(|(.., what)| *what == "training").map(|(preset, ..)| preset.clone()).collect();
    timed.retain(|(preset, _, what), _| *what != "job" || !has_trainings.contains(preset));
    let rate = |((preset, building_type, timed), mut rates): (_, Vec<f64>)| {
        rates.sort_by(f64::total_cmp);
        Rate { building_type, preset, steps_per_s: quantile(&rates, QUANTILE), count: rates.len(), timed }
    };
    Ok(timed.into_iter().map(rate).collect())
}

/// Returns speeds as the text of a table.
pub fn rates_text(rates: &[Rate]) -> String {
    let line = |rate: &Rate| {
        let Rate { building_type, preset, steps_per_s, count, timed } = rate;
        format!("{building_type},{preset},{steps_per_s:.0},{count},{timed}\n")
    };
    "type,preset,steps_per_s,count,timed\n".to_owned() + &rates.iter().map(line).collect::<String>()
}

/// Returns the speeds of environments that a measurement printed.
fn environments(result: &JobResult) -> Vec<(String, f64)> {
    let speed =
        |entry: &Value| Some((entry["type"].as_str()?.to_owned(), 1000.0 / entry["env_ms"].as_f64()?));
    result.measured.as_array().into_iter().flatten().filter_map(speed).collect()
}

/// Returns the preset and type of a job's training run, what was timed, and the speed; `None` unless the job has
/// exactly one training run.
fn training(folder: &Folder, job: &Job, result: &JobResult) -> Option<(String, String, &'static str, f64)> {
    let [Action::Train { agent, config, steps }, ..] = &job.actions[..] else { return None };
    if matches!(job.actions.last(), Some(Action::Enter(_))) {
        return None;
    }
    let (what, rate) = match folder.job(job).training_rate(agent) {
        Some(rate) => ("training", rate),
        None => ("job", *steps as f64 / result.seconds),
    };
    Some((preset(config).to_owned(), type_of(job), what, rate))
}

/// Returns the speed of a job's training run according to the shipped table, steps/s.
pub(crate) fn of_training(job: &Job) -> f64 {
    let preset = job.actions.iter().find_map(|action| match action {
        Action::Train { config, .. } => Some(preset(config)),
        _ => None,
    });
    of(&type_of(job), preset.unwrap_or(DEFAULT))
}

/// Returns the speed of environments of a type according to the shipped table, steps/s.
pub(crate) fn of_environment(building_type: BuildingType) -> f64 {
    of(building_type.name(), ENVIRONMENT)
}

/// Returns the measured speed. A type that was not measured with the preset gets the speed of the most similar type,
/// scaled by the ratio of their environments' speeds. Several types are as fast as the slowest.
fn of(building_type: &str, preset: &str) -> f64 {
    let measured = |preset: &str| shipped().filter(|row| row[1] == preset).collect::<Vec<_>>();
    let mut rows = measured(preset);
    if rows.is_empty() {
        rows = measured(DEFAULT);
    }
    let speed = |row: &[&'static str]| row[2].parse::<f64>().expect("a test reads the table");
    if let Some(own) = rows.iter().find(|row| row[0] == building_type) {
        return speed(own);
    }
    let environments = measured(ENVIRONMENT);
    let slowest = environments.iter().map(|row| speed(row)).fold(f64::INFINITY, f64::min);
    let environment =
        |name: &str| environments.iter().find(|row| row[0] == name).map_or(slowest, |row| speed(row));
    let own = environment(building_type);
    let scaled = rows.iter().map(|row| (own / environment(row[0]), speed(row)));
    let nearest = scaled.min_by(|a, b| a.0.ln().abs().total_cmp(&b.0.ln().abs()));
    nearest.map_or(own, |(ratio, speed)| speed * ratio)
}

fn shipped() -> impl Iterator<Item = Vec<&'static str>> {
    SHIPPED.lines().skip(1).map(|line| line.split(',').collect())
}

fn preset(config: &Table) -> &str {
    config.get("preset").and_then(|preset| preset.as_str()).unwrap_or("none")
}

/// Returns the type of the buildings of a job, or [`SEVERAL`].
fn type_of(job: &Job) -> String {
    let mut types: Vec<&str> = job.building_types().collect();
    types.dedup();
    match types[..] {
        [only] => only.to_owned(),
        _ => SEVERAL.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_and_preset_has_a_rate() {
        for preset in ["paper", "residual", "graph", "none", ENVIRONMENT] {
            for building_type in BuildingType::ALL {
                let rate = of(building_type.name(), preset);
                assert!(rate > 100.0 && rate < 100_000.0, "{building_type} {preset}: {rate}");
            }
            assert!(of(SEVERAL, preset) > 100.0, "{preset}");
        }
        assert!(of("SingleFamilyHouse", "paper") > 2.0 * of("OfficeSmall", "paper"));
        assert!(shipped().all(|row| row.len() == 5 && row[2].parse::<f64>().is_ok()));
    }

    #[test]
    fn rates_come_from_a_folder_by_type_and_preset() {
        let results =
            |name| Folder::open(format!("{}/../../results/{name}", env!("CARGO_MANIFEST_DIR")).as_ref());
        let found = rates(&[results("ppo").unwrap(), results("speed").unwrap()]).unwrap();
        let of = |preset: &str| found.iter().filter(|rate| rate.preset == preset).collect::<Vec<_>>();
        assert_eq!((of("paper").len(), of("residual").len(), of(ENVIRONMENT).len()), (6, 6, 6));
        assert!(of("paper").iter().all(|rate| rate.count == 16 && rate.timed == "job"), "{found:?}");
        let text = rates_text(&found);
        assert!(text.lines().count() == 19 && text.contains("SingleFamilyHouse,environment,"), "{text}");
    }
}
