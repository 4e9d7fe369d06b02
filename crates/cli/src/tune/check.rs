//! `b2b tune check`: whether what tuning found, and the energy scales that follow from it, come out again.

use anyhow::{Context, Result, bail};
use b2b_building::Class;
use b2b_control::tune::{self, Outcome};
use b2b_control::{Measured, ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::EnergyScale;

use super::{Groups, rollouts};
use crate::progress::{Download, counter};
use crate::{interrupt, shipped, stdout};

/// Check that the shipped parameters come to what is said of them
///
/// Runs the training buildings of each group again under the default and the tuned parameters, and compares scores,
/// penalties, travel and energy scales with those that are shipped. Exit code 1 where they differ by more than 1e-6,
/// relatively.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    groups: Groups,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<()> {
    let classes = arguments.groups.classes()?;
    let catalog = Catalog::open(&mut Download::new(false))?;
    let bar = counter(classes.len(), "groups", false);
    let mut wrong = Vec::new();
    for class in &classes {
        wrong.extend(difference(&catalog, *class)?.map(|why| format!("{class}: {why}")));
        bar.inc(1);
    }
    bar.finish_and_clear();
    stdout::print(&format!("{} groups, {} of them not as shipped", classes.len(), wrong.len()))?;
    match wrong.is_empty() {
        true => Ok(()),
        false => bail!("{}", wrong.join("\n")),
    }
}

/// How what a class comes to differs from what is shipped, if it does.
fn difference(catalog: &Catalog, class: Class) -> Result<Option<String>> {
    let Some(tuned) = Tuned::of(class) else { return Ok(Some("none is shipped".into())) };
    let again = measure(catalog, tuned).with_context(|| format!("{class} cannot be run"))?;
    let difference = shipped::difference(again.values(), tuned.measured.values());
    if difference > shipped::TOLERANCE {
        return Ok(Some(format!("differs by {difference:.1e}: {:?}, shipped {:?}", again, tuned.measured)));
    }
    let scale = EnergyScale::shipped().iter().find(|scale| scale.class == class);
    Ok(match scale {
        Some(scale) if scale.energy_scale == tuned.measured.energy => None,
        _ => Some("its energy scale is not that of its parameters".into()),
    })
}

/// What the shipped parameters come to on their buildings.
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
