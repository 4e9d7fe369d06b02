//! `b2b tune check`: reproduction of the shipped tuning results and energy scales.

use anyhow::{Context, Result, bail};
use b2b_building::Class;
use b2b_control::tune::{self, TrainingBuildings, TuningPlan};
use b2b_control::{Measured, Objective, ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::EnergyScale;

use super::rollouts::TrainingRollouts;
use crate::arguments::buildings::Classes;
use crate::program;
use crate::scoring::shipped;
use crate::terminal::progress::{Download, counter};
use crate::terminal::{interrupt, stdout};

/// Reproduce the results of the shipped parameters
///
/// Simulates the training buildings of each type and climate zone again under the default and the tuned parameters of
/// each objective, and compares losses, actuator travel and energy scales with the shipped values. Exits with code 1 if
/// any differs by more than 1e-6 (relative). All classes take about 15 minutes.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    classes: Classes,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<()> {
    let classes = arguments.classes.list()?;
    let catalog = program::catalog(&mut Download::new(false))?;
    let bar = counter(classes.len(), "types and zones", false);
    let mut wrong = Vec::new();
    for class in &classes {
        for objective in Objective::ALL {
            let difference = difference(&catalog, *class, objective)?;
            wrong.extend(difference.map(|why| format!("{class}, {objective}: {why}")));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    stdout::print(&format!(
        "{} types and zones checked, {} results differ from the shipped values",
        classes.len(),
        wrong.len()
    ))?;
    match wrong.is_empty() {
        true => Ok(()),
        false => bail!("{}", wrong.join("\n")),
    }
}

/// Returns how the results of a class differ from the shipped ones, if they do.
fn difference(catalog: &Catalog, class: Class, objective: Objective) -> Result<Option<String>> {
    let Some(tuned) = Tuned::of(class, objective) else { return Ok(Some("no shipped parameters".into())) };
    let again = measure(catalog, tuned).with_context(|| format!("cannot simulate {class}"))?;
    let difference = shipped::difference(again.values(), tuned.measured.values());
    if difference > shipped::TOLERANCE {
        return Ok(Some(format!("differs by {difference:.1e}: {:?}, shipped {:?}", again, tuned.measured)));
    }
    let scale = EnergyScale::shipped().iter().find(|scale| scale.class == class);
    let used = match objective {
        Objective::Comfort => Some(tuned.measured.energy),
        Objective::Energy => tuned.energy_scale,
    };
    Ok(match scale {
        Some(scale) if Some(scale.energy_scale) == used => None,
        _ => Some("the shipped energy scale does not match the energy use under the comfort set".into()),
    })
}

/// Measures the shipped parameters on their training buildings.
fn measure(catalog: &Catalog, tuned: &Tuned) -> Result<Measured> {
    let ids = |names: &[String]| names.iter().map(|id| id.parse()).collect::<Result<Vec<BuildingId>, _>>();
    let buildings = TrainingBuildings { search: ids(&tuned.buildings)?, validation: ids(&tuned.validation)? };
    let mut plan = TuningPlan::comfort(tuned.class, &buildings, &tuned.periods, tuned.seed);
    if let Some(energy_scale) = tuned.energy_scale {
        plan = plan.energy(&ReactiveParameters::default(), energy_scale);
    }
    let mut rollouts = TrainingRollouts::new(catalog, &buildings, &tuned.periods, &plan);
    let mut cells = |parameters: &ReactiveParameters| {
        interrupt::check()?;
        anyhow::Ok(rollouts.cells(parameters)?)
    };
    let defaults = cells(&ReactiveParameters::default())?;
    Ok(tune::measured(&plan, &defaults, &cells(&tuned.parameters)?))
}
