//! `b2b collect` and `b2b clone` from the outside, on the real engine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use b2b_energyplus::install::{Engine, Quiet};
use b2b_learn::offline::{Dataset, EpisodeFile};

use crate::program::{assert_rejected, b2b, json, stderr};

#[test]
fn a_dataset_is_collected_cloned_and_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let collect = "collect b2b/small-v0 OfficeSmall-0042 --policy reactive random --task occupancy \
                   --period 01-08..01-09 07-08..07-08 --out datasets";
    let summary = json(path, collect);
    assert_eq!((summary["episodes"].as_u64(), summary["steps"].as_u64()), (Some(4), Some(2 * 3 * 288)));
    assert_eq!(summary["contents"]["rescaled"], false);
    let data = path.join("datasets/b2b/small-v0/data");
    let metadata = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(data.join(name)).unwrap()).unwrap()
    };
    assert_eq!(
        (&metadata("metadata.json")["algorithm_name"], &metadata("2/metadata.json")["policy"]),
        (&"reactive, random".into(), &"random".into())
    );
    assert!(
        metadata("0/metadata.json")["episode_return"].as_f64()
            > metadata("2/metadata.json")["episode_return"].as_f64()
    );
    assert_eq!(
        (&metadata("1/metadata.json")["period"], &summary["contents"]["period"]),
        (&"07-08..07-08".into(), &"01-08..01-09, 07-08..07-08".into())
    );
    assert_rejected(path, collect, &["datasets/b2b/small-v0 exists", "another name"]);

    // The reactive controllers' actions are learned, and the clone acts in the building.
    let output = b2b(
        path,
        "collect b2b/reactive-v0 OfficeSmall-0042 --task occupancy --period 01-08..01-12 --out datasets",
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let clone = "clone datasets/b2b/reactive-v0 --observation features --updates 400 --hidden 64 --out clone";
    let summary = json(path, clone);
    assert!(summary["error"].as_f64().unwrap() < 0.1, "{summary}");
    let evaluate =
        "evaluate OfficeSmall-0042 --policy clone --task occupancy --period 01-08..01-09 --out evaluated";
    let score = json(path, evaluate)["windows"][0]["all"]["scores"]["interquartile_mean"]["value"].as_f64();
    assert!(score.unwrap() > 0.0);
    assert_rejected(path, clone, &["--out clone exists"]);
}

#[test]
fn several_buildings_have_rescaled_actions_and_one_type() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let day = "--period 01-08..01-08 --out datasets";
    let summary = json(path, &format!("collect two-v0 Warehouse-0001 Warehouse-0004 {day}"));
    assert_eq!(summary["contents"]["rescaled"], true);
    assert!(b2b(path, "clone datasets/two-v0 --updates 20 --out clone").status.success());
    for (arguments, words) in [
        (
            "mixed-v0 Warehouse-0001 OfficeSmall-0042",
            &["OfficeSmall, Warehouse", "one dataset for each type"][..],
        ),
        (
            "houses-v0 SingleFamilyHouse-0018 SingleFamilyHouse-0318",
            &["collect one dataset for each building"],
        ),
        ("noversion Warehouse-0001", &["`noversion` is not the name of a dataset", "-v0"]),
        ("b2b/../../x-v0 Warehouse-0001", &["is not the name of a dataset"]),
    ] {
        assert_rejected(path, &format!("collect {arguments} {day}"), words);
    }
    assert_rejected(path, "clone nowhere --out x", &["nowhere/data/metadata.json"]);
    let own = format!("collect own-v0 Warehouse-0001 --policy reactive own {day}");
    assert_rejected(path, &own, &["the policy own commands no actuators"]);
    // A task without a short form is in the dataset.
    std::fs::write(path.join("task.json"), r#"{"comfort_band": 0.7}"#).unwrap();
    json(path, "collect task-v0 Warehouse-0001 --task task.json --out sets --period 01-08..01-08");
    std::fs::remove_file(path.join("task.json")).unwrap();
    let output = b2b(path, "clone sets/task-v0 --updates 20 --out clone-task");
    assert!(output.status.success(), "{}", stderr(&output));
    let other = "clone sets/task-v0 --task occupancy --out x";
    assert_rejected(path, other, &["under the task occupancy; it has Warehouse under {"]);
    assert!(!path.join("x").exists());
    let collect = "collect set-v0 Warehouse-0001 --control setpoints --period 01-08..01-08 --out sets";
    assert!(b2b(path, collect).status.success());
    let output = b2b(path, "clone sets/set-v0 --updates 20 --out clone-set");
    assert!(output.status.success(), "{}", stderr(&output));
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let weather = models.parent().unwrap().join("weather/USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let model = models.join("RefBldgWarehouseNew2004_Chicago.idf");
    let model = format!("{} --weather {}", model.display(), weather.display());
    let summary = json(path, &format!("collect own-v0 {model} {day}"));
    assert_eq!((&summary["steps"], &summary["contents"]["rescaled"]), (&288.into(), &false.into()));
    assert_eq!(std::fs::read_dir(path.join("datasets")).unwrap().count(), 2);
    let output = b2b(path, "clone datasets/own-v0 --updates 20 --out clone-own");
    assert!(output.status.success(), "{}", stderr(&output));
}

/// A corpus of two types, small enough for a test.
const TINY: &str = r#"
types = ["SingleFamilyHouse", "OfficeSmall"]
buildings = 1
weeks = 1
widths = [256, 16]

[[episodes]]
task = "occupancy"
policies = ["reactive", "reactive+noise0.3"]

[[episodes]]
task = "operate+preview"
policies = ["own"]

[[histories]]
name = "direct"
task = "occupancy"
stages = 2

[histories.train]
preset = "residual"
acting = { kind = "direct" }
steps = 384
environments = 2
type_buildings = 1
window_days = 1
noise_cost = 0.0
evaluation = { every = 0, whole_period = false }
ppo = { n_steps = 96, batch_size = 96 }
"#;

/// Returns the content of all files of a folder, by name.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(files(&path)),
            false => drop(all.insert(path.clone(), std::fs::read(&path).unwrap())),
        }
    }
    all
}

