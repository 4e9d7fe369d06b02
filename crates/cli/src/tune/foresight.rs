//! `b2b tune foresight`: schedules of the controller `foresight`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use b2b_base::parallel;
use b2b_building::Period;
use b2b_climate::TwoWeeks;
use b2b_control::foresight::{Planned, SchedulePlan, ScheduleSearchOptions, plan};
use b2b_dataset::{BuildingName, Catalog};
use b2b_env::Task;
use b2b_evaluate::statistics::median;
use indicatif::ProgressBar;

use super::training::episode;
use crate::arguments::buildings::Buildings;
use crate::arguments::jobs::Jobs;
use crate::arguments::location::Location;
use crate::arguments::task;
use crate::output_folder::{self, OutputFolder};
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Search the schedules of the controller foresight
///
/// Runs every episode some 115 times under Guideline 36 with shifted setpoints, start times, supply air temperatures,
/// minimum flows and economizer limits, by block of each day, and keeps the schedule with the lowest cost at no more
/// discomfort. Every episode of the search is kept: the same command resumes it.
/// `b2b run --controller foresight --parameters FILE.json` carries out a schedule.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    buildings: Buildings,
    #[command(flatten)]
    location: Location,
    /// Run periods [default: the five two-week periods]
    #[arg(long = "period", value_name = "PERIOD", num_args = 1..)]
    periods: Vec<Period>,
    /// Task of operation [default: operate]
    #[arg(long, value_name = "TASK", value_parser = Task::from_text)]
    task: Option<Task>,
    /// Zone time steps per hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// Hours of a block of the day
    #[arg(long, default_value_t = ScheduleSearchOptions::default().block_hours, value_name = "N")]
    block_hours: u32,
    /// Rounds of a search
    #[arg(long, default_value_t = ScheduleSearchOptions::default().rounds, value_name = "N")]
    rounds: usize,
    /// Mirrored pairs of episodes in a round
    #[arg(long, default_value_t = ScheduleSearchOptions::default().pairs, value_name = "N")]
    pairs: usize,
    /// Random seed of the search and of the errors of forecasts
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Standard deviation of the error of outdoor temperatures forecast 24 h ahead, 0 to 5; 0 is perfect foresight. The
    /// search runs in the weather predicted at each midnight, its schedule in the actual weather
    #[arg(long, value_name = "K", default_value_t = 0.0)]
    forecast_error: f64,
    /// Search values for every zone and air handler, instead of one for all
    #[arg(long)]
    by_zone: bool,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the episodes, a file for each schedule, and foresight.jsonl with all of them
    #[arg(long, default_value = "b2b-foresight", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Name of the file with all schedules.
const ALL: &str = "foresight.jsonl";
/// Folder of the episodes of searches.
const SEARCHES: &str = "searches";

/// A schedule to search.
struct Item {
    building: BuildingName,
    period: Period,
}

/// Runs the command.
pub fn foresight(arguments: &Arguments) -> Result<()> {
    let items = arguments.items()?;
    let _lock = output_folder::lock(&arguments.out)?;
    let searches = arguments.out.join(SEARCHES);
    std::fs::create_dir_all(&searches)
        .with_context(|| format!("cannot write the folder {}", searches.display()))?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let bar = counter(0, "episodes", arguments.json);
    let search = |item: &Item| arguments.search(&catalog, item, &bar);
    let plans: Vec<SchedulePlan> = parallel::map(arguments.jobs.count()?, &items, search)?;
    bar.finish_and_clear();
    write(&arguments.out.join(ALL), &plans)?;
    stdout::print_result(arguments.json, &plans, || arguments.text(&items, &plans))
}

impl Arguments {
    fn items(&self) -> Result<Vec<Item>> {
        let periods = match self.periods.is_empty() {
            true => TwoWeeks::ALL.map(Period::TwoWeeks).to_vec(),
            false => self.periods.clone(),
        };
        let of = |building: BuildingName| {
            periods.iter().map(move |period| Item { building: building.clone(), period: *period })
        };
        Ok(self.buildings.names()?.into_iter().flat_map(of).collect())
    }

