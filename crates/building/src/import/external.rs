//! Detection of external references in a model: code that the engine would run and files that it would open.
//!
//! The classes and fields are from the engine's schema, against which `tests/building/external.rs` compares them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::model::{Fields, Model, text};

/// Classes, with those below them, whose objects make the engine run code or exchange data with other programs.
pub const CODE: [(&str, &str); 3] = [
    ("ExternalInterface", "loads native code (an FMU) or exchanges data with another program"),
    ("PythonPlugin", "runs Python code"),
    ("GroundHeatExchanger:Vertical:Sizing", "starts another program (GHEDesigner)"),
];

/// Fields that name a file that the engine opens, with the name that it takes for an empty one.
pub const FILES: [(&str, &str, Option<&str>); 7] = [
    ("Chiller:Electric:ASHRAE205", "representation_file_name", None),
    ("Coil:DX:ASHRAE205:Performance", "representation_file_name", None),
    ("Construction:WindowDataFile", "file_name", Some("Window5DataFile.dat")),
    ("Schedule:File", "file_name", None),
    ("Schedule:File:Shading", "file_name", None),
    ("Table:IndependentVariable", "external_file_name", None),
    ("Table:Lookup", "external_file_name", None),
];

/// Remedy of every refusal.
const REMEDY: &str =
    "If you trust the author of the model, allow it with --allow-external (allow_external in Python)";

