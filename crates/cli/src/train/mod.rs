//! `b2b train`: resumable training of an agent, scored against the baseline of its task.

mod bar;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_agent::{Acting, ObservationForm};
use b2b_building::{BuildingType, Period};
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_evaluate::statistics::Verdict;
use b2b_learn::train::{Measures, PAGE, PresetChoice, RunOptions, RunSummary, SUMMARY, Tasks, TrainConfig};

use crate::arguments::jobs::Jobs;
use crate::arguments::location::Location;
use crate::output_folder;
use crate::program;
use crate::terminal::progress::Download;
use crate::terminal::{interrupt, stdout};
use bar::Bar;

/// Train an agent and score it against the baseline
///
/// The output folder is the agent: `b2b evaluate --policy FOLDER` and `b2b benchmark run` accept it as a policy. It
/// also has config.toml (every option), progress.csv, TensorBoard events, curve.html, summary.json and the checkpoint.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES, mut_arg("jobs", |jobs| jobs.help(JOBS)))]
pub struct Arguments {
    /// Training buildings, such as OfficeSmall-0509, assigned to the environments in turn
    #[arg(value_name = "BUILDING", conflicts_with = "building_type")]
    buildings: Vec<BuildingName>,
    /// Train on the training split of a building type, with a new building in every episode; several types need the
    /// preset graph or supervisory-graph
    #[arg(long = "type", visible_alias = "types", value_name = "TYPE", num_args = 1..)]
    building_type: Vec<BuildingType>,
    /// Train on the training side of a benchmark problem: a name from `b2b benchmark list`, or a JSON file
    #[arg(long, value_name = "PROBLEM", conflicts_with_all = ["buildings", "building_type", "task", "period"])]
    problem: Option<String>,
    /// Preset: paper (PPO as in the paper), direct (the same from features), residual (corrections to the tuned
    /// reactive controllers), recurrent (the same, with a memory of the episode), graph (one network for buildings of
    /// several types), supervisory (shifts of what guideline36 chooses) or supervisory-graph (one network that does
    /// this in many buildings) [default: residual; in tasks of operation supervisory, with --type supervisory-graph,
    /// unless --direct, --authority or --problem is given]
    #[arg(long, value_name = "PRESET")]
    preset: Option<String>,
    /// TOML file with any options of a run's config.toml; other arguments take precedence
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Algorithm: ppo or sac [default: ppo]
    #[arg(long, value_name = "ALGORITHM")]
    algorithm: Option<String>,
    /// Task, as for `b2b run`, or several, separated by commas; every episode draws one [default: the
    /// preset's, constant or operate]
    #[arg(long, value_name = "TASK")]
    task: Option<Tasks>,
    /// Run period: winter, summer, full_year, MM-DD..MM-DD or two weeks chosen from the weather, such as peak-heating;
    /// or several, separated by commas, one of which is drawn for every episode. Episodes are not longer than the
    /// shortest [default: the preset's, usually winter]
    #[arg(long, value_name = "PERIOD", value_delimiter = ',')]
    period: Vec<Period>,
    /// Environment steps in total, over all environments [default: the preset's]
    #[arg(long, value_name = "N", value_parser = steps)]
    steps: Option<u64>,
    /// Random seed [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of environments [default: the preset's]
    #[arg(long, value_name = "N")]
    environments: Option<usize>,
    /// Form of observations: raw, roles or features [default: the preset's]
    #[arg(long, value_name = "FORM")]
    observation: Option<ObservationForm>,
    /// How the agent acts: direct, residual:0.5, targets:60, which shifts the targets of the reactive controllers, or
    /// supervisory:60, which shifts what guideline36 chooses, setpoints too, without the rule of linear-supervisor;
    /// both hold each decision for 15, 30 or 60 minutes [default: the preset's]
    #[arg(long, value_name = "KIND", conflicts_with_all = ["direct", "authority"])]
    acting: Option<Acting>,
    /// Train an agent that sets the actuators directly, without the reactive controllers
    #[arg(long, conflicts_with = "authority")]
    direct: bool,
    /// Largest correction to the action of the reactive controllers, as a share of an actuator's range
    #[arg(long, value_name = "SHARE")]
    authority: Option<f64>,
    /// Folder of the run [default: b2b-out/train-BUILDING-TASK-PERIOD-PRESET-SEED, or train-PROBLEM-PRESET-SEED]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Folder of a run to resume from its last checkpoint; --steps trains for more steps
    #[arg(long, value_name = "FOLDER", conflicts_with_all = [
        "buildings", "building_type", "problem", "algorithm", "preset", "config", "task", "period", "seed", "environments", "observation",
        "acting", "direct", "authority", "out", "place", "weather", "control", "keep_design_days",
    ])]
    resume: Option<PathBuf>,
    #[command(flatten)]
    location: Location,
    #[command(flatten)]
    jobs: Jobs,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

