//! `b2b tune compare`: the reactive controllers under default and tuned parameters.

use anyhow::{Context, Result};
use b2b_building::{Class, RunPeriod};
use b2b_control::{Objective, ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::{EnergyScale, Metrics, Task, Term};
use b2b_evaluate::statistics;
use serde::Serialize;

use super::rollouts::rollouts;
use crate::arguments::buildings::DatasetBuildings;
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Compare default and tuned parameters on test buildings
///
/// Runs every building under the default parameters, the comfort set and the energy set of its type and climate zone.
/// Reports the return of each for both objectives (comfort alone, and with an energy weight of 0.5), the RMS deviation
/// from the target temperature over the zones with heating and cooling, actuator travel and HVAC energy. For every type
/// and zone, reports the medians over buildings and tasks of the loss (negated return) relative to the defaults.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    buildings: DatasetBuildings,
    /// Tasks (see `b2b run --help`); their energy terms are ignored
    #[arg(long = "task", value_name = "TASK", num_args = 1.., default_values = ["constant", "occupancy", "random"],
          value_parser = Task::from_text)]
    tasks: Vec<Task>,
    /// Run period; repeat the option for several
    #[arg(long = "period", value_name = "PERIOD", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A winter week and a summer week.
const WEEKS: [&str; 2] = ["01-08..01-14", "07-08..07-14"];

/// A set of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Set {
    Default,
    Comfort,
    Energy,
}

/// A building under a task and a set of parameters, over all run periods.
#[derive(Serialize)]
struct Run {
    building: String,
    class: Class,
    task: String,
    set: Set,
    /// Whether the class has this set; if not, the run uses the defaults.
    is_tuned: bool,
    /// Return with an energy weight of 0, summed over the run periods.
    comfort_return: f64,
    /// Return with an energy weight of 0.5, summed over the run periods.
    energy_return: f64,
    /// RMS deviation, averaged over the run periods, K.
    rms_deviation_k: f64,
    /// Actuator travel, maximum over the run periods, full strokes/day.
    daily_travel: f64,
    /// HVAC energy, summed over the run periods, Wh/m².
    energy_wh_m2: f64,
}

/// The comparison of a class's parameter sets for an objective.
#[derive(Serialize)]
struct ClassRow {
    class: Class,
    objective: Objective,
    /// Number of buildings.
    buildings: usize,
    /// Median return under the default parameters.
    default_return: f64,
    /// Median return under the comfort set.
    comfort_set_return: f64,
    /// Median return under the energy set.
    energy_set_return: f64,
    /// Median loss under the comfort set relative to the defaults.
    comfort_set_relative_loss: f64,
    /// Median loss under the energy set relative to the defaults.
    energy_set_relative_loss: f64,
}

/// The comparison of all buildings.
#[derive(Serialize)]
struct Comparison {
    runs: Vec<Run>,
    classes: Vec<ClassRow>,
}

/// Runs the command.
pub fn compare(arguments: &Arguments) -> Result<()> {
    let buildings = arguments.buildings.ids()?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let bar = counter(buildings.len(), "buildings", arguments.json);
    let mut runs = Vec::new();
    for id in buildings {
        let of_building = arguments.runs(&catalog, id);
        interrupt::check()?;
        runs.extend(of_building.with_context(|| format!("cannot compare {id}"))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let classes = Class::all().flat_map(|class| {
        let of_class: Vec<&Run> = runs.iter().filter(|run| run.class == class).collect();
        Objective::ALL.map(|objective| ClassRow::of(class, objective, &of_class))
    });
    let comparison = Comparison { classes: classes.flatten().collect(), runs };
    stdout::print_result(arguments.json, &comparison, || comparison.text())
}

impl Arguments {
    fn runs(&self, catalog: &Catalog, id: BuildingId) -> Result<Vec<Run>> {
        let class = b2b_dataset::row(id).building.class();
        let mut rollouts = rollouts(catalog, &[id], &self.periods, &self.tasks)?;
        let mut runs = Vec::new();
        for set in Set::ALL {
            let (parameters, is_tuned) = set.parameters(class);
            let episodes = rollouts.run(&parameters, 0, 0..self.tasks.len())?;
            for (task, episodes) in self.tasks.iter().zip(episodes.chunks(self.periods.len())) {
                runs.push(Run::of(id, task, set, is_tuned, episodes));
            }
        }
        Ok(runs)
    }
}

impl Set {
    const ALL: [Self; 3] = [Self::Default, Self::Comfort, Self::Energy];

    /// Returns the parameters of a class, and whether it has this set.
    fn parameters(self, class: Class) -> (ReactiveParameters, bool) {
        let objective = match self {
            Self::Default => return (ReactiveParameters::default(), true),
            Self::Comfort => Objective::Comfort,
            Self::Energy => Objective::Energy,
        };
        (ReactiveParameters::tuned(Some(class), false, objective), Tuned::of(class, objective).is_some())
    }

    fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Comfort => "comfort",
            Self::Energy => "energy",
        }
    }
}