/// Makes the names of files in a model absolute, so that the engine opens those next to the model.
///
/// # Errors
/// Unless `allow`: a line for every object that runs code, and for every file that is not a regular file in `folder`.
pub(super) fn resolve(model: &mut Model, folder: &Path, allow: bool) -> Result<(), Vec<String>> {
    let mut problems = if allow { Vec::new() } else { code(model) };
    for (class, name, file, fields) in files_mut(model) {
        match within(folder, &file.name) {
            Ok(path) => {
                fields.insert(file.field.to_owned(), Value::String(path));
            }
            Err(_) if allow => {}
            Err(why) => {
                problems.push(format!("{class} `{name}` names the file `{}`, which {why}", file.name));
            }
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Returns the files that a model names.
pub fn files(model: &Model) -> Vec<PathBuf> {
    let classes = FILES.iter().flat_map(|(class, field, _)| {
        model.objects(class).into_iter().filter_map(move |(_, fields)| text(fields, field))
    });
    classes.map(PathBuf::from).collect()
}

/// Returns the files that the text of a model (IDF or epJSON) names and that exist, without reading the model: values
/// that are the name of a file, relative to the folder of the model, and the file that a `Construction:WindowDataFile`
/// opens by default. Every field counts, because models of other versions and code name files in other fields.
///
/// # Errors
/// The errors of reading the file.
pub fn named_in_text(path: &Path) -> std::io::Result<Vec<PathBuf>> {
    let text = super::text::decode(&std::fs::read(path)?).0;
    let folder = path.parent().unwrap_or(Path::new(""));
    let defaults = FILES.iter().filter_map(|(_, _, default)| *default);
    let mut named: BTreeSet<String> = defaults.map(str::to_owned).collect();
    let mut add = |value: &str| _ = named.insert(value.trim().replace('\\', "/"));
    match super::is_idf(path) {
        true => text.lines().flat_map(values_of_line).for_each(&mut add),
        // Import rejects a text that is not JSON.
        false => texts(&serde_json::from_str(&text).unwrap_or_default(), &mut add),
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Outside its folder, a model could name files without an end, such as the kernel's.
    let is_file_name = |name: &String| Path::new(name).extension().is_some() || within(here, name).is_ok();
    let files = named.into_iter().filter(|name| folder.join(name).is_file()).filter(is_file_name);
    Ok(files.map(|name| folder.join(name)).collect())
}

/// Returns the values in a line of an IDF, without its comment.
fn values_of_line(line: &str) -> impl Iterator<Item = &str> {
    line.split('!').next().unwrap_or_default().split([',', ';'])
}

/// Calls `add` with every text of a JSON value.
fn texts(value: &Value, add: &mut impl FnMut(&str)) {
    match value {
        Value::String(text) => add(text),
        Value::Array(items) => items.iter().for_each(|item| texts(item, add)),
        Value::Object(fields) => fields.values().for_each(|field| texts(field, add)),
        _ => {}
    }
}

fn code(model: &Model) -> Vec<String> {
    let refused = |class: &str| CODE.iter().find(|(root, _)| is_below(class, root)).map(|(_, what)| *what);
    let classes = model.classes().filter_map(|class| Some((class, refused(class)?)));
    let named = classes.flat_map(|(class, what)| {
        let objects = model.objects(class);
        objects.into_iter().map(move |(name, _)| format!("{class} `{name}` {what}. {REMEDY}"))
    });
    named.collect()
}

/// Returns whether a class is `root` or below it, as `A:B` is below `A`. The engine ignores case.
fn is_below(class: &str, root: &str) -> bool {
    let Some((start, rest)) = class.split_at_checked(root.len()) else { return false };
    start.eq_ignore_ascii_case(root) && (rest.is_empty() || rest.starts_with(':'))
}

/// A file that an object names.
struct Named {
    field: &'static str,
    name: String,
}

/// Returns every object that names a file: class, name, the file and the fields.
fn files_mut(model: &mut Model) -> impl Iterator<Item = (String, String, Named, &mut Fields)> {
    model.objects_mut().filter_map(|(class, name, fields)| {
        let (_, field, default) = FILES.iter().find(|(known, ..)| class.eq_ignore_ascii_case(known))?;
        let given = text(fields, field).map(str::trim).filter(|given| !given.is_empty());
        let name_of_file = given.or(*default)?.to_owned();
        Some((class.to_owned(), name.to_owned(), Named { field, name: name_of_file }, fields))
    })
}

/// Returns the path of a regular file in a folder or below it, with symbolic links resolved.
fn within(folder: &Path, name: &str) -> Result<String, String> {
    // The engine takes either separator for the system's.
    let name = name.replace('\\', "/");
    let folder = folder.canonicalize().map_err(|error| format!("cannot be opened: {error}"))?;
    let missing = |_| {
        format!("is missing. Put it where the model expects it; names are relative to {}", folder.display())
    };
    let path = folder.join(name).canonicalize().map_err(missing)?;
    if !path.starts_with(&folder) {
        return Err(format!("is outside the folder of the model, {}. {REMEDY}", folder.display()));
    }
    match path.to_str() {
        _ if !path.is_file() => Err(format!("is not a regular file. {REMEDY}")),
        Some(text) if !text.contains('\\') => Ok(text.to_owned()),
        _ => Err("has a path that EnergyPlus cannot read; expected UTF-8 without a backslash".into()),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn files_are_found_in_the_text_of_either_format() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("data")).unwrap();
        for name in ["people.csv", "other.csv", "Window5DataFile.dat"] {
            std::fs::write(path(name), "1").unwrap();
        }
        let idf = "Schedule:File,\n  People,  !- Name\n  Any,\n  people.csv,  !- File Name\n  1, 1;\n  Version, 26.1;\n";
        let epjson = json!({"Schedule:File": {"S": {"file_name": "data\\people.csv"}, "T": {"file_name": "people.csv"}}});
        std::fs::write(path("a.idf"), idf).unwrap();
        std::fs::write(path("a.epJSON"), epjson.to_string()).unwrap();
        let expected = [path("Window5DataFile.dat"), path("people.csv")];
        assert_eq!(named_in_text(&path("a.idf")).unwrap(), expected);
        assert_eq!(named_in_text(&path("a.epJSON")).unwrap(), expected);
        std::fs::rename(path("people.csv"), path("data/people.csv")).unwrap();
        assert_eq!(named_in_text(&path("a.epJSON")).unwrap()[1], path("data/people.csv"));
        assert!(named_in_text(&path("none.idf")).is_err());
    }

    #[test]
    fn a_file_is_found_in_an_epjson_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("a.epJSON");
        for name in ["büro.csv", "people, 2023.csv", "people;\u{a0}old", "gains"] {
            let file = folder.path().join(name);
            std::fs::write(&file, "1").unwrap();
            let ascii: String = name.encode_utf16().map(|unit| format!("\\u{unit:04x}")).collect();
            for written in [name, &ascii] {
                let text = format!(r#"{{"Schedule:File": {{"S": {{"file_name": "{written}"}}}}}}"#);
                std::fs::write(&model, text).unwrap();
                assert_eq!(named_in_text(&model).unwrap(), std::slice::from_ref(&file), "{written}");
            }
            std::fs::remove_file(file).unwrap();
        }
    }

    fn resolved(model: Value, folder: &Path, allow: bool) -> Result<Model, String> {
        let mut model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        resolve(&mut model, folder, allow).map_err(|problems| problems.join("\n")).map(|()| model)
    }

    #[test]
    fn classes_that_run_code_are_refused_in_any_case_and_allowed_on_request() {
        let folder = tempfile::tempdir().unwrap();
        for class in [
            "ExternalInterface",
            "ExternalInterface:FunctionalMockupUnitImport",
            "EXTERNALINTERFACE:schedule",
            "PythonPlugin:Instance",
            "GroundHeatExchanger:Vertical:Sizing:Rectangle",
        ] {
            let model = json!({class: {"Culprit": {}}});
            let said = resolved(model.clone(), folder.path(), false).unwrap_err();
            assert!(said.contains(class) && said.contains("`Culprit`"), "{said}");
            assert!(said.contains("--allow-external"), "{said}");
            resolved(model, folder.path(), true).unwrap();
        }
        resolved(json!({"GroundHeatExchanger:Vertical:Single": {"A": {}}}), folder.path(), false).unwrap();
    }

    #[test]
    fn a_file_next_to_the_model_is_named_by_its_whole_path() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("data")).unwrap();
        let file = folder.path().canonicalize().unwrap().join("data/gains.csv");
        std::fs::write(&file, "1\n").unwrap();
        for name in ["data/gains.csv", "data\\gains.csv", "./data/../data/gains.csv", file.to_str().unwrap()]
        {
            let model = json!({"schedule:file": {"S": {"file_name": name}, "s": {"file_name": name}}});
            let model = resolved(model, folder.path(), false).unwrap();
            assert_eq!(files(&model), [file.clone(), file.clone()], "{name}");
        }
    }

    #[test]
    fn a_file_elsewhere_is_refused_with_class_object_and_name() {
        let outside = tempfile::NamedTempFile::new().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let absolute = outside.path().to_str().unwrap();
        let above = format!("../{}", outside.path().file_name().unwrap().to_str().unwrap());
        std::os::unix::fs::symlink(absolute, folder.path().join("link.csv")).unwrap();
        std::fs::create_dir(folder.path().join("folder.csv")).unwrap();
        let backslashes = above.replace('/', "\\");
        for name in [absolute, &above, &backslashes, "link.csv", "folder.csv", "missing.csv", "/dev/zero"] {
            let model = json!({"Table:Lookup": {"T": {"external_file_name": name}}});
            let said = resolved(model.clone(), folder.path(), false).unwrap_err();
            assert!(said.contains("Table:Lookup `T`") && said.contains(&format!("`{name}`")), "{said}");
            resolved(model, folder.path(), true).unwrap();
        }
    }

    #[test]
    fn the_default_name_of_window_data_counts_as_given() {
        let folder = tempfile::tempdir().unwrap();
        let said = resolved(json!({"Construction:WindowDataFile": {"Clear": {}}}), folder.path(), false);
        assert!(said.unwrap_err().contains("Window5DataFile.dat"));
        resolved(json!({"Table:Lookup": {"T": {"external_file_name": ""}}}), folder.path(), false).unwrap();
    }
}