const JOBS: &str = "Number of episodes to evaluate in parallel [default: number of CPU cores]; the environments of the \
                    training use all cores";

const EXAMPLES: &str = "\
Examples:
  b2b train OfficeSmall-0509 --task occupancy --period summer
  b2b train SingleFamilyHouse-0042 --preset paper --steps 400000
  b2b train OfficeSmall-0509 --task operate --period 07-01..07-31
  b2b train --type SingleFamilyHouse --task random --steps 2000000 --out runs/houses
  b2b train --preset graph --type OfficeSmall RetailStandalone   one policy for both types
  b2b train --type OfficeMedium --task operate         one supervisor of guideline36 for medium offices
  b2b train --problem dynamics-office-small --steps 1000000 --out runs/offices-0
  b2b train --resume runs/houses --steps 4000000       train for more steps
  b2b train OfficeSmall-0509 --config mine.toml        unknown keys are errors, with suggestions
  b2b train my.idf --weather my.epw                    a model of your own
  b2b evaluate OfficeSmall-0509 --policy runs/x --out scores   the run's folder is the agent
  tensorboard --logdir runs                            watch runs side by side

Ctrl-C writes a checkpoint. A run that was killed and resumed ends with the same weights as one that was not.";

/// Runs the command.
pub fn train(arguments: &Arguments) -> Result<()> {
    let config = arguments.configuration()?;
    config.check()?;
    let out = arguments.folder(&config)?;
    output_folder::refuse_others(&out, "b2b train")?;
    let catalog = Arc::new(program::catalog(&mut Download::new(arguments.json))?);
    let trained = train_in(&out, &config, catalog, arguments.jobs.count()?, arguments.json);
    let summary = match trained {
        Err(b2b_learn::Error::Interrupted) => {
            bail!("interrupted; resume with `b2b train --resume {}`", out.display())
        }
        trained => trained?,
    };
    stdout::print_result(arguments.json, &summary, || text(&summary))
}

/// Begins or continues a run in a folder, with a bar unless `quiet`.
pub fn train_in(
    out: &Path,
    config: &TrainConfig,
    catalog: Arc<Catalog>,
    jobs: usize,
    quiet: bool,
) -> b2b_learn::Result<RunSummary> {
    // On an interrupt, a running evaluation finishes first.
    interrupt::be_patient();
    let mut bar = Bar::new(config.budget.steps, quiet);
    let options = RunOptions {
        out: out.to_owned(),
        catalog,
        launcher: program::launcher(),
        jobs,
        interrupted: interrupt::requested,
        monitor: &mut bar,
    };
    let trained = b2b_learn::train::train(config, options);
    bar.finish();
    trained
}

