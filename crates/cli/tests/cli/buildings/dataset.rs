//! The dataset on the command line: manifest, generated files, and buildings by id.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::program::{assert_rejected, b2b, command, json, stderr};
use arrow_array::Array;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use b2b_base::digest::sha256;
use b2b_climate::Place;
use b2b_dataset::Building;
use b2b_energyplus::install::Quiet;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// The files of a folder by name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(path).unwrap()))
        .collect()
}

#[test]
fn the_manifest_command_writes_the_checked_in_files_and_parquet_equals_csv() {
    let folder = tempfile::tempdir().unwrap();
    assert!(b2b(folder.path(), "dataset manifest --out here").status.success());
    let written = files(&folder.path().join("here"));
    assert_eq!(written.keys().collect::<Vec<_>>(), ["v1.csv", "v1.parquet"]);
    let checked_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dataset/data");
    assert!(written["v1.csv"] == files(&checked_in)["v1.csv"]);
    for folder in [folder.path().join("here"), checked_in] {
        parquet_equals_csv(&folder);
    }
}

#[test]
fn the_frozen_files_have_the_documented_digests() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/dataset.md")).unwrap();
    let frozen: Vec<_> = page.lines().filter_map(|line| line.strip_prefix("| `crates/")).collect();
    assert_eq!(frozen.len(), 4);
    for row in frozen {
        let (file, digest) = row.split_once("` | `").unwrap();
        let bytes = std::fs::read(root.join("crates").join(file)).unwrap();
        assert_eq!(digest.split('`').next().unwrap(), sha256(bytes), "{file} belongs to the frozen v1");
    }
}

fn parquet_equals_csv(folder: &Path) {
    let file = File::open(folder.join("v1.parquet")).unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().with_batch_size(10_000);
    let table = reader.build().unwrap().next().unwrap().unwrap();
    let text = std::fs::read_to_string(folder.join("v1.csv")).unwrap();
    let mut rows = text.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap();
    let rows: Vec<_> = rows.collect();
    assert_eq!((table.num_rows(), table.num_columns()), (rows.len(), names.len()));
    let column = |name| names.iter().position(|each| *each == name).unwrap();
    let (ids, window_u) = (column("id"), column("window_u"));
    let ventilation = column("ventilation");
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(table.column(ids).as_string::<i32>().value(index), row[ids]);
        let value = table.column(window_u).as_primitive::<Float64Type>().value(index);
        assert_eq!(value, row[window_u].parse::<f64>().unwrap());
        assert_eq!(table.column(ventilation).is_null(index), row[ventilation].is_empty());
    }
}

#[test]
fn the_same_arguments_generate_the_same_bytes_in_two_processes() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        "generate Warehouse --count 3 --seed 7 --place Miami --place Denver",
        "generate SingleFamilyHouse --count 3",
    ] {
        for (out, jobs) in [("one", 1), ("two", 2)] {
            let said = json(folder.path(), &format!("{arguments} --out {out} --jobs {jobs}"));
            assert_eq!((said["written"].as_u64(), said["kept"].as_u64()), (Some(3), Some(0)));
        }
    }
    let [one, two] = ["one", "two"].map(|out| files(&folder.path().join(out)));
    assert_eq!(one.len(), 7, "{:?}", one.keys());
    assert!(one == two);
}

#[test]
fn files_of_unchanged_buildings_are_kept_and_others_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = |count: u32| format!("generate Warehouse --count {count} --place Denver --out w");
    let generate = |count: u32| {
        let said = json(folder.path(), &arguments(count));
        (said["written"].as_u64().unwrap(), said["kept"].as_u64().unwrap())
    };
    assert_eq!(generate(2), (2, 0));
    assert_eq!(generate(2), (0, 2));
    let refused = |count: u32| {
        let said = stderr(&b2b(folder.path(), &arguments(count)));
        assert!(
            said.contains("w/Warehouse-seed0-0001.epJSON is of other parameters or of another"),
            "{said}"
        );
    };
    // A different count gives a different hypercube, in which the same names mean other buildings.
    refused(3);
    assert_eq!(generate(2), (0, 2));
    let manifest = folder.path().join("w/manifest.csv");
    let old = std::fs::read_to_string(&manifest).unwrap().replace(",v1,", ",v0,");
    std::fs::write(&manifest, old).unwrap();
    refused(2);
}

