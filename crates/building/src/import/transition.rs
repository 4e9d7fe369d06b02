//! Conversion of an old IDF by EnergyPlus's own Transition programs, one per version step.

use std::path::{Path, PathBuf};
use std::time::Duration;

use b2b_base::scratch::temporary_folder;
use b2b_energyplus::{Confinement, run_program};

use super::versions::idf;
use super::versions::{Conversion, number, short};

/// Time limit of a program: it takes seconds for large models.
const LIMIT: Duration = Duration::from_secs(120);
/// The model in the folder where the programs work.
const MODEL: &str = "model.idf";

/// Converts an IDF to a version with the programs of a folder, and returns the text with a report. `None` if it already
/// has the version, has none, or has a newer one.
///
/// # Errors
/// The name of a program that is not in the folder, or that failed, and what it said.
pub(super) fn convert(
    text: &str,
    engine: &str,
    folder: &Path,
) -> Result<Option<(String, Conversion)>, String> {
    let (Some(version), to) = (idf::parse(text)?.version(), short(engine)) else { return Ok(None) };
    let from = short(&version);
    if number(&from) >= number(&to) {
        return Ok(None);
    }
    let work = temporary_folder("b2b-transition-").map_err(|error| error.to_string())?;
    std::fs::write(work.path().join(MODEL), text).map_err(|error| error.to_string())?;
    let mut report = Conversion { from: from.clone(), to: to.clone(), ..Conversion::default() };
    let mut now = from;
    while now != to {
        let program = program(folder, &now)?;
        now = program.to.clone();
        let ran = program.run(folder, work.path());
        let confinement = ran.map_err(|why| format!("{} failed: {why}", program.name))?;
        report.programs.push(format!("{}{}", program.name, confinement.clause()));
    }
    let converted = std::fs::read(work.path().join(MODEL)).map_err(|error| error.to_string())?;
    Ok(Some((String::from_utf8_lossy(&converted).into_owned(), report)))
}

/// A program of a version step.
struct Program {
    name: String,
    /// The versions as in its name, such as `V9-5-0`.
    tags: [String; 2],
    /// The version after it.
    to: String,
}

/// Returns the program that converts from a version.
fn program(folder: &Path, from: &str) -> Result<Program, String> {
    let tag = format!("V{}-0", from.replace('.', "-"));
    let beginning = format!("Transition-{tag}-to-");
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let found = names.filter_map(|name| {
        let to = name.strip_prefix(&beginning)?.to_owned();
        let version = short(&to.strip_prefix('V')?.replace('-', "."));
        number(&version).filter(|next| Some(*next) > number(from))?;
        Some(Program { tags: [tag.clone(), to], to: version, name })
    });
    found.min_by_key(|program| number(&program.to)).ok_or_else(|| {
        format!(
            "there is no program {beginning}V... in {}: give --transition the folder of an EnergyPlus installation \
             with it (PreProcess/IDFVersionUpdater)",
            folder.display()
        )
    })
}

impl Program {
    /// Converts the model of a folder. Returns how far the program was confined.
    fn run(&self, folder: &Path, work: &Path) -> Result<Confinement, String> {
        let said = |error: std::io::Error| error.to_string();
        // A program reads the lists of classes of both versions, and of outputs, where it works.
        for name in self.tags.iter().map(|tag| format!("{tag}-Energy+.idd")).chain([self.list_of_outputs()]) {
            match std::fs::copy(folder.join(&name), work.join(&name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(said(error)),
                _ => {}
            }
        }
        let ended = run_program(&folder.join(&self.name), &[MODEL], work, LIMIT).map_err(said)?;
        // Some versions leave the new model under this name, others replace the old one.
        let new = work.join(format!("{MODEL}new"));
        if new.exists() {
            std::fs::rename(&new, work.join(MODEL)).map_err(said)?;
        }
        let text = std::fs::read(work.join(MODEL)).map_err(said)?;
        let version = idf::parse(&String::from_utf8_lossy(&text)).ok().and_then(|model| model.version());
        match version {
            Some(version) if short(&version) == self.to => Ok(ended.confinement),
            _ => Err(format!("it wrote no model of version {}. {}", self.to, messages(work, &ended.output))),
        }
    }

    fn list_of_outputs(&self) -> String {
        let [from, to] = self.tags.each_ref().map(|tag| tag.trim_start_matches('V'));
        format!("Report Variables {from} to {to}.csv")
    }
}

/// Returns what a program said, in its file of errors or on its standard output.
fn messages(work: &Path, output: &str) -> String {
    let file: PathBuf = work.join(MODEL).with_extension("VCpErr");
    let said =
        std::fs::read(file).map_or(output.to_owned(), |bytes| String::from_utf8_lossy(&bytes).into_owned());
    said.trim().to_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    const MODEL_9_5: &str = "Version,9.5;\nZone,A;\n";

    /// A folder with programs that are scripts.
    fn installation(programs: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, script) in programs {
            let program = folder.path().join(name);
            std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
            std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        folder
    }

    #[test]
    fn an_old_idf_goes_through_the_programs_of_all_steps() {
        let folder = installation(&[
            (
                "Transition-V9-5-0-to-V9-6-0",
                "read -r idd < V9-5-0-Energy+.idd; echo \"Version,9.6;Zone,$idd;\" > $1",
            ),
            ("Transition-V9-6-0-to-V22-1-0", "read -r a < $1; echo \"Version,22.1;${a#*;}\" > ${1}new"),
        ]);
        std::fs::write(folder.path().join("V9-5-0-Energy+.idd"), "Named\n").unwrap();
        let (text, report) = convert(MODEL_9_5, "22.1.0", folder.path()).unwrap().unwrap();
        assert_eq!(text.trim(), "Version,22.1;Zone,Named;");
        assert_eq!((report.from.as_str(), report.to.as_str()), ("9.5", "22.1"));
        let programs: Vec<&str> =
            report.programs.iter().map(|program| program.split(',').next().unwrap()).collect();
        assert_eq!(programs, ["Transition-V9-5-0-to-V9-6-0", "Transition-V9-6-0-to-V22-1-0"]);
        assert_eq!(convert("Version,22.1;\n", "22.1.0", folder.path()), Ok(None));
    }

    #[test]
    fn a_program_that_is_missing_or_fails_is_named() {
        let folder = installation(&[("Transition-V9-5-0-to-V9-6-0", "echo no field 7")]);
        let failed = convert(MODEL_9_5, "22.1.0", folder.path()).unwrap_err();
        assert!(
            failed.starts_with(
                "Transition-V9-5-0-to-V9-6-0 failed: it wrote no model of version 9.6. no field 7"
            ),
            "{failed}"
        );
        let missing = convert("Version,9.3;\n", "22.1.0", folder.path()).unwrap_err();
        assert!(
            missing.contains("no program Transition-V9-3-0-to-V") && missing.contains("--transition"),
            "{missing}"
        );
    }
}
