//! `b2b experiment report`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_experiment::{Experiment, Folder, Results, duration_text};
use clap::Parser;
use serde_json::json;

use crate::output_folder::OutputFolder;
use crate::run;
use crate::terminal::progress::counter;
use crate::terminal::stdout;

/// Write the report of an experiment from the results in its folder
///
/// Writes results.json (every episode; identical whether the jobs ran on one machine or in shards) and report.html
/// (opens in any browser, no network needed). Can be run at any time; unfinished jobs are left out.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folder of `b2b experiment run`
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Draw the best and the worst episodes of every policy, day by day, in the folder `drawn` (operation)
    #[arg(long)]
    draw: bool,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

/// The arguments of `b2b run`.
#[derive(clap::Parser)]
struct Episode {
    #[command(flatten)]
    arguments: run::Arguments,
}

const RESULTS: &str = "results.json";
const PAGE: &str = "report.html";
const DRAWN: &str = "drawn";

/// The results in a folder.
struct Read<'a> {
    path: &'a Path,
    folder: Folder,
    experiment: Experiment,
    results: Results,
}

/// Runs the command.
pub fn report(arguments: &Arguments) -> Result<()> {
    let read = Read::of(&arguments.folder)?;
    if arguments.draw {
        read.draw(arguments.json)?;
    }
    read.write(arguments.json)
}

/// Writes the report of the results in a folder.
pub fn write(path: &Path, json: bool) -> Result<()> {
    Read::of(path)?.write(json)
}

impl<'a> Read<'a> {
    fn of(path: &'a Path) -> Result<Self> {
        let (folder, experiment, results) = super::read(path)?;
        Ok(Self { path, folder, experiment, results })
    }

    /// Runs the best and the worst episodes of every policy again and draws them.
    fn draw(&self, json: bool) -> Result<()> {
        let drawings = b2b_experiment::report::drawings(&self.folder, &self.experiment, &self.results);
        if drawings.is_empty() {
            bail!("`--draw` draws episodes of operation; the experiment `{}` has none", self.experiment.name);
        }
        let bar = counter(drawings.len(), "episodes", json);
        for (name, arguments) in drawings {
            match arguments {
                Some(arguments) => {
                    let out = self.path.join(DRAWN).join(&name).to_string_lossy().into_owned();
                    let line = ["run".to_owned()].into_iter().chain(arguments);
                    let line = line.chain(["--out", &out, "--json"].map(str::to_owned));
                    run::carry_out(&Episode::try_parse_from(line)?.arguments)
                        .with_context(|| format!("cannot draw {name}"))?;
                }
                None => bar.suspend(|| eprintln!("not drawn: {name}, whose agent is not in the folder")),
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }

    fn write(&self, json: bool) -> Result<()> {
        let Self { path, folder, experiment, results } = self;
        folder.keep(&results.done)?;
        let staged = OutputFolder::stage(path)?;
        staged.write(RESULTS, |file| {
            serde_json::to_writer_pretty(&mut *file, &results.json())?;
            Ok(file.write_all(b"\n")?)
        })?;
        staged.write(PAGE, |file| Ok(b2b_experiment::report::write(file, experiment, results)?))?;
        let files = staged.destinations(&[RESULTS, PAGE]);
        staged.keep()?;
        let (done, failed, missing) = (results.done.len(), results.failed.len(), results.missing.len());
        let summary = json!({
            "experiment": experiment.name, "budget": results.budget.name, "done": done, "failed": failed, "missing": missing,
            "training_steps": results.steps(), "hours": results.time().as_secs_f64() / 3600.0, "files": files,
        });
        stdout::print_result(json, &summary, || {
            let mut text = format!(
                "{done} jobs done, {failed} failed, {missing} not run; {} of jobs\n\n",
                duration_text(results.time())
            );
            for (job, error) in &results.failed {
                text += &format!("failed: {job}: {error}\n");
            }
            text + &files.iter().map(|file| format!("  {}", file.display())).collect::<Vec<_>>().join("\n")
        })
    }
}
