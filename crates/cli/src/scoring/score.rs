//! `b2b score`: the normalized score of a trajectory.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_base::calendar::Calendar;
use b2b_building::Period;
use b2b_climate::{EpwFile, Place};
use b2b_control::Versions;
use b2b_dataset::{BuildingName, Catalog, Control};
use b2b_env::{Comfort, EpisodeMetrics, Task};
use b2b_evaluate::{Baseline, Baselines, EpisodePlan, SiteInfo, Subject, heading_of, task_for};
use serde::Serialize;

use crate::arguments::location::Location;
use crate::program;
use crate::run::trajectory_file::Stored;
use crate::scoring::evaluation::{Bars, evaluation};
use crate::terminal::progress::Download;
use crate::terminal::stdout;

/// Score a trajectory against the baseline
///
/// Reads a trajectory.parquet written by `b2b run`. The score is its return divided by the reactive controllers' return
/// for the same building, task and run period; in tasks of operation, its cost divided by guideline36's, plus a penalty
/// for more discomfort. Lower is better; the baseline scores 1. A baseline that is not yet known is simulated
/// first and cached.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b score b2b-out/OfficeSmall-Denver-winter-random
  b2b score trajectory.parquet --building my.idf --weather my.epw"
)]
pub struct Arguments {
    /// Output folder of `b2b run`, or its trajectory.parquet
    #[arg(value_name = "RUN")]
    trajectory: PathBuf,
    /// Model file of the building, if the trajectory is of your own building
    #[arg(long, value_name = "BUILDING")]
    building: Option<BuildingName>,
    #[command(flatten)]
    location: Location,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The content of a trajectory file that is needed for its score.
struct Trajectory {
    subject: Subject,
    place: String,
    weather_sha256: Option<String>,
    period: Period,
    task: Task,
    controller: String,
    steps: usize,
    temperature_penalty: f64,
    energy_penalty: f64,
    /// K·h per zone, if the file states it.
    discomfort: Option<f64>,
    /// Amount of the task's resource, if the file states it.
    resource: Option<f64>,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Score {
    building: String,
    place: String,
    task: String,
    period: String,
    steps_per_hour: u32,
    controller: String,
    #[serde(rename = "return")]
    episode_return: f64,
    baseline_return: f64,
    score: Option<f64>,
    resolved_score: Option<f64>,
    /// The parts of the score at comfort in a task of operation.
    #[serde(flatten)]
    parts: Option<Parts>,
    /// The heading of the resource relative to the baseline.
    #[serde(skip)]
    heading: String,
}

/// Cost (or another resource of the task) relative to the baseline, and discomfort, K·h per zone.
#[derive(Serialize)]
struct Parts {
    relative_resource: Option<f64>,
    discomfort_k_h: f64,
    baseline_discomfort_k_h: f64,
}

/// Runs the command.
pub fn score(arguments: &Arguments) -> Result<()> {
    let trajectory = Trajectory::read(arguments)?;
    let steps_per_hour = trajectory.steps_per_hour(&arguments.trajectory)?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let Trajectory { subject, period, .. } = &trajectory;
    let site = find_site(&catalog, &trajectory, arguments.json)?;
    let task = trajectory.task.clone();
    let episode = EpisodePlan {
        subject: subject.clone(),
        task: task.clone(),
        period: *period,
        seed: 0,
        steps_per_hour,
    };
    let baselines = Baselines::open()?;
    let bars = Bars::new(arguments.json);
    let evaluation = evaluation(&catalog, 1);
    let baseline = baselines.baseline(&evaluation, &episode, &site, &bars)?;
    drop(bars);
    let episode_return = -trajectory.temperature_penalty - trajectory.energy_penalty;
    let (metrics, resource) =
        trajectory.scored(&task_for(subject, &site, &task, steps_per_hour), steps_per_hour);
    let scores = baseline.scores(&metrics, resource, steps_per_hour);
    let score = Score {
        building: subject.label(),
        place: trajectory.place.clone(),
        task: task.to_string(),
        period: period.to_string(),
        steps_per_hour,
        controller: trajectory.controller.clone(),
        episode_return,
        baseline_return: baseline.episode_return,
        score: scores.score,
        resolved_score: scores.resolved,
        parts: Parts::of(&metrics, resource, &baseline),
        heading: heading_of(task.resource),
    };
    stdout::print_result(arguments.json, &score, || score.text())
}

/// Finds the building's site and checks that its weather is the trajectory's.
fn find_site(catalog: &Catalog, trajectory: &Trajectory, quiet: bool) -> Result<SiteInfo> {
    let Trajectory { subject, weather_sha256, .. } = trajectory;
    let cannot = || format!("cannot prepare {}", subject.name);
    let found = catalog.find(&subject.name, &subject.placement, &mut Download::new(quiet));
    let found = found.with_context(cannot)?;
    let weather = EpwFile::open(&found.weather).with_context(cannot)?;
    if weather_sha256.as_ref().is_some_and(|there| there != weather.sha256()) {
        bail!(
            "the trajectory's weather, {}, is not the weather of {} in {}; specify it with --weather",
            trajectory.place,
            subject.name,
            found.place
        );
    }
    subject.site(&found).with_context(cannot)
}

/// Errors if the trajectory is from another version of the buildings or of the engine: its score would be meaningless.
fn check_versions(path: &Path, theirs: &Versions) -> Result<()> {
    let ours = Versions::current();
    if (&theirs.generator, &theirs.engine) != (&ours.generator, &ours.engine) {
        bail!(
            "{} was simulated with building generator {} and EnergyPlus {}, but this program has {} and {}; run the episode again",
            path.display(),
            theirs.generator,
            theirs.engine,
            ours.generator,
            ours.engine
        );
    }
    Ok(())
}

impl Parts {
    fn of(metrics: &EpisodeMetrics, resource: Option<f64>, baseline: &Baseline) -> Option<Self> {
        let usual = baseline.resource.filter(|amount| *amount > 0.0);
        Some(Self {
            relative_resource: resource.zip(usual).map(|(own, usual)| own / usual),
            discomfort_k_h: metrics.tdis_tot?,
            baseline_discomfort_k_h: baseline.discomfort?,
        })
    }
}

impl Score {
    fn text(&self) -> String {
        let Self { building, place, period, task, controller, .. } = self;
        let number =
            |number: Option<f64>| number.map_or("undefined".to_owned(), |number| format!("{number:.4}"));
        let returns = [
            ("return", format!("{:.1}", self.episode_return)),
            ("baseline return", format!("{:.1}", self.baseline_return)),
        ];
        let mut lines = Vec::from(returns);
        match &self.parts {
            Some(parts) => lines.extend([
                (&self.heading[..], number(parts.relative_resource)),
                ("discomfort", format!("{:.2} K·h per zone", parts.discomfort_k_h)),
                ("baseline's", format!("{:.2} K·h per zone", parts.baseline_discomfort_k_h)),
                ("score at comfort", number(self.score)),
            ]),
            None => {
                lines
                    .extend([("score", number(self.score)), ("resolved score", number(self.resolved_score))]);
            }
        }
        let lines: Vec<String> = lines.iter().map(|(name, value)| format!("  {name:<18}{value}")).collect();
        format!(
            "{building} in {place}, {period}, task {task}, {controller} controller\n\n{}",
            lines.join("\n")
        )
    }
}

impl Trajectory {
    fn read(arguments: &Arguments) -> Result<Self> {
        let path = &arguments.trajectory;
        let stored = Stored::read(path)?;
        let not_ours = || format!("{} is not a trajectory written by b2b run", path.display());
        let word = |key: &str| stored.word(key).with_context(not_ours);
        let (building, place) = (word("building")?, word("place")?.to_owned());
        let period: Period = word("period")?.parse()?;
        let controller = word("controller")?.to_owned();
        let task: Task = serde_json::from_str(word("task_definition")?).with_context(not_ours)?;
        task.check()?;
        let versions: Versions = serde_json::from_str(word("versions")?).with_context(not_ours)?;
        check_versions(path, &versions)?;
        let subject = arguments.subject(building, &place)?;
        let penalties = &stored.trajectory.penalties;
        let [temperature_penalty, energy_penalty] =
            [0, 1].map(|term| penalties.iter().map(|penalty| penalty[term]).sum());
        let steps = penalties.len();
        // Absent in files of older versions.
        let weather_sha256 = stored.word("weather_sha256").ok().map(str::to_owned);
        Ok(Self {
            subject,
            place,
            weather_sha256,
            period,
            task,
            controller,
            steps,
            temperature_penalty,
            energy_penalty,
            discomfort: stored.discomfort(),
            resource: stored.resource(),
        })
    }