impl Arguments {
    /// Returns the configuration of the run to resume, or a preset changed by a file and the arguments.
    fn configuration(&self) -> Result<TrainConfig> {
        if self.location.placement().transition.is_some() {
            bail!(
                "--transition is not for training: convert the model with EnergyPlus's Transition programs first, \
                 and train on the result"
            );
        }
        if let Some(folder) = &self.resume {
            let mut config = TrainConfig::of_run(folder)
                .with_context(|| format!("{} has no run to resume", folder.display()))?;
            set(&mut config.budget.steps, &self.steps);
            config.training_set.allow_external = self.location.placement().allow_external;
            return Ok(config);
        }
        let mut config = TrainConfig::preset(&self.preset()?)?;
        // Arguments take precedence over the file.
        let mut ignored = vec!["preset"];
        if let Some(algorithm) = &self.algorithm {
            config = config.with_algorithm(algorithm)?;
            ignored.push("algorithm");
        }
        if let Some(problem) = &self.problem {
            config = config.with_problem(problem)?;
            ignored.push("problem");
        }
        if let Some(path) = &self.config {
            config = config.with_file(path, &ignored)?;
        }
        self.change(&mut config);
        Ok(config)
    }

    /// Returns the name of the preset.
    fn preset(&self) -> Result<String> {
        let acting = self.acting.or(self.direct.then_some(Acting::Direct));
        let choice = PresetChoice {
            preset: self.preset.clone(),
            task: self.task.clone(),
            acting: acting.or(self.authority.map(|authority| Acting::Residual { authority })),
            buildings: self.buildings.iter().map(ToString::to_string).collect(),
            building_type: self.building_type.iter().map(ToString::to_string).collect(),
            problem: self.problem.clone().unwrap_or_default(),
        };
        Ok(choice.name(self.config.as_deref())?)
    }

    fn change(&self, config: &mut TrainConfig) {
        let TrainConfig { training_set, agent, budget, .. } = config;
        if !self.buildings.is_empty() {
            training_set.buildings = self.buildings.iter().map(in_config).collect();
            training_set.building_type.clear();
        }
        if !self.building_type.is_empty() {
            training_set.building_type = self.building_type.iter().map(ToString::to_string).collect();
            training_set.buildings.clear();
        }
        set(&mut training_set.task, &self.task);
        if !self.period.is_empty() {
            training_set.period = self.period.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
            if self.config.is_none() {
                training_set.shorten_window();
            }
        }
        set(&mut budget.steps, &self.steps);
        set(&mut budget.seed, &self.seed);
        set(&mut budget.environments, &self.environments);
        set(&mut agent.observation.form, &self.observation);
        let Placement { place, weather, allow_external, keep_design_days, .. } = self.location.placement();
        set(&mut training_set.place, &place.map(|place| place.name.to_owned()));
        set(&mut training_set.weather, &weather.as_deref().map(absolute));
        training_set.allow_external |= allow_external;
        training_set.keep_design_days |= keep_design_days;
        set(&mut training_set.control, &self.location.control);
        set(&mut agent.acting, &self.acting);
        if self.direct {
            agent.acting = Acting::Direct;
        }
        if let Some(authority) = self.authority {
            agent.acting = Acting::Residual { authority };
        }
    }

    /// Returns the folder of the run.
    fn folder(&self, config: &TrainConfig) -> Result<PathBuf> {
        if let Some(given) = self.resume.as_ref().or(self.out.as_ref()) {
            return Ok(given.clone());
        }
        let set = &config.training_set;
        let what = match (&set.buildings[..], &set.building_type) {
            ([], types) => types.join("-"),
            ([one], _) => Path::new(one).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            ([first, rest @ ..], _) => format!("{first}-and-{}-more", rest.len()),
        };
        let what = if set.problem.is_empty() {
            format!("{what}-{}-{}", set.task, set.period)
        } else {
            Path::new(&set.problem).file_stem().unwrap_or_default().to_string_lossy().into_owned()
        };
        let name = format!("train-{what}-{}-{}", self.preset()?, config.budget.seed);
        Ok(PathBuf::from("b2b-out").join(name.replace([':', '#', '/', ','], "_")))
    }
}