#[test]
fn an_interrupted_generation_leaves_complete_files_and_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments = "generate Warehouse --count 60 --place Denver --jobs 1 --out out";
    let child = command(folder.path(), arguments).stderr(Stdio::piped()).spawn().unwrap();
    let models = || {
        let entries = std::fs::read_dir(&out).into_iter().flatten().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.extension().is_some_and(|e| e == "epJSON")).collect::<Vec<_>>()
    };
    while models().len() < 3 {
        std::thread::sleep(Duration::from_millis(5));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.status.signal()), (Some(130), None), "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupted after "), "{}", stderr(&output));
    for path in models() {
        serde_json::from_reader::<_, Value>(File::open(&path).unwrap()).unwrap();
    }
    assert!(files_are_models_and_manifest(&out));
    let there = models().len() as u64;
    let said = json(folder.path(), arguments);
    assert_eq!((said["kept"].as_u64(), said["written"].as_u64()), (Some(there), Some(60 - there)));
    assert!(files_are_models_and_manifest(&out));
}

fn files_are_models_and_manifest(folder: &Path) -> bool {
    files(folder).keys().all(|name| name == "manifest.csv" || name.ends_with(".epJSON"))
}

/// Denver's weather file, without the design conditions of its header.
fn undesigned(folder: &Path) -> std::path::PathBuf {
    let denver = Place::find("Denver").unwrap().epw(&mut Quiet).unwrap();
    let text = std::fs::read_to_string(denver).unwrap();
    let lines = text.lines().map(|line| match line.starts_with("DESIGN CONDITIONS,") {
        true => "DESIGN CONDITIONS,0",
        false => line,
    });
    let path = folder.join("somewhere.epw");
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n")).unwrap();
    path
}

/// The rows of the manifest of a generated folder, by column.
fn manifest(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("manifest.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let names = lines.next().unwrap();
    lines.map(|row| names.iter().cloned().zip(row).collect()).collect()
}

#[test]
fn the_manifest_records_the_weather_file_and_the_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let weather = undesigned(folder.path());
    let settings = "--set x_scale=1.25 --set infiltration=0.5..0.6";
    let generate = |zone: &str, out: &str| {
        let arguments =
            format!("generate RetailStandalone --count 4 --weather somewhere.epw {settings} {zone}");
        let output = b2b(folder.path(), &format!("{arguments} --out {out} --json"));
        assert!(output.status.success(), "{}", stderr(&output));
        let said: Value = serde_json::from_slice(&output.stdout).unwrap();
        (said["written"].as_u64().unwrap(), stderr(&output))
    };
    let (written, said) = generate("", "5");
    assert_eq!(written, 4);
    assert!(said.contains("somewhere: climate zone 5B") && said.contains("--zone"), "{said}");
    assert!(said.contains("no design conditions") && said.contains("99.6 %"), "{said}");
    for row in manifest(&folder.path().join("5")) {
        assert_eq!((row["place"].as_str(), row["climate_zone"].as_str()), ("somewhere", "5B"));
        assert_eq!(row["x_scale"], "1.25");
        assert!((0.5..=0.6).contains(&row["infiltration"].parse::<f64>().unwrap()));
        assert_eq!(row["weather_sha256"].len(), 64);
    }
    assert_eq!(generate("", "5").0, 0, "nothing is generated twice");
    let (written, said) = generate("--zone 6A", "6");
    assert!(written == 4 && !said.contains("climate zone"), "{said}");
    assert_eq!(manifest(&folder.path().join("6"))[0]["climate_zone"], "6A");
    let text = std::fs::read_to_string(&weather).unwrap() + "\n";
    std::fs::write(&weather, text).unwrap();
    let again =
        format!("generate RetailStandalone --count 4 --weather somewhere.epw {settings} --zone 6A --out 6");
    let said = stderr(&b2b(folder.path(), &again));
    assert!(said.contains("is of other parameters"), "another weather file of the same name: {said}");
}

#[test]
fn dataset_buildings_and_new_ones_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = "generate RestaurantFastFood --dataset v1 --split test_small --out o";
    assert_eq!(json(folder.path(), dataset)["written"], 8);
    assert_eq!(json(folder.path(), "generate Warehouse --count 2 --place Denver --out o")["written"], 2);
    assert_eq!(json(folder.path(), dataset)["kept"], 8);
    let rows = manifest(&folder.path().join("o"));
    assert_eq!((rows.len(), rows[0]["test_small"].as_str()), (10, "true"));
}

