//! `b2b tune check`: reproduction of the shipped tuning results and energy scales.

use anyhow::{Context, Result, bail};
use b2b_building::Class;
use b2b_control::tune::{self, Outcome};
use b2b_control::{Measured, ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::EnergyScale;

use super::rollouts::rollouts;
use crate::arguments::buildings::Classes;
use crate::progress::{Download, counter};
use crate::{interrupt, shipped, stdout};

/// Reproduce the results of the shipped parameters
///
/// Simulates the training buildings of each type and climate zone again under the default and the tuned parameters, and
/// compares scores, penalties, actuator travel and energy scales with the shipped values. Exits with code 1 if any
/// differs by more than 1e-6 (relative).
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    classes: Classes,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<()> {
    let classes = arguments.classes.list()?;
    let catalog = Catalog::open(&mut Download::new(false))?;
    let bar = counter(classes.len(), "types and zones", false);
    let mut wrong = Vec::new();
    for class in &classes {
        wrong.extend(difference(&catalog, *class)?.map(|why| format!("{class}: {why}")));
        bar.inc(1);
    }
    bar.finish_and_clear();
    stdout::print(&format!(
        "{} types and zones checked, {} differ from the shipped values",
        classes.len(),
        wrong.len()
    ))?;
    match wrong.is_empty() {
        true => Ok(()),
        false => bail!("{}", wrong.join("\n")),
    }
}

/// Returns how the results of a class differ from the shipped ones, if they do.
fn difference(catalog: &Catalog, class: Class) -> Result<Option<String>> {
    let Some(tuned) = Tuned::of(class) else { return Ok(Some("no shipped parameters".into())) };
    let again = measure(catalog, tuned).with_context(|| format!("cannot simulate {class}"))?;
    let difference = shipped::difference(again.values(), tuned.measured.values());
    if difference > shipped::TOLERANCE {
        return Ok(Some(format!("differs by {difference:.1e}: {:?}, shipped {:?}", again, tuned.measured)));
    }
    let scale = EnergyScale::shipped().iter().find(|scale| scale.class == class);
    Ok(match scale {
        Some(scale) if scale.energy_scale == tuned.measured.energy => None,
        _ => Some("the shipped energy scale does not match the energy use under the tuned parameters".into()),
    })
}

/// Measures the shipped parameters on their training buildings.
fn measure(catalog: &Catalog, tuned: &Tuned) -> Result<Measured> {
    let ids = tuned.buildings.iter().map(|id| id.parse()).collect::<Result<Vec<BuildingId>, _>>()?;
    let mut ready = rollouts(catalog, &ids, &tuned.periods, &[tuned.task.parse()?])?;
    let mut outcomes = |parameters: &ReactiveParameters| -> Result<Vec<Outcome>> {
        interrupt::check()?;
        Ok(ready.run(parameters)?.iter().map(|episodes| Outcome::of(episodes)).collect())
    };
    let defaults = outcomes(&ReactiveParameters::default())?;
    Ok(tune::measured(&defaults, &outcomes(&tuned.parameters)?))
}
