//! CONTRIBUTING.md names the files that an extension takes, within a maximum number. That the examples compile is
//! tested where they are: documentation of `building2building`, `example_system.rs`, `random_search.rs` and
//! `terms/docs.rs`.

use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

/// A kind of extension, with an example from the repository.
struct Extension {
    section: &'static str,
    /// Maximum number of files.
    most: usize,
    /// Its files, as the guide spells their folders and names.
    files: &'static [[&'static str; 2]],
    /// The value of `NAME` for the example.
    name: &'static str,
}

const TERMS: &str = "crates/env/src/terms";
const METRICS: &str = "crates/env/src/metrics";
const EXTENSIONS: [Extension; 6] = [
    Extension {
        section: "Add a system",
        most: 3,
        files: &[
            ["crates/building/src/hvac", "NAME.rs"],
            ["crates/building/src/hvac", "mod.rs"],
            ["crates/env/tests/env", "example_system.rs"],
        ],
        name: "heating_only",
    },
    Extension {
        section: "Add a reward term",
        most: 2,
        files: &[[TERMS, "NAME.rs"], [TERMS, "mod.rs"]],
        name: "cost",
    },
    Extension {
        section: "Add a metric",
        most: 2,
        files: &[[METRICS, "mod.rs"], [METRICS, "NAME.rs"]],
        name: "episode_metrics",
    },
    Extension {
        section: "Add a learner",
        most: 2,
        files: &[["crates/learn/src/learners", "NAME.rs"], ["crates/learn/src/learners", "mod.rs"]],
        name: "sac",
    },
    Extension {
        section: "Add a controller",
        most: 2,
        files: &[["crates/control/src", "NAME.rs"], ["crates/control/src", "lib.rs"]],
        name: "off",
    },
    Extension {
        section: "Add a building type",
        most: 2,
        files: &[
            ["crates/building/src/building_type", "NAME.rs"],
            ["crates/building/src/building_type", "mod.rs"],
        ],
        name: "warehouse",
    },
];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_guide_names_the_files_of_every_extension_and_they_are_few() {
    let guide = read_to_string(repository().join("CONTRIBUTING.md")).unwrap();
    for Extension { section, most, files, name } in EXTENSIONS {
        let text = guide.split(&format!("## {section}\n")).nth(1).and_then(|rest| rest.split("\n## ").next());
        let text = text.unwrap_or_else(|| panic!("CONTRIBUTING.md has no section `{section}`"));
        assert!(files.len() <= most, "{section}: {} files of at most {most}", files.len());
        for [folder, file] in files {
            let own = file.replace("NAME", name);
            assert!(text.contains(folder), "{section}: no {folder}");
            let named = [*file, &own].iter().any(|file| text.contains(file));
            assert!(named, "{section}: no {file}");
            let folder = repository().join(folder);
            let exists = folder.join(&own).exists() || folder.join(own.trim_end_matches(".rs")).is_dir();
            assert!(exists, "{section}: {} does not exist", folder.join(&own).display());
        }
    }
}

/// The lists find what is in the files, so that no other file names the modules.
#[test]
fn a_term_a_learner_a_controller_and_a_building_type_are_named_by_their_list_alone() {
    for Extension { section, files, name, .. } in EXTENSIONS {
        if !["Add a reward term", "Add a learner", "Add a controller", "Add a building type"]
            .contains(&section)
        {
            continue;
        }
        let mut naming = Vec::new();
        let crate_folder = files[0][0].split("/src").next().unwrap();
        collect(&repository().join(crate_folder).join("src"), name, &mut naming);
        naming.sort();
        let [folder, list] = files[1];
        assert_eq!(naming, [repository().join(folder).join(list)], "{section}");
    }
}

/// Collects the files that name a module: `mod NAME;` or `NAME::` in code, except its own and tests.
fn collect(folder: &Path, module: &str, found: &mut Vec<PathBuf>) {
    for path in read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let is_own = path.file_stem().is_some_and(|stem| stem == module || stem == "tests");
        if is_own {
            continue;
        }
        if path.is_dir() {
            collect(&path, module, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let names = |line: &str| {
                let line = line.trim_start();
                let begins =
                    |at: usize| !line[..at].ends_with(|last: char| last.is_alphanumeric() || last == '_');
                let used = line.match_indices(&format!("{module}::")).any(|(at, _)| begins(at));
                !line.starts_with("//") && (used || line.ends_with(&format!("mod {module};")))
            };
            if read_to_string(&path).unwrap().lines().any(names) {
                found.push(path);
            }
        }
    }
}
