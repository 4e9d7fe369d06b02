//! Jobs: conversions and runs of models in separate worker processes.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use b2b_building::{BuildingType, Model, PreparedBuilding, import};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Error, Host, Library};
use b2b_workers::{Jobs, WorkerOptions};
use tempfile::TempDir;

use crate::case::Case;
use crate::workers::options;

fn warehouse() -> PathBuf {
    Engine::ensure(&mut Quiet).unwrap().models.unwrap().join("RefBldgWarehouseNew2004_Chicago.idf")
}

/// A library whose conversions and runs are jobs.
fn hosted(options: WorkerOptions) -> Library {
    let library = Library::load(&options.library).unwrap();
    library.hosted_by(Arc::new(Jobs::new(options)))
}

fn write(name: &str, text: impl AsRef<[u8]>) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

#[test]
fn a_job_reads_and_sizes_a_model_like_this_process() {
    let case = Case::at_home(BuildingType::Warehouse);
    let prepared = |library: &Library| {
        let model = import::read(&warehouse(), library, false).unwrap();
        PreparedBuilding::as_far_as_possible("warehouse", model, &case.weather, library).unwrap()
    };
    let here = prepared(&case.library);
    let there = prepared(&hosted(options(&case)));
    assert_eq!(there.model().to_epjson(), here.model().to_epjson());
    assert_eq!(there, here);
}

#[test]
fn the_error_for_a_refused_model_has_the_callers_path_and_the_engines_messages() {
    let case = Case::at_home(BuildingType::Warehouse);
    let (_folder, path) = write("bad.idf", "Version,25.2;\nDance,A;\n");
    let error = hosted(options(&case)).convert_idf(&path).unwrap_err();
    let here = case.library.convert_idf(&path).unwrap_err();
    assert!(matches!(&error, Error::Engine { model, .. } if *model == path), "{error}");
    assert!(error.to_string().contains("\"Dance\" is not a valid Object Type"), "{error}");
    assert_eq!(error.to_string(), here.to_string());
}

#[test]
fn a_crash_while_sizing_is_an_error_that_names_the_model_and_the_signal() {
    let case = Case::at_home(BuildingType::Warehouse);
    let weather = std::fs::read_to_string(&case.weather).unwrap();
    let line = weather.lines().find(|line| line.starts_with("HOLIDAYS")).unwrap();
    let (_folder, weather) = write("damaged.epw", weather.replace(line, "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0"));
    let library = hosted(options(&case));
    let model = Model::read(&warehouse(), &library).unwrap();
    let error = PreparedBuilding::as_far_as_possible("shed", model, &weather, &library).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("EnergyPlus crashed (signal 11, a segmentation fault) while sizing shed"),
        "{text}"
    );
}

#[test]
fn a_job_beyond_its_time_limit_is_stopped() {
    let case = Case::at_home(BuildingType::Warehouse);
    let limit = Duration::from_millis(1);
    let jobs = Jobs::new(WorkerOptions { preparation_time_limit: limit, ..options(&case) });
    let text = jobs.convert_idf(&warehouse()).unwrap_err().to_string();
    assert!(text.contains("took longer than 1ms and was stopped while converting"), "{text}");
    assert!(text.contains("RefBldgWarehouseNew2004_Chicago.idf"), "{text}");
}

#[test]
fn a_job_ends_with_an_interrupt() {
    let case = Case::at_home(BuildingType::Warehouse);
    let jobs = Jobs::new(WorkerOptions { interrupted: || true, ..options(&case) });
    assert!(matches!(jobs.convert_idf(&warehouse()), Err(Error::Interrupted)));
}

#[test]
fn a_model_may_be_next_to_files_that_the_job_cannot_write() {
    let case = Case::at_home(BuildingType::Warehouse);
    let (folder, path) = write("m.idf", std::fs::read(warehouse()).unwrap());
    hosted(options(&case)).convert_idf(&path).unwrap();
    let names: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["m.idf"], "the job writes to a folder of its own");
}

/// Starts a worker as its owner, with an order.
fn reply_to(order: &str) -> (Option<i32>, String) {
    let (_folder, path) = write("order.json", order);
    let mut worker = Command::new(env!("CARGO_BIN_EXE_b2b-worker"));
    worker.arg("--b2b-worker").arg(std::process::id().to_string()).arg(&path);
    let status = worker.output().unwrap().status;
    (status.code(), read(&path.with_extension("reply")))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn an_unknown_order_is_refused_by_its_name() {
    let (code, reply) = reply_to(r#"{"order": "dance", "of": {}}"#);
    assert_eq!(code, Some(1));
    assert!(reply.contains("failed") && reply.contains("`dance`") && reply.contains("`simulate`"), "{reply}");
    let (_, reply) = reply_to(r#"{"order": "fragment", "of": {"runner": "learner", "order": {}}}"#);
    assert!(reply.contains("the order `fragment` is not a job"), "{reply}");
}