impl Run {
    fn of(id: BuildingId, task: &Task, set: Set, is_tuned: bool, episodes: &[Metrics]) -> Self {
        let class = b2b_dataset::row(id).building.class();
        let sum = |value: fn(&Metrics) -> f64| episodes.iter().map(value).sum::<f64>();
        let (temperature, energy) =
            (sum(|metrics| metrics.temperature_penalty), sum(|metrics| metrics.total(Term::Energy)));
        let scale = EnergyScale::of(class, 12).unwrap_or(1.0);
        Self {
            building: id.to_string(),
            class,
            task: Objective::Comfort.task(task).to_string(),
            set,
            is_tuned,
            comfort_return: -temperature,
            energy_return: -temperature - Objective::Energy.energy_weight() / scale * energy,
            rms_deviation_k: sum(Metrics::rms_deviation) / episodes.len().max(1) as f64,
            daily_travel: episodes.iter().map(Metrics::daily_travel).fold(0.0, f64::max),
            energy_wh_m2: energy,
        }
    }

    fn objective_return(&self, objective: Objective) -> f64 {
        match objective {
            Objective::Comfort => self.comfort_return,
            Objective::Energy => self.energy_return,
        }
    }
}

impl ClassRow {
    /// Returns the row of a class, if it has runs.
    fn of(class: Class, objective: Objective, runs: &[&Run]) -> Option<Self> {
        let returns = |set: Set| -> Vec<f64> {
            runs.iter().filter(|run| run.set == set).map(|run| run.objective_return(objective)).collect()
        };
        let [default, comfort, energy] = Set::ALL.map(returns);
        if default.is_empty() {
            return None;
        }
        let relative = |returns: &[f64]| median(returns.iter().zip(&default).map(|(a, b)| a / b).collect());
        let mut buildings: Vec<&str> = runs.iter().map(|run| run.building.as_str()).collect();
        buildings.sort_unstable();
        buildings.dedup();
        Some(Self {
            class,
            objective,
            buildings: buildings.len(),
            comfort_set_relative_loss: relative(&comfort),
            energy_set_relative_loss: relative(&energy),
            default_return: median(default),
            comfort_set_return: median(comfort),
            energy_set_return: median(energy),
        })
    }
}

impl Comparison {
    /// Returns a row for every run, then one for every class and objective.
    fn text(&self) -> String {
        let mut runs = Table::new([
            "building",
            "zone",
            "task",
            "set",
            "comfort return",
            "energy return",
            "RMS deviation (K)",
            "actuator travel (strokes/day)",
            "energy (Wh/m²)",
            "",
        ]);
        for run in &self.runs {
            runs.row([
                run.building.clone(),
                zone(run.class),
                run.task.clone(),
                run.set.name().to_owned(),
                format!("{:.2}", run.comfort_return),
                format!("{:.2}", run.energy_return),
                format!("{:.2}", run.rms_deviation_k),
                format!("{:.2}", run.daily_travel),
                format!("{:.0}", run.energy_wh_m2),
                if run.is_tuned { "" } else { "not tuned" }.to_owned(),
            ]);
        }
        format!("{}\n\n  medians by type and zone\n{}", runs.text(), self.classes().text())
    }

    fn classes(&self) -> Table {
        let mut classes = Table::new([
            "type",
            "zone",
            "buildings",
            "objective",
            "default return",
            "comfort set return",
            "energy set return",
            "comfort set / default loss",
            "energy set / default loss",
        ]);
        for row in &self.classes {
            classes.row([
                row.class.building_type.to_string(),
                zone(row.class),
                row.buildings.to_string(),
                row.objective.to_string(),
                format!("{:.1}", row.default_return),
                format!("{:.1}", row.comfort_set_return),
                format!("{:.1}", row.energy_set_return),
                format!("{:.3}", row.comfort_set_relative_loss),
                format!("{:.3}", row.energy_set_relative_loss),
            ]);
        }
        classes
    }
}

fn zone(class: Class) -> String {
    class.climate_zone.map_or_else(String::new, |zone| zone.to_string())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    statistics::median(&values)
}
