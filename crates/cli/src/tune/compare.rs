//! `b2b tune compare`: how the reactive controllers hold the targets before and after tuning.

use anyhow::{Context, Result};
use b2b_benchmark::statistics;
use b2b_building::{BuildingType, Class, RunPeriod};
use b2b_control::{ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::{Metrics, Task};
use serde::Serialize;

use super::{Groups, WEEKS, rollouts};
use crate::progress::{Download, counter};
use crate::table::Table;
use crate::{interrupt, stdout};

/// Compare default and tuned parameters on the small test
///
/// For every building: root mean square deviation from target over the zones with heating and cooling, way of the
/// actuators in times their ranges a day, and HVAC energy, under the default and the tuned parameters.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    groups: Groups,
    /// Tasks
    #[arg(long = "task", value_name = "TASK", num_args = 1.., default_values = ["constant", "occupancy"])]
    tasks: Vec<Task>,
    /// Days that each building runs: can be given more than once
    #[arg(long = "period", value_name = "DAYS", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// An episode of a building under both.
#[derive(Serialize)]
struct Pair {
    building: String,
    class: Class,
    /// Whether its class was tuned: otherwise both are the defaults.
    tuned: bool,
    task: String,
    period: String,
    default: Held,
    after: Held,
}

/// How an episode was held.
#[derive(Clone, Copy, Serialize)]
struct Held {
    rms_deviation_k: f64,
    daily_travel: f64,
    energy_wh_m2: f64,
}

impl Held {
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
    let mut buildings: Vec<(Class, Vec<BuildingId>)> = Vec::new();
    for class in arguments.groups.classes()? {
        let rows = b2b_dataset::rows(class.building_type).iter();
        let ids = rows.filter(|row| row.test_small && row.building.class() == class).map(|row| row.id);
        buildings.extend(ids.map(|id| (class, vec![id])));
    }
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    let bar = counter(buildings.len(), "buildings", arguments.json);
    let mut pairs = Vec::new();
    for (class, ids) in &buildings {
        let pairs_now = arguments.pairs(&catalog, *class, ids);
        interrupt::check()?;
        pairs.extend(pairs_now.with_context(|| format!("{} cannot be compared", ids[0]))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if arguments.json { stdout::print_json(&pairs) } else { stdout::print(&arguments.text(&pairs)) }
}

impl Arguments {
    fn pairs(&self, catalog: &Catalog, class: Class, ids: &[BuildingId]) -> Result<Vec<Pair>> {
        let mut rollouts = rollouts(catalog, ids, &self.periods, &self.tasks)?;
        let tuned = Tuned::of(class);
        let before = rollouts.run(&ReactiveParameters::default())?.concat();
        let after = match tuned {
            Some(tuned) => rollouts.run(&tuned.parameters)?.concat(),
            None => before.clone(),
        };
        let episodes =
            self.tasks.iter().flat_map(|task| self.periods.iter().map(move |period| (task, period)));
        let pair = |((task, period), (before, after)): ((&Task, &RunPeriod), (&Metrics, &Metrics))| Pair {
            building: ids[0].to_string(),
            class,
            tuned: tuned.is_some(),
            task: task.to_string(),
            period: period.to_string(),
            default: Held::of(before),
            after: Held::of(after),
        };
        Ok(episodes.zip(before.iter().zip(&after)).map(pair).collect())
    }

    /// A row for every building, then the medians of every type.
    fn text(&self, pairs: &[Pair]) -> String {
        let mut table = table();
        for pair in pairs {
            let zone = pair.class.climate_zone.map_or_else(String::new, |zone| zone.to_string());
            table.row(row(&pair.building, zone, pair));
        }
        let mut medians = self::table();
        for building_type in BuildingType::ALL {
            for (task, period) in self.tasks.iter().flat_map(|t| self.periods.iter().map(move |p| (t, p))) {
                let (task, period) = (task.to_string(), period.to_string());
                let of_type = |pair: &&Pair| {
                    pair.class.building_type == building_type && pair.task == task && pair.period == period
                };
                let group: Vec<_> = pairs.iter().filter(of_type).collect();
                let Some(first) = group.first() else { continue };
                let median_of = |held: fn(&Pair) -> Held| {
                    let median_of = |value: fn(&Held) -> f64| {
                        median(group.iter().map(|pair| value(&held(pair))).collect())
                    };
                    Held {
                        rms_deviation_k: median_of(|held| held.rms_deviation_k),
                        daily_travel: median_of(|held| held.daily_travel),
                        energy_wh_m2: median_of(|held| held.energy_wh_m2),
                    }
                };
                let pair = Pair {
                    building: building_type.to_string(),
                    class: first.class,
                    tuned: group.iter().all(|pair| pair.tuned),
                    task,
                    period,
                    default: median_of(|pair| pair.default),
                    after: median_of(|pair| pair.after),
                };
                medians.row(row(building_type.name(), format!("{} buildings", group.len()), &pair));
            }
        }
        format!("{}\n\n  medians\n{}", table.text(), medians.text())
    }
}

fn table() -> Table {
    Table::new([
        "building",
        "zone",
        "task",
        "days",
        "RMS before, K",
        "after, K",
        "travel before, 1/d",
        "after, 1/d",
        "energy before, Wh/m²",
        "after, Wh/m²",
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
        format!("{:.2}", pair.after.rms_deviation_k),
        format!("{:.2}", pair.default.daily_travel),
        format!("{:.2}", pair.after.daily_travel),
        format!("{:.0}", pair.default.energy_wh_m2),
        format!("{:.0}", pair.after.energy_wh_m2),
        if pair.tuned { "" } else { "not tuned" }.to_owned(),
    ]
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    statistics::median(&values)
}
