//! A user's own model: read with care, then driven as far as it can be.
//!
//! The engine takes much without a word: a file that was cut off, two zones of one name, a model of another version. What
//! it would simulate then is not what the author meant. [`read`] refuses such a model and says what to put right;
//! [`crate::PreparedBuilding::as_far_as_possible`] makes an environment of it.
//!
//! What an imported building is:
//!
//! - Systems of the three kinds that an agent can drive are driven ([`crate::hvac`]). The others keep their own
//!   thermostats, schedules and availability, and are told in [`crate::PreparedBuilding::uncontrolled`].
//! - The temperature of every zone is observed; zones that an agent drives are judged.
//! - Energy is that of all HVAC, also of what is left alone, over the floor of all conditioned zones.

mod idf;
mod references;

use std::path::Path;

use b2b_energyplus::Library;

use crate::model::{Model, text};
use crate::{Error, Result};

/// Reads a user's model, IDF or epJSON, and checks what the engine would not.
///
/// # Errors
/// [`Error::Import`] with everything that has to be put right; [`Error::Malformed`] for a file that is no model;
/// [`Error::Engine`] with the engine's words when it cannot read an IDF.
pub fn read(path: &Path, library: &Library) -> Result<Model> {
    check_file(path)?;
    let model = Model::read(path, library)?;
    check(&model, &library.version()).map_err(|problems| refused(path, problems))?;
    Ok(model)
}

/// Whether a path looks like that of a model, by its ending.
pub fn is_model_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

const ENDINGS: [&str; 2] = ["idf", "epJSON"];

fn refused(path: &Path, problems: Vec<String>) -> Error {
    Error::Import { path: path.to_owned(), problems }
}

fn check_file(path: &Path) -> Result<()> {
    let refuse = |problem: String| Err(refused(path, vec![problem]));
    if path.is_dir() {
        return refuse("it is a folder: give one of the .idf or .epJSON files in it".into());
    }
    if !path.exists() {
        return refuse("there is no such file".into());
    }
    if !is_model_file(path) {
        return refuse("it is no EnergyPlus model: give a file that ends in .idf or .epJSON".into());
    }
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("idf") => {
            idf::check(&bytes).map_err(|why| refused(path, vec![why]))
        }
        _ => Ok(()),
    }
}

/// Everything in a model that the engine would take and an author would not.
fn check(model: &Model, engine: &str) -> std::result::Result<(), Vec<String>> {
    let mut problems = Vec::new();
    problems.extend(other_version(model, engine));
    problems.extend(templates(model));
    problems.extend(like_named(model));
    if model.objects("Zone").is_empty() {
        problems.push("it has no Zone: there is no building in it".into());
    }
    problems.extend(references::dangling(model));
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Fields change their meaning between versions.
fn other_version(model: &Model, engine: &str) -> Option<String> {
    let expected = engine.split('.').take(2).collect::<Vec<_>>().join(".");
    let (_, fields) = model.objects("Version").into_iter().next()?;
    let version = text(fields, "version_identifier")?;
    let same = version == expected || version.starts_with(&format!("{expected}."));
    (!same).then(|| {
        format!(
            "it is of EnergyPlus {version}, and {expected} is needed: take it to {expected} with the IDF version \
             updater that comes with EnergyPlus"
        )
    })
}

fn templates(model: &Model) -> Option<String> {
    let class = model.classes().find(|class| class.starts_with("HVACTemplate:"))?;
    Some(format!(
        "it has a {class}: templates must be expanded first, with the program ExpandObjects that comes with EnergyPlus"
    ))
}

/// Zones whose names differ by case alone are one to the engine.
fn like_named(model: &Model) -> Vec<String> {
    let names = model.names("Zone");
    let earlier = |i: usize| names[..i].iter().find(|other| other.eq_ignore_ascii_case(&names[i]));
    let pairs = (0..names.len()).filter_map(|i| Some((&names[i], earlier(i)?)));
    pairs
        .map(|(name, other)| {
            format!("it has two zones of one name, `{other}` and `{name}`: case makes no difference, so rename one")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn problems(model: Value) -> String {
        let model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        check(&model, "25.2.0-cf7368216c").map_or_else(|problems| problems.join("\n"), |()| String::new())
    }

    #[test]
    fn a_sound_model_has_no_problem() {
        let version = json!({"Version 1": {"version_identifier": "25.2"}});
        assert_eq!(problems(json!({"Version": version, "Zone": {"A": {}}})), "");
    }

    #[test]
    fn zones_that_differ_by_case_are_both_named() {
        let said = problems(json!({"Zone": {"Core": {}, "CORE": {}}}));
        assert!(said.contains("`Core`") && said.contains("`CORE`") && said.contains("rename"), "{said}");
    }

    #[test]
    fn a_model_of_another_version_is_told_which_one_is_needed() {
        let said = problems(json!({"Zone": {"A": {}}, "Version": {"V": {"version_identifier": "9.4"}}}));
        assert!(said.contains("9.4") && said.contains("25.2") && said.contains("updater"), "{said}");
    }

    #[test]
    fn templates_and_a_model_without_zones_are_refused() {
        let said = problems(json!({"HVACTemplate:Zone:IdealLoadsAirSystem": {"T": {}}}));
        assert!(said.contains("ExpandObjects") && said.contains("no Zone"), "{said}");
    }
}
