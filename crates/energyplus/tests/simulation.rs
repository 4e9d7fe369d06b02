//! Runs of EnergyPlus through the public interface.

use std::path::{Path, PathBuf};
use std::process::Command;

use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Error, Event, Level, Library, Run, Simulation, Variable};
use serde_json::{Value, json};
use tempfile::TempDir;

const ZONE: &str = "Core_ZN";
const TEMPERATURE: &str = "Zone Mean Air Temperature";

/// A small office over two winter days, in its own folder.
struct Office {
    library: Library,
    folder: TempDir,
    idf: PathBuf,
    weather: PathBuf,
}

impl Office {
    fn new() -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let office = Self {
            folder: tempfile::tempdir().unwrap(),
            idf: engine.models.unwrap().join("ASHRAE901_OfficeSmall_STD2019_Denver.idf"),
            weather: engine.weather.unwrap().join("USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw"),
            library,
        };
        let mut model: Value =
            serde_json::from_str(&office.library.convert_idf(&office.idf).unwrap()).unwrap();
        let classes = model.as_object_mut().unwrap();
        classes.retain(|class, _| !class.starts_with("Output"));
        classes["RunPeriod"] = json!({"Two days": {
            "begin_month": 1, "begin_day_of_month": 10, "end_month": 1, "end_day_of_month": 11}});
        std::fs::write(office.model(), model.to_string()).unwrap();
        office
    }

    fn model(&self) -> PathBuf {
        self.folder.path().join("office.epJSON")
    }

    /// Writes the first `1/parts` of a file under another name.
    fn part_of(&self, file: &Path, parts: usize) -> PathBuf {
        let text = std::fs::read(file).unwrap();
        let part = self.folder.path().join(format!("part.{}", file.extension().unwrap().display()));
        std::fs::write(&part, &text[..text.len() / parts]).unwrap();
        part
    }

    fn run(&self) -> Run {
        Run::new(self.model(), &self.weather).request(TEMPERATURE, ZONE)
    }

    fn start(&self) -> (Simulation, Variable) {
        let simulation = self.run().start(&self.library).unwrap();
        let temperature = simulation.variable(TEMPERATURE, ZONE).unwrap();
        (simulation, temperature)
    }

    /// Bits of the temperature of every step.
    fn trace(&self) -> Vec<u64> {
        let (mut simulation, temperature) = self.start();
        let mut trace = Vec::new();
        while let Some(event) = simulation.advance().unwrap() {
            if event == Event::Step {
                trace.push(simulation.read(temperature).to_bits());
            }
        }
        trace
    }
}

#[test]
fn a_run_that_terminates_reports_why() {
    let office = Office::new();
    let (mut simulation, _) = office.start();
    while simulation.advance().unwrap() != Some(Event::Step) {}
    let [heating, cooling] = ["Heating Setpoint", "Cooling Setpoint"]
        .map(|setpoint| simulation.actuator("Zone Temperature Control", setpoint, ZONE).unwrap());
    simulation.set(heating, 40.0);
    simulation.set(cooling, 20.0);
    let error = std::iter::repeat_with(|| simulation.advance()).take(3).find_map(Result::err).unwrap();
    let Error::Engine { code, ref messages, .. } = error else { panic!("{error}") };
    assert_ne!(code, 0);
    assert!(messages.count(Level::Fatal) > 0, "{messages}");
    assert!(error.to_string().to_lowercase().contains("setpoint"), "{error}");
    assert_eq!(simulation.advance().unwrap(), None, "the run is over");
}

#[test]
fn a_missing_file_is_reported_by_name() {
    let office = Office::new();
    let missing = Path::new("nowhere/file");
    for error in [
        Run::new(missing, &office.weather).start(&office.library).unwrap_err(),
        Run::new(office.model(), missing).start(&office.library).unwrap_err(),
        office.library.convert_idf(missing).unwrap_err(),
    ] {
        assert!(matches!(error, Error::MissingFile { .. }), "{error}");
        assert!(error.to_string().contains("nowhere"), "{error}");
    }
}

