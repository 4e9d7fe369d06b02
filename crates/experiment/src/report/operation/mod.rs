//! Cost, energy, discomfort and peak demand of controllers and agents by type and period, what they save against the
//! guideline controller, and how that one compares with the buildings' own controls.

mod comparison;
mod extremes;
mod figures;
mod savings;
mod way;

use std::collections::HashMap;

use b2b_evaluate::statistics::median;
use b2b_evaluate::{EpisodeResult, FREE_DISCOMFORT};
use serde_json::{Value, json};

use self::comparison::{Comparison, GUIDELINE};
pub(super) use self::extremes::extremes;
use self::figures::{Figures, HEADER};
use super::content::Content;
use crate::definition::Experiment;
use crate::folder::JobResult;
use crate::results::Results;

/// Name used instead of a period for all periods together.
const TOGETHER: &str = "together";

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let comparison = Comparison::of(experiment, results);
    let mut tables = savings::tables(experiment, results);
    tables.push(by_type(experiment, results));
    tables.extend(way::table(experiment, results));
    tables.extend(extremes::table(experiment, results));
    tables.extend(comparison.tables());
    tables.push(by_period(experiment, results));
    let charts = savings::charts(experiment, results);
    Content { tiles: comparison.tiles(), tables, charts, notes: notes() }
}

/// The guideline's episodes by building, task and period.
struct Guideline<'a>(HashMap<[&'a str; 3], &'a EpisodeResult>);

impl<'a> Guideline<'a> {
    fn of(results: &'a Results) -> Self {
        Self(results.of(GUIDELINE).map(|(_, row)| (visit(row), row)).collect())
    }

    /// Returns the same episode under the guideline.
    fn same(&self, row: &EpisodeResult) -> Option<&'a EpisodeResult> {
        self.0.get(&visit(row)).copied()
    }
}

/// Returns building, task and period of an episode.
fn visit(row: &EpisodeResult) -> [&str; 3] {
    [&row.info.building, &row.info.task, &row.info.period]
}

/// Returns the names of the controllers and of the budget's agents.
fn policies(experiment: &Experiment, results: &Results) -> Vec<String> {
    let agents = experiment.policies(&results.budget).into_iter().map(|policy| policy.name);
    experiment.kept_controllers().map(str::to_owned).chain(agents).collect()
}

/// Returns the medians over the buildings of each type of the sums over the periods.
fn by_type(experiment: &Experiment, results: &Results) -> Value {
    let mut rows = Vec::new();
    for building_type in &experiment.types {
        for policy in policies(experiment, results) {
            let of_building = |(_, figures): &(String, Vec<Figures>)| Figures::together(figures);
            let buildings = buildings(experiment, results, &policy, building_type.name());
            let all: Vec<Figures> = buildings.iter().filter_map(of_building).collect();
            rows.extend(cells(building_type.name(), TOGETHER, &policy, &all));
        }
    }
    table(
        experiment,
        "By type",
        "all periods together: sums (peak: the largest); medians over the buildings",
        &rows,
    )
}

/// Returns the medians over the buildings of each type, period by period.
fn by_period(experiment: &Experiment, results: &Results) -> Value {
    let mut rows = Vec::new();
    for building_type in &experiment.types {
        for period in &experiment.periods {
            for policy in policies(experiment, results) {
                let is_own = |_: &JobResult, row: &EpisodeResult| {
                    row.info.building_type == building_type.name() && row.info.period == *period
                };
                let all = Figures::of_episodes(experiment, results, &policy, is_own);
                rows.extend(cells(building_type.name(), period, &policy, &all));
            }
        }
    }
    table(experiment, "By type and period", "two weeks each; medians over the buildings", &rows)
}

/// Returns the figures of a policy in the buildings of a type: for each building, one per period. An agent has them for
/// each of its seeds.
fn buildings(
    experiment: &Experiment,
    results: &Results,
    policy: &str,
    building_type: &str,
) -> Vec<(String, Vec<Figures>)> {
    let mut visits: Vec<(&str, &str)> = Vec::new();
    for (job, row) in results.of(policy) {
        let visit = (&job.key[..], &row.info.building[..]);
        if row.info.building_type == building_type && !visits.contains(&visit) {
            visits.push(visit);
        }
    }
    let of = |(key, name): (&str, &str)| {
        let is_own = |job: &JobResult, row: &EpisodeResult| job.key == key && row.info.building == name;
        (name.to_owned(), Figures::of_episodes(experiment, results, policy, is_own))
    };
    visits.into_iter().map(of).collect()
}

/// Returns a row of medians; `None` without an episode.
fn cells(building_type: &str, period: &str, policy: &str, all: &[Figures]) -> Option<Vec<String>> {
    let first = all.first()?;
    let mut cells =
        vec![building_type.to_owned(), period.to_owned(), policy.to_owned(), all.len().to_string()];
    let of = |value: &dyn Fn(&Figures) -> f64| {
        let mut values: Vec<f64> = all.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        median(&values)
    };
    cells.extend((0..first.costs.len()).map(|task| format!("{:.3}", of(&|figures| figures.costs[task]))));
    cells.extend((0..HEADER.len()).map(|index| format!("{:.2}", of(&|figures| figures.values()[index]))));
    let uncomfortable = all.iter().filter(|figures| figures.uncomfortable).count();
    cells.push(if uncomfortable == 0 { String::new() } else { format!("{uncomfortable} of {}", all.len()) });
    Some(cells)
}

fn table(experiment: &Experiment, name: &str, title: &str, rows: &[Vec<String>]) -> Value {
    let mut header = ["type", "period", "policy", "episodes"].map(str::to_owned).to_vec();
    header.extend(experiment.tasks.iter().map(|task| format!("cost, {task} (per m²)")));
    header.extend(HEADER.map(str::to_owned));
    header.push("beyond the free discomfort".to_owned());
    json!({"name": name, "title": title, "header": header, "rows": rows})
}

fn notes() -> String {
    format!(
        "Energy: HVAC energy of all end uses. Discomfort: deviation outside the band of the model's own thermostats, integrated \
         over time, per zone. Peak: the largest mean electric demand of a quarter of an hour. Beyond the free discomfort: episodes \
         with more discomfort than under {GUIDELINE} by more than {FREE_DISCOMFORT} K·h per zone and day."
    )
}
