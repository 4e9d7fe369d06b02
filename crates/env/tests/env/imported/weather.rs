//! Weather files as people have them: the forecast has the temperatures that the engine simulates.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::case::Case;
use b2b_building::BuildingType;
use b2b_env::{Env, EpisodeConfig};

const MARK: &str = "\u{feff}";

/// The header and the rows of Denver's weather file.
struct File {
    header: Vec<String>,
    rows: Vec<String>,
}

impl File {
    fn of(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let mut lines = text.lines().map(str::to_owned);
        Self { header: lines.by_ref().take(8).collect(), rows: lines.collect() }
    }

    /// Replaces the header line that begins with a title.
    fn with_header(mut self, title: &str, line: &str) -> Self {
        let found = self.header.iter_mut().find(|header| header.starts_with(title)).unwrap();
        line.clone_into(found);
        self
    }

    fn write(&self, folder: &Path, name: &str, before: &str) -> PathBuf {
        let path = folder.join(name);
        let text = [self.header.join("\n"), self.rows.join("\n")].join("\n");
        std::fs::write(&path, format!("{before}{text}\n")).unwrap();
        path
    }
}

/// Returns a row with another value in a column.
fn with(row: &str, column: usize, value: &str) -> String {
    let mut columns: Vec<&str> = row.split(',').collect();
    columns[column] = value;
    columns.join(",")
}

/// Returns four rows an hour, which approach its temperature from a kelvin below.
fn quarters(row: &str) -> impl Iterator<Item = String> {
    let dry_bulb: f64 = row.split(',').nth(6).unwrap().parse().unwrap();
    let row = row.to_owned();
    (1..=4).map(move |quarter| {
        let value = format!("{:.2}", dry_bulb - 1.0 + f64::from(quarter) / 4.0);
        with(&with(&row, 4, &(15 * quarter).to_string()), 6, &value)
    })
}

fn env(case: &Case, weather: &Path, period: &str, steps_per_hour: u32) -> b2b_env::Result<Env> {
    let (weather, period) = (weather.to_owned(), period.parse().unwrap());
    let episode = EpisodeConfig { weather, period, steps_per_hour, task: "operate+preview".parse().unwrap() };
    Env::new(case.library.clone(), Arc::clone(&case.building), episode)
}

/// Runs a day and returns its outdoor temperature at the end of every hour as it was forecast at the beginning and as
/// it was observed.
fn forecast_and_observed(case: &Case, weather: &Path, period: &str, steps_per_hour: u32) -> [Vec<f64>; 2] {
    let mut env = env(case, weather, period, steps_per_hour).unwrap();
    let slots = env.observation_space().slots();
    let slot = |name: &str| slots.iter().position(|slot| slot.name.starts_with(name)).unwrap();
    let (outdoor, preview) = (slot("outdoor air temperature"), slot("outdoor temperature "));
    let forecast = env.reset().unwrap()[preview..preview + 24].to_vec();
    let action = env.action_space().low().to_vec();
    let observed = (0..24).map(|_| {
        (0..steps_per_hour).for_each(|_| _ = env.step(&action).unwrap());
        env.observation()[outdoor]
    });
    let observed = observed.collect();
    [forecast, observed]
}

#[test]
fn the_forecast_of_any_weather_file_is_what_the_engine_simulates() {
    let case = Case::at_home(BuildingType::Warehouse);
    let folder = tempfile::tempdir().unwrap();
    let original = || File::of(&case.weather);
    let plain = forecast_and_observed(&case, &case.weather, "01-02..01-02", 1);

    let mut turned = original().with_header("DATA PERIODS", "DATA PERIODS,1,1,Data,Sunday, 7/ 1, 6/30");
    turned.rows.rotate_left(181 * 24);
    let turned = turned.write(folder.path(), "july.epw", "");

    let mut january = original()
        .with_header("DATA PERIODS", "DATA PERIODS,1,1,Data,Sunday, 1/ 1, 1/31")
        .with_header("GROUND TEMPERATURES", "GROUND TEMPERATURES,0");
    january.rows.truncate(31 * 24);
    let january = january.write(folder.path(), "january.epw", MARK);
    for weather in [&turned, &january] {
        assert_eq!(forecast_and_observed(&case, weather, "01-02..01-02", 1), plain, "{}", weather.display());
    }
    let error = env(&case, &january, "01-30..02-02", 1).unwrap_err().to_string();
    assert!(error.contains("02-01") && error.contains("01-01..01-31"), "{error}");

    let mut missing = original();
    for hour in [24 + 7, 24 + 8] {
        missing.rows[hour] = with(&missing.rows[hour], 6, "99.9");
    }
    let missing = missing.write(folder.path(), "missing.epw", "");
    let [forecast, observed] = forecast_and_observed(&case, &missing, "01-02..01-02", 1);
    assert_eq!(observed[6..9], [plain[1][6]; 3], "a missing temperature is the last before it");
    assert_eq!(forecast, observed);

    let mut quarterly = original().with_header("DATA PERIODS", "DATA PERIODS,1,4,Data,Sunday, 1/ 1,12/31");
    quarterly.rows = quarterly.rows.iter().flat_map(|row| quarters(row)).collect();
    let quarterly = quarterly.write(folder.path(), "quarterly.epw", "");
    let [forecast, observed] = forecast_and_observed(&case, &quarterly, "01-02..01-02", 4);
    assert_eq!(forecast, plain[0]);
    assert!(forecast.iter().zip(&observed).all(|(a, b)| (a - b).abs() < 1e-9), "{forecast:?} {observed:?}");
    let error = env(&case, &quarterly, "01-02..01-02", 12).unwrap_err().to_string();
    assert!(error.contains("4 rows an hour") && error.contains("4 steps per hour"), "{error}");
}
