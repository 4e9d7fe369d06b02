//! The version of EnergyPlus that a model was written for, and its conversion to the engine's.
//!
//! The engine reads a model of another version with a warning, although fields change between versions. The version is
//! read from the text before the engine sees it, and older models are converted step by step by rules that are data
//! (`data/versions`, one file per step). They follow the published input changes ("Rules9-0-0-to-9-1-0.md" and the
//! like) and the schemas of both versions.

mod apply;
pub mod document;
pub mod idf;
mod report;
mod rules;
mod special;

use document::Document;
pub use report::{Change, Conversion};
use rules::{STEPS, Step};

/// How to convert a model with programs of EnergyPlus.
const REMEDY: &str = "Convert it with the IDFVersionUpdater or the Transition programs of an EnergyPlus installation \
                      (github.com/NREL/EnergyPlus/releases)";

/// What was found about the version of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// The engine's version.
    Same,
    /// No version: the engine's is assumed.
    Assumed(String),
    /// An older version, converted.
    Converted(Conversion),
}

/// Converts a model to the engine's version.
///
/// # Errors
/// A sentence with the version and the remedy for a model that is newer, too old, or has objects that cannot be
/// converted.
pub fn convert(document: &mut Document, engine: &str) -> Result<Found, Vec<String>> {
    let to = short(engine);
    let Some(version) = document.version() else { return Ok(Found::Assumed(to)) };
    let from = short(&version);
    if from == to {
        return Ok(Found::Same);
    }
    let steps = steps(&from, &to).map_err(|problem| vec![problem])?;
    let mut report = Conversion { from, to: to.clone(), ..Conversion::default() };
    let problems: Vec<String> = steps.flat_map(|step| apply::step(document, step, &mut report)).collect();
    if !problems.is_empty() {
        let from = &report.from;
        let cannot =
            |problem: &String| format!("cannot be converted from {from} to {to}: {problem}. {REMEDY}");
        return Err(problems.iter().map(cannot).collect());
    }
    document.set_version(&to);
    Ok(Found::Converted(report))
}

/// Returns the steps between two versions.
fn steps(from: &str, to: &str) -> Result<std::slice::Iter<'static, Step>, String> {
    let (Some(version), Some(engine)) = (number(from), number(to)) else {
        return Err(format!("`{from}` is not a version of EnergyPlus; expected two numbers such as {to}"));
    };
    if version > engine {
        return Err(format!(
            "it is a model of EnergyPlus {from}, which is newer than the engine, {to}: there is no conversion to an older \
             version. Save it for {to} with the program that wrote it, or use a release of building2building with a newer \
             engine"
        ));
    }
    let first = STEPS.iter().position(|step| step.from == from);
    let last = STEPS.iter().position(|step| step.to == to);
    match (first, last) {
        (Some(first), Some(last)) => Ok(STEPS[first..=last].iter()),
        _ => Err(format!(
            "it is a model of EnergyPlus {from}; models of {} to {to} are accepted. {REMEDY}",
            STEPS[0].from
        )),
    }
}

/// Returns the first two numbers of a version.
pub(super) fn short(version: &str) -> String {
    version.split('.').take(2).collect::<Vec<_>>().join(".")
}

pub(super) fn number(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.').unwrap_or((version, "0"));
    Some((major.parse().ok()?, minor.parse().ok()?))
}

#[cfg(test)]
mod tests;
