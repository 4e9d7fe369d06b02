//! Adding a kind touches few files, tested by counting the files that know an existing kind.

use std::path::{Path, PathBuf};

/// Returns the source files of all crates and of the Python package, without tests.
fn sources() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut folders: Vec<PathBuf> = std::fs::read_dir(root.join("crates"))
        .unwrap()
        .map(|entry| entry.unwrap().path().join("src"))
        .chain([root.join("python/src"), root.join("python/building2building")])
        .collect();
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            let is_source = path.extension().is_some_and(|extension| extension == "rs" || extension == "py");
            match path.is_dir() {
                true => folders.push(path),
                false if is_source && !path.ends_with("tests.rs") => files.push(path),
                false => {}
            }
        }
    }
    files.sort();
    assert!(files.len() > 500, "{}", files.len());
    files
}

/// Returns the files that contain one of these words in a line of code outside tests, by their last two components.
fn files_with(words: &[&str]) -> Vec<String> {
    let contains = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let mut lines = code.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
        lines.any(|line| words.iter().any(|word| line.contains(word)))
    };
    let name = |path: PathBuf| {
        let parts: Vec<_> = path.components().rev().take(2).map(|part| part.as_os_str().to_owned()).collect();
        parts.iter().rev().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
    };
    sources().into_iter().filter(contains).map(name).collect()
}

#[test]
fn a_controller_is_known_to_its_own_file_and_to_the_list() {
    let mut files = files_with(&["Planner", "planner::", "mod planner", "\"planner\""]);
    // A docstring names the policies.
    files.retain(|file| file != "evaluation/__init__.py");
    assert_eq!(files, ["src/lib.rs", "src/planner.rs"]);
}

#[test]
fn a_building_type_is_known_to_its_own_file_and_to_the_list() {
    // Examples in help texts and comparisons with the paper name types, too.
    let mut files = files_with(&["RestaurantFastFood", "restaurant_fast_food"]);
    files.retain(|file| {
        !file.starts_with("run/") && !file.starts_with("src/paper") && !file.starts_with("src/estimate")
    });
    assert_eq!(files, ["building_type/mod.rs", "building_type/restaurant_fast_food.rs"]);
}

#[test]
fn a_learner_is_known_to_its_own_folder_and_to_the_list() {
    let mut files = files_with(&["SacConfig", "sac::", "mod sac", "\"sac\""]);
    files.retain(|file| !file.starts_with("sac/"));
    assert_eq!(files, ["learners/mod.rs"]);
}
