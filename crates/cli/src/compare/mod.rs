//! `b2b compare`: runs of one episode side by side.

mod difference;
mod lead;
mod page;
mod recorded;
mod worst_hours;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use crate::output_folder::OutputFolder;
use crate::terminal::stdout;
use recorded::Recorded;

/// Compare runs of the same building, period and task
///
/// Prints the metrics of every run and their differences from the first, and writes one HTML page with zone
/// temperatures, power and the worst hours on one time axis. The page opens in any browser, without a network.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
The runs must have the same building, weather, run period, time step and task, so that only their controllers
differ. The worst hours are those with the largest mean deviation from target, at most one per zone and day.

Examples:
  b2b run OfficeSmall
  b2b run OfficeSmall --controller random
  b2b compare b2b-out/OfficeSmall-Denver-winter-*
  b2b compare runs/reactive runs/ppo --name baseline --name PPO --out ppo.html"
)]
pub struct Arguments {
    /// Output folders of `b2b run`, or their trajectory.parquet; the first is the reference
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Name of a run; repeat the option once for each run, in order [default: the controllers]
    #[arg(long, value_name = "NAME")]
    name: Vec<String>,
    /// HTML file to write [default: b2b-out/compare-BUILDING-PLACE-PERIOD.html]
    #[arg(long, value_name = "FILE", value_parser = crate::arguments::page::path)]
    out: Option<PathBuf>,
    /// Print one JSON object instead of the tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn compare(arguments: &Arguments) -> Result<()> {
    let Arguments { runs: paths, name: names, .. } = arguments;
    if paths.len() < 2 {
        bail!("{} is one run; give at least two to compare", paths[0].display());
    }
    if !names.is_empty() && names.len() != paths.len() {
        bail!("--name has {} names for {} runs", names.len(), paths.len());
    }
    let mut runs = paths.iter().map(|path| Recorded::read(path)).collect::<Result<Vec<_>>>()?;
    recorded::check_same(&runs)?;
    recorded::set_names(&mut runs, names);
    let path = arguments.out.clone().unwrap_or_else(|| default_path(&runs[0]));
    OutputFolder::write_file(&path, |file| page::write(file, &runs))?;
    let comparison = difference::json(&runs, &path);
    stdout::print_result(arguments.json, &comparison, || {
        let lead = lead::table(&runs) + &difference::table(&runs);
        let tables = [runs[0].title(runs.len()), lead, worst_hours::table(&runs)];
        format!("{}\n\n  {}", tables.join("\n\n"), path.display())
    })
}

fn default_path(run: &Recorded) -> PathBuf {
    let described = &run.described;
    let name = format!("compare-{}-{}-{}.html", described.building, described.place, described.period);
    Path::new("b2b-out").join(name.replace(' ', "_"))
}
