//! `b2b experiment run`.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, bail};
use b2b_base::shard::Shard;
use b2b_experiment::{Error, Experiment, Folder, Job, Runner, State, duration_text, estimate};
use serde::Deserialize;
use serde_json::json;

use super::report;
use crate::arguments::jobs::Jobs;
use crate::program;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::counter;
use crate::terminal::{interrupt, stdout};

/// Run the remaining jobs of an experiment and write its report
///
/// A failed job does not stop the others; the same command retries it. Exits with code 1 if a job failed.
#[derive(clap::Args, Deserialize)]
#[command(verbatim_doc_comment)]
#[serde(deny_unknown_fields)]
pub struct Arguments {
    /// Name of an experiment, or a TOML file
    #[arg(value_name = "EXPERIMENT")]
    experiment: String,
    /// Budget: quick (minutes to hours on two cores), full (the paper's where it has the experiment), or another budget
    /// of the experiment
    #[arg(long, value_name = "BUDGET", default_value = "quick")]
    budget: String,
    /// Run only part I of N of the jobs, with I from 0 to N - 1; the parts may share the output folder
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Take over the results of identical jobs from the folder of another experiment; can be repeated
    #[arg(long, value_name = "FOLDER")]
    #[serde(default)]
    reuse: Vec<PathBuf>,
    /// Print the remaining jobs and their estimated duration without running them
    #[arg(long)]
    #[serde(default)]
    dry_run: bool,
    #[command(flatten)]
    #[serde(default)]
    jobs: Jobs,
    /// Folder of the results [default: b2b-out/experiment-NAME-BUDGET]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    #[serde(default)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    Ok(ExitCode::of(failures(arguments)?.is_empty()))
}

/// Runs the remaining jobs, writes the report, and returns the jobs that failed, with the reasons.
pub fn failures(arguments: &Arguments) -> Result<Vec<String>> {
    let experiment = Experiment::named(&arguments.experiment)?;
    let budget = experiment.budget(&arguments.budget)?;
    let default = || PathBuf::from("b2b-out").join(format!("experiment-{}-{}", experiment.name, budget.name));
    let out = arguments.out.clone().unwrap_or_else(default);
    let mut folder = Folder::of(&out, &source(&arguments.experiment)?, budget)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let numbered = experiment.jobs(budget).into_iter().enumerate();
    let jobs: Vec<Job> = numbered.filter(|(number, _)| shard.contains(*number)).map(|(_, job)| job).collect();
    begin(arguments, &experiment, &mut folder, &jobs)?;
    let parallel = arguments.jobs.count()?;
    let left: Vec<&str> = jobs.iter().filter(|job| !folder.is_done(job)).map(|job| &job.key[..]).collect();
    let time = estimate(Some(&folder), &jobs, parallel);
    if !arguments.json {
        stdout::print(&format!(
            "{}: {} of {} jobs left, about {}",
            experiment.title,
            left.len(),
            jobs.len(),
            duration_text(time)
        ))?;
    }
    if arguments.dry_run {
        let text = || left.iter().map(|key| format!("  {key}")).collect::<Vec<_>>().join("\n");
        let summary = json!({"jobs": jobs.len(), "left": left, "hours": time.as_secs_f64() / 3600.0});
        return stdout::print_result(arguments.json, &summary, text).map(|()| Vec::new());
    }
    let failures = run_jobs(arguments, &folder, &jobs, parallel)?;
    report::write(&out, arguments.json)?;
    Ok(failures)
}

/// Takes over the results of other folders, and creates the folder unless this is a dry run. Errors if its results are
/// another version's.
fn begin(arguments: &Arguments, experiment: &Experiment, folder: &mut Folder, jobs: &[Job]) -> Result<()> {
    folder.check_versions(jobs, experiment.report)?;
    for other in &arguments.reuse {
        let count = folder.reuse(jobs, experiment.report, other)?;
        if !arguments.json {
            let done = if arguments.dry_run { "to take" } else { "taken" };
            stdout::print(&format!("jobs {done} over from {}: {count}", other.display()))?;
        }
    }
    if !arguments.dry_run {
        folder.create()?;
        if !arguments.reuse.is_empty() {
            folder.save()?;
        }
    }
    Ok(())
}

/// Runs the remaining jobs, with a progress bar. Returns the failures.
fn run_jobs(arguments: &Arguments, folder: &Folder, jobs: &[Job], parallel: usize) -> Result<Vec<String>> {
    let failures = Mutex::new(Vec::new());
    let bar = counter(jobs.len(), "jobs", arguments.json);
    bar.set_position(jobs.iter().filter(|job| folder.is_done(job)).count() as u64);
    bar.reset_eta();
    let ended = |job: &Job, state: &State| {
        bar.inc(1);
        if let Some(error) = &state.error {
            let failure = format!("{}: {error}\n  log: {}", job.key, folder.job(job).log().display());
            bar.suspend(|| eprintln!("failed: {failure}"));
            failures.lock().unwrap_or_else(PoisonError::into_inner).push(failure);
        }
    };
    let runner =
        Runner { launcher: program::launcher(), folder, parallel, interrupted: interrupt::requested };
    match runner.run(jobs, &ended) {
        Err(Error::Interrupted) => bail!("interrupted; run the same command again to resume"),
        ended => ended?,
    }
    bar.finish_and_clear();
    Ok(failures.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Returns the name of a shipped experiment, or the absolute path of a file, so that a report can be written from any
/// working directory.
fn source(experiment: &str) -> Result<String> {
    if experiment.ends_with(".toml") {
        return Ok(std::path::absolute(experiment)?.to_string_lossy().into_owned());
    }
    Ok(experiment.to_owned())
}
