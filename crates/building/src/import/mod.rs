//! Import of users' models.
//!
//! The engine silently accepts truncated files, zones with the same name and models of another version, and simulates
//! something other than the author meant. [`read`] rejects such a model and says what to correct;
//! [`crate::PreparedBuilding::as_far_as_possible`] prepares it.
//!
//! In an imported building:
//!
//! - Systems of the supported kinds are controlled ([`crate::hvac`]). Zones with other equipment are controlled through
//!   the setpoints of their thermostats; the equipment keeps its schedules and availability, and is listed in
//!   [`crate::PreparedBuilding::uncontrolled`].
//! - The temperature of every zone is observed; controlled zones count in the reward.
//! - Energy covers all HVAC, controlled or not, per floor area of all conditioned zones.

pub mod calendar;
mod exchange;
pub mod external;
mod functions;
mod notes;
mod references;
mod setpoint_nodes;
mod tank_nodes;
mod templates;
mod text;
mod transition;
pub mod versions;

use std::path::Path;

use b2b_base::scratch::temporary_folder;
use b2b_energyplus::Library;
pub use notes::{Notes, SwitchedOff};
pub(crate) use notes::{switched_off, without_band};
use versions::document::Document;
use versions::{Found, idf};

use crate::model::Model;
use crate::schema::Schema;
use crate::{Error, Result};

/// A user's model as it was read.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The model, of the engine's version.
    pub model: Model,
    /// Notes for its author.
    pub notes: Notes,
}

/// How a user's model is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    /// Whether it may run code and open files outside its folder.
    pub allow_external: bool,
    /// Folder of EnergyPlus's Transition programs, which convert an old IDF instead of this project's rules.
    pub transition: Option<&'a Path>,
}

/// Reads a user's model (IDF or epJSON), converts it to the engine's version and makes the checks that the engine does
/// not.
///
/// The engine would load native code that a model names, and open any file. Unless `allow_external`, a model that runs
/// code or names a file outside its own folder is rejected before the engine simulates it.
///
/// # Errors
/// [`Error::Import`] with the problems; [`Error::Malformed`] for a file that is not a model; [`Error::Engine`] with
/// the engine's messages when it cannot read an IDF; [`Error::Io`].
pub fn read(path: &Path, library: &Library, allow_external: bool) -> Result<Model> {
    let options = Options { allow_external, ..Options::default() };
    Ok(read_with_notes(path, library, options)?.model)
}

/// As [`read`], with notes on what was changed and assumed.
///
/// # Errors
/// As [`read`].
pub fn read_with_notes(path: &Path, library: &Library, options: Options<'_>) -> Result<Imported> {
    let Options { allow_external, transition } = options;
    let Text { mut text, is_original, encoding } = checked_text(path)?;
    let by_programs = match transition.filter(|_| is_idf(path)) {
        None => None,
        Some(programs) => transition::convert(&text, &library.version(), programs)
            .map_err(|problem| refused(path, vec![problem]))?,
    };
    let by_programs = by_programs.map(|(converted, report)| {
        text = converted;
        report
    });
    let (mut model, found, expanded) = match is_idf(path) {
        true => read_idf(path, &text, is_original && by_programs.is_none(), library)?,
        false => read_epjson(path, &text, library)?,
    };
    if let (Found::Converted(by_rules), Some(_), false) = (&found, transition, is_idf(path)) {
        let why = format!(
            "--transition converts IDF files only, and this epJSON is of EnergyPlus {}: export it as IDF, or leave out the \
             option for conversion by b2b's own rules",
            by_rules.from
        );
        return Err(refused(path, vec![why]));
    }
    let found = by_programs.map_or(found, Found::Converted);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let exchange = exchange::replace(&mut model);
    external::resolve(&mut model, folder, allow_external).map_err(|problems| refused(path, problems))?;
    check(&model, &Schema::of(library)).map_err(|problems| refused(path, problems))?;
    let mut notes = Notes { warnings: encoding.into_iter().collect(), ..Notes::default() };
    notes.warnings.extend(exchange);
    match found {
        Found::Same => {}
        Found::Assumed(version) => {
            notes.warnings.push(format!("the model has no Version object; EnergyPlus {version} is assumed"));
        }
        Found::Converted(conversion) => notes.conversion = Some(conversion),
    }
    notes.warnings.extend(expanded);
    Ok(Imported { model, notes })
}

/// A model, what was found about its version, and a note on its templates, if any.
type Read = (Model, Found, Option<String>);

/// Reads an IDF.
fn read_idf(path: &Path, text: &str, is_original: bool, library: &Library) -> Result<Read> {
    let refuse = |problems| refused(path, problems);
    let mut document = idf::parse(text).map_err(|problem| refuse(vec![problem]))?;
    let found = versions::convert(&mut document, &library.version()).map_err(refuse)?;
    let expanded = templates::expand(&mut document, library).map_err(refuse)?;
    if is_original && expanded.is_none() && !matches!(found, Found::Converted(_)) {
        return Ok((Model::read(path, library)?, found, None));
    }
    let folder = temporary_folder("b2b-import-").map_err(b2b_energyplus::Error::from)?;
    let copy = folder.path().join(path.file_name().unwrap_or_default());
    std::fs::write(&copy, idf::write(&document))
        .map_err(|source| Error::Io { path: copy.clone(), source })?;
    let epjson = library.convert_idf(&copy).map_err(|error| error.on_model(path))?;
    Ok((Model::from_epjson(&epjson, path)?, found, expanded))
}

fn read_epjson(path: &Path, text: &str, library: &Library) -> Result<Read> {
    let model = Model::from_epjson(text, path)?;
    let mut document = Document::from_model(&model);
    let found =
        versions::convert(&mut document, &library.version()).map_err(|problems| refused(path, problems))?;
    match found {
        Found::Converted(_) => Ok((document.into_model(), found, None)),
        _ => Ok((model, found, None)),
    }
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
/// [`Error::Import`] for one that is missing or of another kind.
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
    Ok(())
}

/// The text of a model.
struct Text {
    text: String,
    /// Whether the file has these bytes, so that the engine reads the same.
    is_original: bool,
    /// A warning about the encoding.
    encoding: Option<String>,
}

/// Returns the text of a file that may be a model.
fn checked_text(path: &Path) -> Result<Text> {
    check_file(path)?;
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    let (text, encoding) = text::decode(&bytes);
    if is_idf(path) {
        text::check(&text).map_err(|why| refused(path, vec![why]))?;
    }
    Ok(Text { is_original: text.as_bytes() == bytes, text, encoding })
}

fn is_idf(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("idf"))
}

/// Checks a model for problems that the engine silently accepts.
fn check(model: &Model, schema: &Schema) -> std::result::Result<(), Vec<String>> {
    let mut problems = Vec::new();
    problems.extend(model.classes().find_map(templates::problem_in_epjson));
    problems.extend(like_named(model));
    if model.objects("Zone").is_empty() {
        problems.push("it has no Zone".into());
    }
    problems.extend(references::dangling(model, schema));
    problems.extend(setpoint_nodes::without_setpoint(model));
    problems.extend(tank_nodes::unconnected(model, schema));
    problems.extend(functions::unknown(model, schema));
    if problems.is_empty() { Ok(()) } else { Err(problems) }
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
        check(&model, &Schema::default()).map_or_else(|problems| problems.join("\n"), |()| String::new())
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
        for words in ["ExpandObjects", "export the model as IDF", "no Zone"] {
            assert!(said.contains(words), "{said}");
        }
    }
}