#[test]
fn houses_accept_any_weather_file_and_have_no_climate_zone() {
    let folder = tempfile::tempdir().unwrap();
    undesigned(folder.path());
    let arguments = "generate SingleFamilyHouse --count 3 --weather somewhere.epw --set year=1950 --set storeys=2 --out o";
    let output = b2b(folder.path(), arguments);
    assert!(output.status.success() && !stderr(&output).contains("climate zone"), "{}", stderr(&output));
    for row in manifest(&folder.path().join("o")) {
        assert_eq!((row["year"].as_str(), row["vintage"].as_str()), ("1950", "[1946 - 1971)"));
        assert_eq!((row["storeys"].as_str(), row["climate_zone"].as_str()), ("2", ""));
        assert!((3000.0..3700.0).contains(&row["heating_degree_days"].parse::<f64>().unwrap()));
    }
    let output = b2b(folder.path(), &format!("{arguments} --zone 6A"));
    assert!(!output.status.success() && stderr(&output).contains("--zone"), "{}", stderr(&output));
}

#[test]
fn a_weather_file_without_design_conditions_or_of_a_month_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = undesigned(folder.path());
    let said = || {
        let output = b2b(folder.path(), "show Warehouse --weather somewhere.epw --json");
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let of_a_year = said();
    assert!(of_a_year.contains("no design conditions") && !of_a_year.contains("only days"), "{of_a_year}");
    let text = std::fs::read_to_string(&path).unwrap().replace("1/ 1,12/31", "1/ 1, 1/31");
    let january: Vec<_> = text.lines().take(8 + 31 * 24).collect();
    std::fs::write(&path, january.join("\n")).unwrap();
    let of_january = said();
    assert!(of_january.contains("somewhere: the file has only days of 01-01..01-31"), "{of_january}");
}

/// `b2b dataset ranges` prints them.
#[test]
fn the_ranges_in_the_documentation_match_the_dataset() {
    let printed = b2b(Path::new("."), "dataset ranges");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/dataset-ranges.txt");
    assert_eq!(String::from_utf8(printed.stdout).unwrap(), std::fs::read_to_string(file).unwrap());
}

#[test]
fn the_shares_of_ducted_houses_in_the_documentation_match_the_dataset() {
    let read = |path: &str| {
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)).unwrap()
    };
    let table = read("crates/dataset/data/v1.csv");
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let [kind, pump, heater] = ["type", "heat_pump_cop", "heater"]
        .map(|name| header.iter().position(|column| *column == name).unwrap());
    let houses: Vec<_> = lines.filter(|cells| cells[kind] == "SingleFamilyHouse").collect();
    let page = read("docs/dataset.md");
    for (name, has_pump) in [("heat pump", true), ("furnace with air conditioning", false)] {
        let share = |of: &[&str]| {
            let count =
                |cells: &&Vec<&str>| cells[pump].is_empty() != has_pump && of.contains(&cells[heater]);
            format!("{:.1} %", 100.0 * houses.iter().filter(count).count() as f64 / houses.len() as f64)
        };
        let [electric, fuel, sum] = [&["electric"][..], &["fuel"], &["electric", "fuel"]].map(share);
        let row = format!("| {name} | {electric} | {fuel} | {sum} |");
        assert!(page.contains(&row), "{row}");
    }
}