    /// Returns the metrics that scores need, and the amount of the resource of a task with its scale. In older files,
    /// discomfort is computed from the penalties at the ends of steps, which differ from the integral by up to half a
    /// step where a band changes.
    fn scored(&self, task: &Task, steps_per_hour: u32) -> (EpisodeMetrics, Option<f64>) {
        let at_ends = match task.comfort {
            Comfort::Band { weight } if task.is_operation() && weight > 0.0 => {
                Some(self.temperature_penalty / weight / f64::from(steps_per_hour))
            }
            _ => None,
        };
        let tdis_tot = self.discomfort.or(at_ends);
        let metrics = EpisodeMetrics {
            episode_return: -self.temperature_penalty - self.energy_penalty,
            steps: self.steps,
            tdis_tot,
            ..EpisodeMetrics::default()
        };
        let per_amount = task.energy_weight / task.energy_scale.unwrap_or(1.0);
        let from_penalty = (per_amount > 0.0).then(|| self.energy_penalty / per_amount);
        (metrics, self.resource.or(from_penalty))
    }

    /// Returns the steps per hour. Errors if the episode is not complete.
    fn steps_per_hour(&self, path: &Path) -> Result<u32> {
        // A trajectory does not say whether its year had a 29 February.
        let with_leap_day = match self.period {
            Period::Days(period) => period.in_calendar(Calendar::new(0, true)).days(),
            Period::TwoWeeks(_) => self.period.days() + 1,
        };
        let hours = [self.period.days(), with_leap_day].map(|days| 24 * days as usize);
        let Some(hours) = hours.into_iter().find(|hours| self.steps > 0 && self.steps.is_multiple_of(*hours))
        else {
            bail!(
                "{} has {} steps, which is not a complete episode of {}",
                path.display(),
                self.steps,
                self.period
            );
        };
        Ok((self.steps / hours) as u32)
    }
}

impl Arguments {
    /// Returns the building given as an argument, otherwise the one named in the file.
    fn subject(&self, building: &str, place: &str) -> Result<Subject> {
        let mut placement = self.location.placement();
        let hint = "specify it with --building and --weather";
        let name = match &self.building {
            Some(name) => name.clone(),
            None => match Control::split_name(building).0.parse() {
                Ok(name) => name,
                Err(_) => bail!("unknown building `{building}`; {hint}"),
            },
        };
        let (recorded_name, recorded) = Control::split_name(building);
        if name.to_string() != recorded_name {
            bail!(
                "the trajectory is of {recorded_name}, not of {name}; remove --building, or pass its model file"
            );
        }
        if self.location.control.is_some_and(|given| given != recorded) {
            bail!("the trajectory was recorded under `--control {}`; remove --control", recorded.name());
        }
        placement.control = recorded;
        // The file names the place of a building type; a building of the dataset has its own.
        let is_type = matches!(name, BuildingName::Type(_));
        if is_type && placement.weather.is_none() && placement.place.is_none() {
            let Ok(found) = Place::find(place) else {
                bail!("unknown place `{place}`; {hint}");
            };
            placement.place = Some(found);
        }
        Ok(Subject { name, placement })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_of_another_version_is_rejected() {
        let path = Path::new("trajectory.parquet");
        check_versions(path, &Versions::current()).unwrap();
        check_versions(path, &Versions { package: "0".into(), ..Versions::current() }).unwrap();
        for other in [
            Versions { generator: "v0".into(), ..Versions::current() },
            Versions { engine: "9.6".into(), ..Versions::current() },
        ] {
            let said = check_versions(path, &other).unwrap_err().to_string();
            assert!(said.contains("trajectory.parquet") && said.contains("run the episode again"), "{said}");
        }
    }
}
