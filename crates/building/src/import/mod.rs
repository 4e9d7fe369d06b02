//! Import of users' models.
//!
//! The engine silently accepts truncated files, zones with the same name and models of another version, and simulates
//! something else than the author meant. [`read`] rejects such a model and says what to correct;
//! [`crate::PreparedBuilding::as_far_as_possible`] prepares it.
//!
//! In an imported building:
//!
//! - Systems of the supported kinds are controlled ([`crate::hvac`]). Zones with other equipment are controlled through the
//!   setpoints of their thermostats; the equipment keeps its schedules and availability, and is listed in
//!   [`crate::PreparedBuilding::uncontrolled`].
//! - The temperature of every zone is observed; controlled zones count in the reward.
//! - Energy is that of all HVAC, controlled or not, per floor area of all conditioned zones.

pub mod external;
mod idf;
mod references;
mod version;

use std::path::Path;

use b2b_energyplus::Library;

use crate::model::Model;
use crate::{Error, Result};

/// Reads a user's model (IDF or epJSON) and makes the checks that the engine does not.
///
/// The engine would load native code that a model names, and open any file. Unless `allow_external`, a model that runs
/// code or names a file outside its own folder is rejected before the engine simulates it.
///
/// # Errors
/// [`Error::Import`] with every problem; [`Error::Malformed`] for a file that is not a model; [`Error::Engine`] with the
/// engine's messages when it cannot read an IDF.
pub fn read(path: &Path, library: &Library, allow_external: bool) -> Result<Model> {
    check_file(path)?;
    let mut model = Model::read(path, library)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    external::resolve(&mut model, folder, allow_external).map_err(|problems| refused(path, problems))?;
    version::update(&mut model, &library.version()).map_err(|problem| refused(path, vec![problem]))?;
    check(&model).map_err(|problems| refused(path, problems))?;
    Ok(model)
}

/// Returns whether a path has the extension of a model.
pub fn is_model_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

const ENDINGS: [&str; 2] = ["idf", "epJSON"];

fn refused(path: &Path, problems: Vec<String>) -> Error {
    Error::Import { path: path.to_owned(), problems }
}

/// Checks that a path is a file that may be a model.
///
/// # Errors
/// [`Error::Import`] for one that is missing or of another kind; [`Error::Io`].
pub fn check_file(path: &Path) -> Result<()> {
    let refuse = |problem: String| Err(refused(path, vec![problem]));
    if path.is_dir() {
        return refuse("it is a folder; expected a .idf or .epJSON file".into());
    }
    if !path.exists() {
        return refuse("the file does not exist".into());
    }
    if !is_model_file(path) {
        return refuse("not an EnergyPlus model; expected a .idf or .epJSON file".into());
    }
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("idf") => {
            idf::check(&bytes).map_err(|why| refused(path, vec![why]))
        }
        _ => Ok(()),
    }
}

/// Checks a model for problems that the engine silently accepts.
fn check(model: &Model) -> std::result::Result<(), Vec<String>> {
    let mut problems = Vec::new();
    problems.extend(templates(model));
    problems.extend(like_named(model));
    if model.objects("Zone").is_empty() {
        problems.push("it has no Zone".into());
    }
    problems.extend(references::dangling(model));
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

fn templates(model: &Model) -> Option<String> {
    let class = model.classes().find(|class| class.starts_with("HVACTemplate:"))?;
    Some(format!("it has an {class}: expand templates with ExpandObjects, which ships with EnergyPlus"))
}

/// To the engine, zones whose names differ only by case are the same.
fn like_named(model: &Model) -> Vec<String> {
    let names = model.names("Zone");
    let earlier = |i: usize| names[..i].iter().find(|other| other.eq_ignore_ascii_case(&names[i]));
    let pairs = (0..names.len()).filter_map(|i| Some((&names[i], earlier(i)?)));
    pairs
        .map(|(name, other)| {
            format!("duplicate zone names `{other}` and `{name}` (case is ignored): rename one of them")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn problems(model: Value) -> String {
        let model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        check(&model).map_or_else(|problems| problems.join("\n"), |()| String::new())
    }

    #[test]
    fn a_sound_model_has_no_problem() {
        assert_eq!(problems(json!({"Zone": {"A": {}}})), "");
    }

    #[test]
    fn zones_that_differ_only_by_case_are_both_named() {
        let said = problems(json!({"Zone": {"Core": {}, "CORE": {}}}));
        assert!(said.contains("`Core`") && said.contains("`CORE`") && said.contains("rename"), "{said}");
    }

    #[test]
    fn templates_and_a_model_without_zones_are_rejected() {
        let said = problems(json!({"HVACTemplate:Zone:IdealLoadsAirSystem": {"T": {}}}));
        assert!(said.contains("ExpandObjects") && said.contains("no Zone"), "{said}");
    }
}
