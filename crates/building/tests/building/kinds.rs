//! The files that know each kind of system.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the product's files that name a kind of system, relative to the repository. Comments and tests within files
/// do not count, nor do node types, owners, candidates and controller loops of the same name.
fn files_naming(kind: &str) -> BTreeSet<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let crates = fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path().join("src"));
    let folders = crates.chain([root.join("python/src")]).filter(|folder| folder.is_dir());
    let files = folders.flat_map(|folder| rust_files(&folder));
    let naming = files.filter(|file| names(&fs::read_to_string(file).unwrap(), kind));
    naming.map(|file| file.strip_prefix(&root).unwrap().to_str().unwrap().to_owned()).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_source = |path: &Path| path.extension().is_some_and(|extension| extension == "rs");
    paths
        .flat_map(|path| match path.is_dir() {
            true => rust_files(&path),
            false => Vec::from_iter(Some(path).filter(|path| is_source(path))),
        })
        .collect()
}

fn names(source: &str, kind: &str) -> bool {
    const OTHERS: [&str; 6] = ["NodeType::", "Owner::", "Loop::", "Self::", "Candidate::", "HVAC:"];
    let code = source.split("#[cfg(test)]").next().unwrap_or_default();
    let code: Vec<_> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let is_word = |character: char| character.is_alphanumeric() || character == '_';
    code.match_indices(kind).any(|(at, _)| {
        let (before, after) = (&code[..at], &code[at + kind.len()..]);
        !before.ends_with(is_word)
            && !after.starts_with(is_word)
            && !OTHERS.iter().any(|other| before.ends_with(other))
    })
}

/// Returns the files outside `own` and the list of kinds that name a kind.
fn others(kind: &str, own: &str) -> Vec<String> {
    let files = files_naming(kind);
    assert!(files.contains("crates/building/src/hvac/mod.rs"), "{kind} is not registered: {files:?}");
    assert!(files.iter().any(|file| file.starts_with(own)), "{kind} is not in {own}: {files:?}");
    let known = |file: &String| file.starts_with(own) || file == "crates/building/src/hvac/mod.rs";
    files.into_iter().filter(|file| !known(file)).collect()
}

#[test]
fn a_kind_is_known_to_its_own_file_and_to_the_list_of_kinds() {
    for (kind, own) in [("HeatingOnly", "heating_only"), ("RoomUnit", "room_unit")] {
        assert_eq!(others(kind, &format!("crates/building/src/hvac/{own}")), [""; 0]);
    }
}

#[test]
fn outside_hvac_the_other_kinds_are_known_to_their_controllers_alone() {
    // The owner and the node type of an air handler have the name of the air loop.
    let allowed = ["crates/building/src/morphology/owner.rs", "crates/building/src/morphology/universe.rs"];
    for (kind, own) in [("Unitary", "unitary"), ("AirLoop", "air_loop")] {
        let mut others = others(kind, &format!("crates/building/src/hvac/{own}"));
        others.retain(|file| !file.starts_with("crates/building/src/hvac/"));
        let is_controller = |file: &str| {
            ["reactive", "guideline36"]
                .iter()
                .any(|name| file.starts_with(&format!("crates/control/src/{name}/")))
        };
        others.retain(|file| !allowed.contains(&file.as_str()) && !is_controller(file));
        assert_eq!(others, [""; 0], "{kind}");
    }
}
