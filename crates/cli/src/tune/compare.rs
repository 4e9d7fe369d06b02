//! `b2b tune compare`: the reactive controllers under default and tuned parameters.

use anyhow::{Context, Result};
use b2b_benchmark::statistics;
use b2b_building::{BuildingType, Class, RunPeriod};
use b2b_control::{ReactiveParameters, Tuned};
use b2b_dataset::BuildingId;
use b2b_dataset::Catalog;
use b2b_env::{Metrics, Task};
use serde::Serialize;

use super::rollouts::{WEEKS, rollouts};
use crate::arguments::buildings::DatasetBuildings;
use crate::arguments::task;
use crate::progress::{Download, counter};
use crate::table::Table;
use crate::{interrupt, stdout};

/// Compare default and tuned parameters on test buildings
///
/// Reports for every building the RMS deviation from the target temperature over the zones with heating and cooling,
/// actuator travel in full strokes per day, and HVAC energy, under the default and the tuned parameters.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    buildings: DatasetBuildings,
    /// Tasks (see `b2b run --help`)
    #[arg(long = "task", value_name = "TASK", num_args = 1.., default_values = ["constant", "occupancy"], value_parser = task::parse)]
    tasks: Vec<Task>,
    /// Run period; repeat the option for several
    #[arg(long = "period", value_name = "PERIOD", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// An episode of a building under both parameter sets.
#[derive(Serialize)]
struct Pair {
    building: String,
    class: Class,
    /// Whether its class has tuned parameters. If not, both are the defaults.
    is_tuned: bool,
    task: String,
    period: String,
    default: Performance,
    tuned: Performance,
}

/// The metrics that are compared.
#[derive(Clone, Copy, Serialize)]
struct Performance {
    rms_deviation_k: f64,
    daily_travel: f64,
    energy_wh_m2: f64,
}

impl Performance {
    fn of(metrics: &Metrics) -> Self {
        Self {
            rms_deviation_k: metrics.rms_deviation(),
            daily_travel: metrics.daily_travel(),
            energy_wh_m2: metrics.electricity + metrics.gas,
        }
    }
}

/// Runs the command.
pub fn compare(arguments: &Arguments) -> Result<()> {
    let buildings = arguments.buildings.ids()?;
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    let bar = counter(buildings.len(), "buildings", arguments.json);
    let mut pairs = Vec::new();
    for id in buildings {
        let of_building = arguments.pairs(&catalog, id);
        interrupt::check()?;
        pairs.extend(of_building.with_context(|| format!("cannot compare {id}"))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    stdout::print_result(arguments.json, &pairs, || arguments.text(&pairs))
}

impl Arguments {
    fn pairs(&self, catalog: &Catalog, id: BuildingId) -> Result<Vec<Pair>> {
        let class = b2b_dataset::row(id).building.class();
        let mut rollouts = rollouts(catalog, &[id], &self.periods, &self.tasks)?;
        let tuned = Tuned::of(class);
        let before = rollouts.run(&ReactiveParameters::default())?.concat();
        let after = match tuned {
            Some(tuned) => rollouts.run(&tuned.parameters)?.concat(),
            None => before.clone(),
        };
        let episodes =
            self.tasks.iter().flat_map(|task| self.periods.iter().map(move |period| (task, period)));
        let pair = |((task, period), (before, after)): ((&Task, &RunPeriod), (&Metrics, &Metrics))| Pair {
            building: id.to_string(),
            class,
            is_tuned: tuned.is_some(),
            task: task.to_string(),
            period: period.to_string(),
            default: Performance::of(before),
            tuned: Performance::of(after),
        };
        Ok(episodes.zip(before.iter().zip(&after)).map(pair).collect())
    }

    /// Returns a row for every building, then the medians of every type.
    fn text(&self, pairs: &[Pair]) -> String {
        let mut table = table();
        for pair in pairs {
            let zone = pair.class.climate_zone.map_or_else(String::new, |zone| zone.to_string());
            table.row(row(&pair.building, zone, pair));
        }
        format!("{}\n\n  medians by type\n{}", table.text(), self.medians(pairs).text())
    }

    /// Returns a row for every type, task and run period.
    fn medians(&self, pairs: &[Pair]) -> Table {
        let mut medians = table();
        for building_type in BuildingType::ALL {
            for (task, period) in self.tasks.iter().flat_map(|t| self.periods.iter().map(move |p| (t, p))) {
                let (task, period) = (task.to_string(), period.to_string());
                let of_type = |pair: &&Pair| {
                    pair.class.building_type == building_type && pair.task == task && pair.period == period
                };
                let group: Vec<_> = pairs.iter().filter(of_type).collect();
                if let Some(pair) = Pair::median(&group) {
                    medians.row(row(building_type.name(), format!("{} buildings", group.len()), &pair));
                }
            }
        }
        medians
    }
}

impl Pair {
    /// Returns the medians of a group, if it has members.
    fn median(group: &[&Self]) -> Option<Self> {
        let first = group.first()?;
        let median_of = |performance: fn(&Self) -> Performance| {
            let median_of = |value: fn(&Performance) -> f64| {
                median(group.iter().map(|pair| value(&performance(pair))).collect())
            };
            Performance {
                rms_deviation_k: median_of(|each| each.rms_deviation_k),
                daily_travel: median_of(|each| each.daily_travel),
                energy_wh_m2: median_of(|each| each.energy_wh_m2),
            }
        };
        Some(Self {
            building: first.class.building_type.to_string(),
            class: first.class,
            is_tuned: group.iter().all(|pair| pair.is_tuned),
            task: first.task.clone(),
            period: first.period.clone(),
            default: median_of(|pair| pair.default),
            tuned: median_of(|pair| pair.tuned),
        })
    }
}

fn table() -> Table {
    Table::new([
        "building",
        "zone",
        "task",
        "period",
        "default RMS (K)",
        "tuned RMS (K)",
        "default travel (strokes/day)",
        "tuned travel (strokes/day)",
        "default energy (Wh/m²)",
        "tuned energy (Wh/m²)",
        "",
    ])
}

fn row(building: &str, zone: String, pair: &Pair) -> [String; 11] {
    [
        building.to_owned(),
        zone,
        pair.task.clone(),
        pair.period.clone(),
        format!("{:.2}", pair.default.rms_deviation_k),
        format!("{:.2}", pair.tuned.rms_deviation_k),
        format!("{:.2}", pair.default.daily_travel),
        format!("{:.2}", pair.tuned.daily_travel),
        format!("{:.0}", pair.default.energy_wh_m2),
        format!("{:.0}", pair.tuned.energy_wh_m2),
        if pair.is_tuned { "" } else { "not tuned" }.to_owned(),
    ]
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    statistics::median(&values)
}