    fn task(&self) -> Task {
        self.task.clone().unwrap_or_else(task::usual)
    }

    fn options(&self) -> ScheduleSearchOptions {
        let Self { block_hours, rounds, pairs, seed, forecast_error, by_zone, .. } = *self;
        ScheduleSearchOptions { block_hours, rounds, pairs, seed, forecast_error, by_zone }
    }

    /// Returns the plan of an item, from its file if it is there.
    fn search(&self, catalog: &Catalog, item: &Item, bar: &ProgressBar) -> Result<SchedulePlan> {
        interrupt::check()?;
        let Item { building, period } = item;
        let (task, options) = (self.task(), self.options());
        let name = format!("{building}_{period}");
        let path = self.out.join(format!("{name}.json"));
        let at = (building, &self.location.placement());
        let mut episode = episode(catalog, at, *period, self.steps_per_hour, task)?;
        let spaces = b2b_env::Environment::spaces(&episode);
        if path.exists() {
            let plan = SchedulePlan::read(&path)?;
            ensure!(
                plan.options == options && plan.planned == Planned::of(spaces)?,
                "{} is a schedule of another search or episode; choose another folder",
                path.display()
            );
            return Ok(plan);
        }
        bar.inc_length(options.episodes(spaces)? as u64);
        let record = self.out.join(SEARCHES).join(format!("{name}.jsonl"));
        let plan = plan(&mut episode, &options, Some(&record), &mut || bar.inc(1));
        interrupt::check()?;
        let plan = plan.with_context(|| format!("cannot plan {name}"))?;
        write(&path, std::slice::from_ref(&plan))?;
        Ok(plan)
    }

    fn text(&self, items: &[Item], plans: &[SchedulePlan]) -> String {
        let searched_in = if self.forecast_error > 0.0 { ", in predicted weather" } else { "" };
        let mut table = Table::new([
            "building",
            "period",
            "cost, guideline36 (per m²)",
            "cost, foresight",
            "saving (%)",
            "discomfort, guideline36 (K·h per zone)",
            "discomfort, foresight",
            &format!("saved by (% of cost{searched_in})"),
        ]);
        for (Item { period, .. }, plan) in items.iter().zip(plans) {
            table.row([
                plan.planned.building.clone(),
                period.to_string(),
                format!("{:.3}", plan.guideline.used),
                format!("{:.3}", plan.result.used),
                format!("{:.1}", 100.0 * plan.saving()),
                format!("{:.2}", plan.guideline.discomfort),
                format!("{:.2}", plan.result.discomfort),
                saved_by(plan),
            ]);
        }
        let mut savings: Vec<f64> = plans.iter().map(|plan| 100.0 * plan.saving()).collect();
        savings.sort_by(f64::total_cmp);
        format!(
            "{}\n\nmedian saving {:.1} %\n\n  {}",
            table.text(),
            median(&savings),
            self.out.join(ALL).display()
        )
    }
}

/// Returns the shifts that save, the largest first.
fn saved_by(plan: &SchedulePlan) -> String {
    let mut all: Vec<(&String, f64)> =
        plan.savings.iter().map(|(shift, share)| (shift, 100.0 * share)).collect();
    all.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let saving = all.iter().filter(|(_, percent)| *percent >= 0.1);
    saving.map(|(shift, percent)| format!("{shift} {percent:.1}")).collect::<Vec<_>>().join(", ")
}

fn write(path: &Path, plans: &[SchedulePlan]) -> Result<()> {
    OutputFolder::write_file(path, |file| {
        for plan in plans {
            serde_json::to_writer(&mut *file, plan)?;
            writeln!(file)?;
        }
        Ok(())
    })
}