#[test]
fn a_truncated_file_is_an_error_with_the_messages_of_energyplus() {
    let office = Office::new();
    // The engine's IDF reader accepts half a file as a smaller model; a tenth contains no building.
    let idf = office.part_of(&office.idf, 10);
    let (model, weather) = (office.part_of(&office.model(), 2), office.part_of(&office.weather, 100));
    let malformed = office.folder.path().join("malformed.epJSON");
    std::fs::write(&malformed, "{\"Version\": {,").unwrap();
    for (what, error) in [
        ("IDF", Run::new(idf, &office.weather).start(&office.library).err()),
        ("epJSON", Run::new(model, &office.weather).start(&office.library).err()),
        ("malformed epJSON", Run::new(malformed, &office.weather).start(&office.library).err()),
        ("EPW", Run::new(office.model(), weather).start(&office.library).err()),
    ] {
        let Some(Error::Engine { code, messages, .. }) = error else { panic!("{what}: {error:?}") };
        assert_ne!(code, 0, "{what}");
        assert!(!messages.to_string().trim().is_empty(), "{what}: the engine says something");
    }
}

#[test]
fn an_unknown_actuator_variable_or_meter_is_reported_by_name() {
    let (simulation, _) = Office::new().start();
    let errors = [
        simulation.actuator("Schedule:Constant", "Schedule Value", "No Such Schedule").map(drop),
        simulation.variable("No Such Variable", ZONE).map(drop),
        simulation.meter("No Such Meter").map(drop),
    ];
    for (error, name) in errors.into_iter().zip(["No Such Schedule", "No Such Variable", "No Such Meter"]) {
        assert!(error.unwrap_err().to_string().contains(name));
    }
}

#[test]
fn an_uninterrupted_run_is_suspended_only_around_warm_up() {
    let office = Office::new();
    let mut simulation = office.run().stop_every(0).start(&office.library).unwrap();
    assert_eq!(simulation.advance().unwrap(), Some(Event::WarmedUp));
    assert_eq!(simulation.advance().unwrap(), None);
    assert_eq!(simulation.message_count(Level::Severe), 0);
    let messages = office.run().to_end(&office.library).unwrap();
    assert_eq!(messages.count(Level::Severe), 0);
}

#[test]
fn two_runs_interleaved_on_a_thread_equal_a_single_run_bit_for_bit() {
    let office = Office::new();
    let alone = office.trace();
    assert_eq!(alone.len(), 2 * 24 * 4, "two days at four steps an hour");
    let mut runs = [office.start(), office.start()];
    let mut traces = [vec![], vec![]];
    // The second run lags by some steps.
    for turn in 0.. {
        let mut over = true;
        for (i, ((simulation, temperature), trace)) in runs.iter_mut().zip(&mut traces).enumerate() {
            if turn < 37 * i {
                continue;
            }
            let event = simulation.advance().unwrap();
            over &= event.is_none();
            if event == Some(Event::Step) {
                trace.push(simulation.read(*temperature).to_bits());
            }
        }
        if over {
            break;
        }
    }
    assert_eq!(traces, [alone.clone(), alone]);
}

#[test]
fn two_concurrent_threads_equal_a_single_run_bit_for_bit() {
    let office = Office::new();
    let alone = office.trace();
    let traces = std::thread::scope(|scope| {
        let threads = [(); 2].map(|()| scope.spawn(|| office.trace()));
        threads.map(|thread| thread.join().unwrap())
    });
    assert_eq!(traces, [alone.clone(), alone]);
}

/// Runs in a separate process, so that an abort is visible and the temporary folder has no other files.
#[test]
fn dropping_a_run_neither_aborts_nor_leaves_files() {
    let temporary = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap());
    for variable in ["TMPDIR", "TMP", "TEMP"] {
        child.env(variable, temporary.path());
    }
    let output = child.args(["--exact", "drop_runs", "--ignored"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
    let left: Vec<_> = std::fs::read_dir(temporary.path()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
#[ignore = "run by dropping_a_run_neither_aborts_nor_leaves_files"]
fn drop_runs() {
    let office = Office::new();
    let files = || std::fs::read_dir(std::env::temp_dir()).unwrap().count();
    let before = files();
    for stop_at in [Event::Started, Event::WarmedUp, Event::Step] {
        let (mut simulation, _) = office.start();
        while stop_at != Event::Started && simulation.advance().unwrap() != Some(stop_at) {}
        assert!(files() > before);
        drop(simulation);
        assert_eq!(files(), before, "dropped at {stop_at:?}");
    }
}