#[test]
fn a_corpus_in_parts_has_the_bytes_of_a_whole_one_and_labels_that_can_be_cloned() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("tiny.toml"), TINY).unwrap();
    let collect = "collect --corpus tiny.toml b2b/tiny-v0 --out";
    let part = json(path, &format!("{collect} parts --shard 1/2"));
    assert_eq!((&part["episodes"], &part["of"], &part["complete"]), (&5.into(), &10.into(), &false.into()));
    assert!(!path.join("parts/b2b/tiny-v0/data/metadata.json").exists());
    let rest = json(path, &format!("{collect} parts"));
    assert_eq!((&rest["steps"], &rest["complete"]), (&(10 * 2016).into(), &true.into()));
    json(path, &format!("{collect} whole"));
    let relative = |root: &str| -> BTreeMap<PathBuf, Vec<u8>> {
        let root = path.join(root);
        files(&root)
            .into_iter()
            .map(|(file, bytes)| (file.strip_prefix(&root).unwrap().to_owned(), bytes))
            .collect()
    };
    let whole = relative("whole");
    assert!(relative("parts") == whole);
    // 10 episodes with metadata, 4 graphs, 4 agents, description, card, definition, universe and digests.
    assert_eq!(whole.len(), 2 * 10 + 4 + 2 * 4 + 5, "{:?}", whole.keys());
    assert_rejected(path, "collect --corpus quick b2b/tiny-v0 --out whole", &["is another corpus"]);
    assert_rejected(path, "collect --corpus huge b2b/x-v0", &["unknown corpus `huge`", "full, quick"]);

    // Without noise, the label is what was done, except where the ventilation interlock raised a flow.
    let dataset = Dataset::open(&path.join("whole/b2b/tiny-v0")).unwrap();
    let of = |number: usize| dataset.episodes[number].corpus.as_ref().unwrap();
    assert_eq!(
        (&of(5).building_type[..], of(5).action_width, &of(5).expert[..]),
        ("OfficeSmall", 10, "reactive")
    );
    assert_eq!((of(7).action_width, &of(7).expert[..], of(7).task.as_str()), (0, "", "operate+preview"));
    let (exact, noisy) = (dataset.read(5).unwrap(), dataset.read(6).unwrap());
    let near = |file: &EpisodeFile| {
        let pairs = file.actions.iter().zip(&file.expert);
        pairs.filter(|(action, label)| (*action - *label).abs() < 1e-6).count() as f64
            / file.actions.len() as f64
    };
    assert_eq!(exact.expert.len(), 2016 * 10);
    assert!(near(&exact) > 0.9, "{}", near(&exact));
    assert!(near(&noisy) < 0.5, "{}", near(&noisy));

    // The two stages of an agent act differently, and both unlike the expert.
    assert_eq!([8, 9].map(|number| &dataset.episodes[number].policy[..]), ["direct-1of2", "direct-2of2"]);
    let [first, second] = [8, 9].map(|number| dataset.read(number).unwrap());
    assert_ne!(first.actions, second.actions);
    assert!(near(&second) < 0.5, "{}", near(&second));
    let clone = "clone whole/b2b/tiny-v0 --observation features --updates 50 --hidden 16 --out clone";
    assert_rejected(path, clone, &["OfficeSmall, SingleFamilyHouse", "--type"]);
    json(path, &format!("{clone} --type OfficeSmall"));

    // The same command checks a complete corpus, instead of signing what is there.
    let repeat = format!("{collect} whole");
    json(path, &repeat);
    let metadata = path.join("whole/b2b/tiny-v0/data/1/metadata.json");
    let text = std::fs::read_to_string(&metadata).unwrap();
    std::fs::write(&metadata, text.replace("reactive", "better")).unwrap();
    assert_rejected(path, &repeat, &["data/1/metadata.json", "changed"]);
}
