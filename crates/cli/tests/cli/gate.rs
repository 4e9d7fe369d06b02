//! The tests that the gate leaves to the nightly command.

use std::fs::{read_dir, read_to_string};
use std::path::Path;

#[test]
fn the_tests_left_to_the_nightly_command_exist() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let config = read_to_string(crates.join("../.config/nextest.toml")).unwrap();
    let names: Vec<_> = config.split("test(=").skip(1).map(|rest| rest.split_once(')').unwrap().0).collect();
    assert!(!names.is_empty());
    for name in names {
        // A test of a program with one file has no module.
        let (module, function) = name.rsplit_once("::").unwrap_or(("*", name));
        let module = module.replace("::", "/");
        let exists = read_dir(crates).unwrap().map(|each| each.unwrap().path()).any(|each| {
            let folder = each.file_name().unwrap().to_str().unwrap();
            let paths: Vec<_> = match module.as_str() {
                "*" => read_dir(each.join("tests"))
                    .into_iter()
                    .flatten()
                    .map(|file| file.unwrap().path())
                    .collect(),
                _ => files(folder, &module).into_iter().map(|file| each.join(file)).collect(),
            };
            paths
                .iter()
                .filter_map(|path| read_to_string(path).ok())
                .any(|text| text.contains(&format!("fn {function}(")))
        });
        assert!(exists, "`{name}` of .config/nextest.toml is no test; remove the line or correct the name");
    }
}

/// Returns the files of a crate, one of which has the tests of a module: a program of tests, or a file of the crate.
fn files(folder: &str, module: &str) -> Vec<String> {
    let own = module.trim_end_matches("/tests");
    let of_module = |rest: &str| {
        vec![
            format!("tests/{folder}/{module}{rest}.rs"),
            format!("tests/learners/{module}{rest}.rs"),
            format!("src/{module}{rest}.rs"),
            format!("src/{own}{rest}.rs"),
        ]
    };
    ["", "/mod"].into_iter().flat_map(of_module).collect()
}

/// Returns whether a comment has an example that cargo would compile.
fn has_example(text: &str) -> bool {
    let fence = |line: &str| {
        let line = line.trim_start();
        let comment = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))?;
        comment.trim_start().strip_prefix("```").map(str::to_owned)
    };
    // Every other fence closes a block.
    let mut opening = text.lines().filter_map(fence).step_by(2);
    opening.any(|tag| ["", "rust", "no_run", "should_panic"].contains(&tag.as_str()))
        || text.contains("#[doc = include_str!")
}

fn sources(folder: &Path) -> Vec<String> {
    let paths = read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths
        .flat_map(|path| match path.is_dir() {
            true => sources(&path),
            false if path.extension().is_some_and(|ending| ending == "rs") => {
                vec![read_to_string(path).unwrap()]
            }
            false => Vec::new(),
        })
        .collect()
}

#[test]
fn examples_in_comments_are_looked_for_in_the_crates_that_have_some() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for each in read_dir(crates).unwrap().map(|each| each.unwrap().path()) {
        if each.join("src/lib.rs").exists() {
            let left_out = read_to_string(each.join("Cargo.toml")).unwrap().contains("doctest = false");
            let has_some = sources(&each.join("src")).iter().any(|text| has_example(text));
            assert_ne!(has_some, left_out, "`doctest = false` of {}", each.display());
        }
    }
}
