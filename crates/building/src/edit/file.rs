//! Edits of model files.

use std::path::Path;

use b2b_base::aside::write_whole;
use b2b_energyplus::Library;

use super::{Edits, Report, apply};
use crate::import::external;
use crate::{Error, Model, Result, import};

/// Applies edits to a model file (IDF or epJSON), and writes the result atomically as epJSON to another file.
///
/// `allow_external` is as for [`import::read`].
///
/// # Errors
/// The errors of [`check_output`], [`check_other_file`], [`import::read`], [`apply`] and [`write_aside`].
pub fn edit_file(
    model: &Path,
    output: &Path,
    edits: &Edits,
    library: &Library,
    allow_external: bool,
) -> Result<Report> {
    check_output(output)?;
    check_other_file(model, output)?;
    let import::Imported { model: mut edited, notes } =
        import::read_with_notes(model, library, import::Options { allow_external, ..Default::default() })?;
    let mut report = apply(&mut edited, edits)?;
    report.warnings.extend(notes.lines());
    // A house keeps its band.
    if let Some(stem) = model.file_stem() {
        edited.name_house(&stem.to_string_lossy());
    }
    write_aside(&edited, output)?;
    report.warnings.extend(names_files_elsewhere(&edited, output));
    Ok(report)
}

/// Checks the name of an edited model.
///
/// # Errors
/// [`Error::OutputName`] unless it ends in `.epJSON`.
pub fn check_output(path: &Path) -> Result<()> {
    let is_epjson = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("epJSON"));
    if is_epjson { Ok(()) } else { Err(Error::OutputName { path: path.to_owned() }) }
}

/// Checks that an output is not the model which it is made from.
///
/// # Errors
/// [`Error::OutputIsModel`].
pub fn check_other_file(model: &Path, output: &Path) -> Result<()> {
    match (model.canonicalize(), output.canonicalize()) {
        (Ok(model), Ok(there)) if model == there => Err(Error::OutputIsModel { path: output.to_owned() }),
        _ => Ok(()),
    }
}

/// Writes a model aside and moves it into place, so that the file is always complete.
///
/// # Errors
/// [`Error::Io`] naming the file.
pub fn write_aside(model: &Model, path: &Path) -> Result<()> {
    write_whole(path, model.to_epjson().as_bytes())
        .map_err(|source| Error::Io { path: path.to_owned(), source })
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns a warning if a model names files that are not in its folder, which [`import::read`] rejects.
pub(crate) fn names_files_elsewhere(model: &Model, path: &Path) -> Option<String> {
    let folder = folder_of(path).canonicalize().ok()?;
    let file = external::files(model).into_iter().find(|file| !file.starts_with(&folder))?;
    Some(format!(
        "the edited model names {}, which is not in its folder; write it next to that file, or allow it with \
         --allow-external",
        file.display()
    ))
}
