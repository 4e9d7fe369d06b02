//! Trajectories, generated models and a result folder, compared with recorded hashes.
//!
//! A change that affects no number leaves `golden.json` unchanged. A change that is meant to affect physics, the
//! dataset or a file format records new hashes with
//! `B2B_RECORD_GOLDEN=1 cargo test --release -p b2b-cli --test cli golden`, and says why in its commit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::program::{b2b, json, stderr};
use b2b_base::digest::sha256;
use serde_json::Value;

const TYPES: [&str; 6] = [
    "SingleFamilyHouse",
    "RestaurantFastFood",
    "Warehouse",
    "RetailStandalone",
    "OfficeSmall",
    "OfficeMedium",
];

type Hashes = BTreeMap<String, String>;

#[test]
fn trajectories_models_and_results_are_what_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let mut actual = BTreeMap::new();
    actual.insert("trajectory of 10 January".to_owned(), trajectories(folder.path()));
    actual.insert("model".to_owned(), models(folder.path()));
    actual.insert("result folder".to_owned(), result_folder(folder.path()));

    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/cli/golden.json");
    if std::env::var_os("B2B_RECORD_GOLDEN").is_some() {
        std::fs::write(&path, serde_json::to_string_pretty(&actual).unwrap() + "\n").unwrap();
    }
    let expected: BTreeMap<String, Hashes> =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    for (what, hashes) in &actual {
        for (name, hash) in hashes {
            assert_eq!(Some(hash), expected[what].get(name), "{what} {name} is not what was recorded");
        }
    }
    assert_eq!(actual, expected);
}

/// The hash of a winter day of each type under the reactive controller.
fn trajectories(folder: &Path) -> Hashes {
    let hash = |name: &str| {
        let run = format!("run {name} --period 01-10..01-10 --task occupancy+energy0.5 --out {name}");
        json(folder, &run)["trajectory_hash"].as_str().unwrap().to_owned()
    };
    TYPES.map(|name| (name.to_owned(), hash(name))).into()
}

/// Two generated buildings of each type.
fn models(folder: &Path) -> Hashes {
    let mut hashes = Hashes::new();
    for name in TYPES {
        succeed(folder, &format!("generate {name} --count 2 --seed 7 --out models-{name}"));
        hashes.extend(files(&folder.join(format!("models-{name}"))));
    }
    hashes
}

/// Two houses of the dynamics problem for a day.
fn result_folder(folder: &Path) -> Hashes {
    let problem = "dynamics-house --test SingleFamilyHouse-0018 SingleFamilyHouse-0387 \
                   --train SingleFamilyHouse-0001 SingleFamilyHouse-0002 --period 01-10..01-10 --seed 0 1";
    succeed(folder, &format!("benchmark run {problem} --policy random --out result"));
    let result = folder.join("result/result.json");
    let mut content: Value = serde_json::from_slice(&std::fs::read(&result).unwrap()).unwrap();
    // Machines with different names can give equal numbers.
    assert!(content.as_object_mut().unwrap().remove("machine").is_some());
    std::fs::write(&result, content.to_string()).unwrap();
    files(&folder.join("result"))
}

fn succeed(folder: &Path, arguments: &str) {
    let output = b2b(folder, arguments);
    assert!(output.status.success(), "b2b {arguments}: {}", stderr(&output));
}

/// The SHA-256 of each file in a folder, except `manifest.csv`, which all folders of models have.
fn files(folder: &Path) -> Hashes {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let hash = |path: &Path| -> String { sha256(std::fs::read(path).unwrap()) };
    paths.filter(|path| name(path) != "manifest.csv").map(|path| (name(&path), hash(&path))).collect()
}