/// Parses a number of steps: 400000, 400_000 or 4e5.
fn steps(text: &str) -> Result<u64, String> {
    let number = text.replace('_', "").parse().unwrap_or(f64::NAN);
    // Larger f64 numbers are not exact.
    if (0.0..=2f64.powi(53)).contains(&number) && number.fract() == 0.0 {
        Ok(number as u64)
    } else {
        Err("expected a whole number of steps, such as 400000 or 4e5".into())
    }
}

/// Returns the name of a building for a configuration: a model's path is made absolute.
fn in_config(building: &BuildingName) -> String {
    match building {
        BuildingName::Model(path) => absolute(path).to_string_lossy().into_owned(),
        named => named.to_string(),
    }
}

/// Returns an absolute path, so that a run resumed from another folder finds the file too.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Sets an option if it is given.
fn set<T: Clone>(option: &mut T, given: &Option<T>) {
    if let Some(value) = given {
        option.clone_from(value);
    }
}

/// Formats the result of a run.
fn text(summary: &RunSummary) -> String {
    let RunSummary { steps, steps_per_s, out, .. } = summary;
    format!(
        "{} on {}, {}: {steps} steps at {steps_per_s:.0}/s, seed {}\n\n\
         {}agent    {}\n\
         curve    {}\n\
         result   {}",
        summary.task,
        summary.buildings,
        summary.period,
        summary.seed,
        summary.scores.as_ref().map_or_else(String::new, |scores| measures_text(&scores.mean)),
        out.display(),
        out.join(PAGE).display(),
        out.join(SUMMARY).display(),
    )
}

/// Says how a score compares with a baseline's.
fn verdict(score: f64, baseline: &str) -> String {
    match Verdict::of_one(score) {
        Verdict::Beats => format!("beats {baseline}"),
        Verdict::NoDifference => format!("no difference from {baseline}"),
        Verdict::Worse => format!("worse than {baseline}"),
    }
}

/// Formats the scores of an agent.
fn measures_text(measures: &Measures) -> String {
    if measures.cost_ratio.is_finite() {
        return operation_text(measures);
    }
    let verdict = verdict(measures.score, "the baseline");
    format!(
        "score             {:.3}   {verdict}\n\
         resolved score    {:.3}\n\
         RMS deviation     {:.3} K\n\
         energy            {:.3} of the baseline's\n\
         actuator travel   {:.1} strokes/day, {:.2} of the limit\n\
         oscillation       {:.1} % of zone-steps\n\n",
        measures.score,
        measures.resolved_score,
        measures.rms_deviation_k,
        measures.energy_ratio,
        measures.travel_per_day,
        measures.relative_travel,
        100.0 * measures.oscillating_share,
    )
}

/// Formats the scores of an agent in tasks of operation.
fn operation_text(measures: &Measures) -> String {
    let verdict = verdict(measures.score, "guideline36");
    format!(
        "score at comfort  {:.3}   {verdict}\n\
         cost              {:.3} of guideline36's\n\
         discomfort        {:.3} K·h per zone and day; guideline36 {:.3}\n\
         actuator travel   {:.1} strokes/day, {:.2} of the limit\n\
         oscillation       {:.1} % of zone-steps\n\n",
        measures.score,
        measures.cost_ratio,
        measures.discomfort,
        measures.baseline_discomfort,
        measures.travel_per_day,
        measures.relative_travel,
        100.0 * measures.oscillating_share,
    )
}

#[cfg(test)]
mod tests {
    use super::steps;

    #[test]
    fn a_number_of_steps_may_be_in_scientific_notation() {
        for text in ["100000", "100_000", "1e5", "1E5", "100000.0"] {
            assert_eq!(steps(text), Ok(100_000), "{text}");
        }
        for text in ["many", "", "-1", "1.5", "1e-3", "1e300", "nan", "inf"] {
            assert!(steps(text).unwrap_err().contains("such as 400000 or 4e5"), "{text}");
        }
    }
}
