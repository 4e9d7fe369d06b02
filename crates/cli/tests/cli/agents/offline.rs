//! `b2b collect` and `b2b clone` from the outside, on the real engine.

use b2b_energyplus::install::{Engine, Quiet};

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
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let weather = models.parent().unwrap().join("weather/USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let model = models.join("RefBldgWarehouseNew2004_Chicago.idf");
    let model = format!("{} --weather {}", model.display(), weather.display());
    let summary = json(path, &format!("collect own-v0 {model} {day}"));
    assert_eq!((&summary["steps"], &summary["contents"]["rescaled"]), (&288.into(), &false.into()));
    assert_eq!(std::fs::read_dir(path.join("datasets")).unwrap().count(), 2);
}