#[test]
fn invalid_arguments_are_rejected_with_the_valid_ones() {
    for (arguments, words) in [
        ("run OfficeSmall-1001", ["1001", "OfficeSmall-1000"]),
        ("run OficeSmall-0042", ["OficeSmall", "OfficeSmall"]),
        ("show Warehouse-x", ["`Warehouse-x`", "Warehouse-0001"]),
        ("check Warehouse", ["`Warehouse`", "OfficeSmall-0042"]),
        ("run OfficeSmall-0042 --place Denver", ["OfficeSmall-0042 is located in", "--weather"]),
        ("generate Warehouse --place Dever --out o", ["Dever", "Denver"]),
        ("generate SingleFamilyHouse --place Miami --out o", ["Miami", "Estrie"]),
        ("generate Warehouse --count 0 --out o", ["0", "--count"]),
        ("generate --out o", ["TYPE", "required"]),
        ("generate Warehouse --split test --out o", ["--dataset", "required"]),
        ("generate --dataset v1 --seed 3 --out o", ["--dataset", "--seed"]),
        (
            "generate Warehouse --set window_to_wal=0.01 --out o",
            ["window_to_wal`", "did you mean window_to_wall?"],
        ),
        ("generate Warehouse --set infiltration=2.5 --out o", ["`infiltration` is 2.5", "climate zone"]),
        ("generate Warehouse --set x_scale=nan --out o", ["`x_scale` is NaN", "0.7 to 1.5"]),
        ("generate Warehouse --set x_scale=0.5..1 --out o", ["`x_scale` is 0.5", "0.7 to 1.5"]),
        ("generate Warehouse --set x_scale --out o", ["x_scale", "NAME=VALUE"]),
        ("generate SingleFamilyHouse --set foundation=rock --out o", ["rock", "slab"]),
        ("generate SingleFamilyHouse --set floor_area=20 --out o", ["`floor_area` is 20", "40"]),
        ("generate Warehouse --weather none.epw --out o", ["none.epw", "No such file"]),
        ("generate Warehouse --zone 5A --out o", ["--weather", "required"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        assert_rejected(folder.path(), arguments, &words);
        assert!(files(folder.path()).is_empty());
    }
}

#[test]
fn a_building_of_the_dataset_runs_at_its_own_place() {
    let folder = tempfile::tempdir().unwrap();
    for id in ["RestaurantFastFood-0042", "SingleFamilyHouse-0042"] {
        let said = json(folder.path(), &format!("run {id} --period 01-01..01-01"));
        assert_eq!(said["building"], id);
        assert_eq!(said["place"], b2b_dataset::row(id.parse().unwrap()).building.place());
        assert_eq!(said["engine_severes"], 0);
    }
}

/// Its people's setpoints follow from the house, not from the controls or the name of the file.
#[test]
fn a_house_in_a_file_has_the_thermostat_and_the_band_of_the_house() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    json(path, "generate SingleFamilyHouse --count 1 --out g");
    let file = files(&path.join("g")).into_iter().find(|(name, _)| name.ends_with(".epJSON")).unwrap();
    std::fs::write(path.join("mine.epJSON"), &file.1).unwrap();
    let run = |model: &str, arguments: &str, out: &str| {
        let at = "--place Montréal --period 01-09..01-09";
        let said = json(path, &format!("run {model} {at} {arguments} --out {out}"));
        let heated = ["ener_tot", "tdis_tot"].map(|name| said[name].as_f64().unwrap());
        assert!(heated[0] > 0.1 && heated[1] < 5.0, "{model} {arguments}: {heated:?}");
        said["trajectory_hash"].as_str().unwrap().to_owned()
    };
    let original = format!("g/{}", file.0);
    assert_eq!(run(&original, "", "a"), run("mine.epJSON", "", "b"));
    let own = run("mine.epJSON", "--controller own", "c");
    assert_eq!(run(&original, "--controller own", "d"), own);
    run("mine.epJSON", "--control setpoints", "e");
    assert_rejected(
        path,
        "run mine.epJSON --place Montréal --controller own --task operate+fouling0.5 --out f",
        &["`operate+fouling0.5` has faults", "no effect under the controller `own`"],
    );
}

/// The floor that is conditioned follows the parameters.
#[test]
fn show_describes_the_building_of_the_id() {
    let folder = tempfile::tempdir().unwrap();
    let area = |name: &str| {
        json(folder.path(), &format!("show {name}"))["conditioned_floor_area_m2"].as_f64().unwrap()
    };
    let Building::Commercial { parameters, .. } =
        &b2b_dataset::row("RestaurantFastFood-0042".parse().unwrap()).building
    else {
        unreachable!()
    };
    let expected = area("RestaurantFastFood") * parameters.x_scale * parameters.y_scale;
    assert!((area("RestaurantFastFood-0042") / expected - 1.0).abs() < 1e-3);
}

/// Design flows are larger in Miami than in Denver, where the type is by default.
#[test]
fn the_equipment_of_a_type_is_sized_for_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let flow = |arguments: &str| {
        let shown = json(folder.path(), &format!("show OfficeSmall {arguments}"));
        let flows = shown["action"].as_array().unwrap().iter();
        flows.filter(|each| each["unit"] == "kg/s").map(|each| each["high"].as_f64().unwrap()).sum::<f64>()
    };
    let home = flow("");
    assert_eq!(flow("--place Denver"), home);
    assert!(flow("--place Miami") > 1.2 * home, "{} {home}", flow("--place Miami"));
}

#[test]
fn check_passes_a_building_within_its_temperature_limits() {
    let folder = tempfile::tempdir().unwrap();
    let reports = json(folder.path(), "check RestaurantFastFood-0042");
    let report = &reports.as_array().unwrap()[0];
    assert_eq!((&report["id"], &report["passed"]), (&"RestaurantFastFood-0042".into(), &true.into()));
    assert_eq!(report["episodes"].as_array().unwrap().len(), 2);
}
