//! `b2b import`, and runs of imported models.

use std::path::PathBuf;
use std::process::{Command, Output};

use b2b_energyplus::install::{Engine, Quiet};
use serde_json::Value;

fn models() -> PathBuf {
    Engine::ensure(&mut Quiet).unwrap().models.unwrap()
}

fn weather() -> String {
    let folder = models().parent().unwrap().join("weather");
    folder.join("USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw").to_string_lossy().into_owned()
}

fn warehouse() -> String {
    models().join("RefBldgWarehouseNew2004_Chicago.idf").to_string_lossy().into_owned()
}

fn b2b(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_b2b")).args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = b2b(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn import_reports_what_is_controlled_and_the_next_steps() {
    let output = b2b(&["import", &warehouse(), "--weather", &weather()]);
    let text = String::from_utf8_lossy(&output.stdout);
    for words in ["the agent controls 3 of 3 zones", "unitary", "heater", "Zones", "b2b run ", "--weather"] {
        assert!(text.contains(words), "`{words}` is not in: {text}");
    }
}

/// Programs in models from other tools read fans and coils, which importing replaces.
#[test]
fn a_model_whose_programs_read_replaced_equipment_runs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("programs.idf");
    let model = std::fs::read_to_string(warehouse()).unwrap();
    let programs = "\nEnergyManagementSystem:Sensor,FanRTF,FURNACE_PACU_CAV_1:1_Unitary_Package_fan,Fan Runtime Fraction;\n\
                    EnergyManagementSystem:GlobalVariable,Fraction;\n\
                    EnergyManagementSystem:Program,Read,SET Fraction = FanRTF;\n\
                    EnergyManagementSystem:ProgramCallingManager,Call,EndOfSystemTimestepBeforeHVACReporting,Read;\n";
    std::fs::write(&path, model + programs).unwrap();
    let report = json(&[
        "import",
        &path.to_string_lossy(),
        "--weather",
        &weather(),
        "--run",
        "01-01..01-01",
        "--json",
    ]);
    assert_eq!(report["trial"]["severes"], 0, "{report}");
}

#[test]
fn an_imported_model_runs_the_same_twice() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_string_lossy();
    let run = || {
        let (model, weather) = (warehouse(), weather());
        json(&["run", &model, "--weather", &weather, "--period", "01-08..01-08", "--out", &out, "--json"])
    };
    let first = run();
    assert_eq!(first["building"], "RefBldgWarehouseNew2004_Chicago");
    assert_eq!(first["engine_severes"], 0);
    assert_eq!(first["trajectory_hash"], run()["trajectory_hash"]);
}

#[test]
fn a_folder_of_models_prints_a_line_each_and_fails_if_one_fails() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(warehouse(), folder.path().join("good.idf")).unwrap();
    std::fs::write(folder.path().join("bad.idf"), "Version,25.2;\nZone,\n").unwrap();
    let path = folder.path().to_string_lossy();
    let output = b2b(&["import", &path, "--weather", &weather(), "--run", "01-08..01-08"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for words in ["good", "bad", "1 of 2 models can be used as environments", "truncated"] {
        assert!(text.contains(words), "`{words}` is not in: {text}");
    }
}

#[test]
fn missing_or_invalid_files_are_reported_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let noise = folder.path().join("noise.epw");
    std::fs::write(&noise, "no weather\n").unwrap();
    let (noise, here) = (noise.to_string_lossy(), folder.path().to_string_lossy());
    let (model, weather) = (warehouse(), weather());
    let cases: [(&[&str], [&str; 2]); 5] = [
        (&["import", &model], ["RefBldgWarehouse", "--weather FILE.epw"]),
        (&["run", &model], ["RefBldgWarehouse", "--weather FILE.epw"]),
        (&["import", &model, "--weather", &noise], ["noise.epw", "hours of weather"]),
        (&["import", "nowhere.idf", "--weather", &weather], ["nowhere.idf", "does not exist"]),
        (&["import", &here, "--weather", &weather], [&here, "no model"]),
    ];
    for (arguments, words) in cases {
        let output = b2b(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        for word in words {
            assert!(said.contains(word), "`{word}` is not in: {said}");
        }
    }
}
