//! A run recorded by `b2b run`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_base::seal;
use b2b_building::{Controls, RunPeriod};
use b2b_env::{HeatingOnlyZones, Task};
use serde::Deserialize;
use serde_json::Value;

use crate::run::operation::asked;
use crate::run::summary::Summary;
use crate::run::trajectory_file::{self, Stored};

/// Name of the model's hash.
const MODEL: &str = "model (SHA-256)";

/// A run: its summary and its trajectory.
pub struct Recorded {
    /// Name on the page and in the tables.
    pub name: String,
    /// Output folder.
    pub folder: PathBuf,
    pub described: Described,
    pub period: RunPeriod,
    pub zones: Vec<ZoneRecord>,
    /// Outdoor air temperature at the end of each step, °C.
    pub outdoor: Vec<f64>,
    /// HVAC electricity and non-electric HVAC energy of each step, Wh/m².
    pub energy: [Vec<f64>; 2],
}

/// The part of `summary.json` that a comparison needs.
#[derive(Deserialize)]
pub struct Described {
    pub building: String,
    pub place: String,
    pub controller: String,
    #[serde(default)]
    pub seed: u64,
    pub period: String,
    pub steps_per_hour: u32,
    pub task: String,
    task_hash: String,
    pub task_definition: Task,
    /// Currency of the costs of a task with bands, if it is known.
    pub currency: Option<String>,
    model_sha256: Option<String>,
    weather_sha256: Option<String>,
    trajectory_hash: String,
    zones: Vec<DescribedZone>,
    /// The metrics, and everything else.
    #[serde(flatten)]
    rest: BTreeMap<String, Value>,
}

#[derive(Deserialize)]
struct DescribedZone {
    name: String,
    rms_deviation_k: f64,
    #[serde(default)]
    discomfort_k_h: f64,
    heating_and_cooling: bool,
}

/// Temperatures of a controlled zone.
pub struct ZoneRecord {
    pub name: String,
    /// RMS deviation from target, K; in a task with bands, discomfort, K·h.
    pub deviation_metric: f64,
    /// Whether temperatures above target count as deviations.
    penalize_above_target: bool,
    /// At the end of each step, °C.
    pub temperature: Vec<f64>,
    /// For the next step, °C, if it varies.
    pub target: Option<Vec<f64>>,
    /// In a task with bands.
    pub band: Option<BandRecord>,
}

/// The comfort band of a zone in each step.
pub struct BandRecord {
    /// °C.
    pub heating: Vec<f64>,
    /// °C; `None` without cooling.
    pub cooling: Option<Vec<f64>>,
    /// Whether people are present.
    pub occupancy: Vec<f64>,
}

impl Recorded {
    /// Reads a run from its output folder or from the trajectory in it.
    pub fn read(path: &Path) -> Result<Self> {
        if !path.exists() {
            bail!("there is no run at {}; give an output folder of `b2b run`", path.display());
        }
        let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new(".")) };
        let file = if path.is_dir() { path.join(trajectory_file::NAME) } else { path.to_owned() };
        if !file.exists() {
            bail!(
                "{} has no {}; give an output folder of `b2b run`",
                folder.display(),
                trajectory_file::NAME
            );
        }
        let described = Described::read(&folder.join(Summary::NAME))?;
        let stored = Stored::read(&file)?;
        if stored.word("trajectory_hash")? != described.trajectory_hash {
            bail!(
                "{} and {} in {} are of different runs; run the episode again",
                trajectory_file::NAME,
                Summary::NAME,
                folder.display()
            );
        }
        let whole = || format!("{} lacks observations of its zones", file.display());
        let period: RunPeriod = described.period.parse()?;
        let period = period.in_calendar(stored.calendar());
        let zones = described.zones.iter().map(|zone| ZoneRecord::of(zone, &described, &stored));
        let zones = zones.collect::<Option<Vec<_>>>().with_context(whole)?;
        let observed = |name: &str| stored.observed(name).with_context(whole);
        Ok(Self {
            name: described.controller.clone(),
            folder: folder.to_owned(),
            period,
            zones,
            outdoor: observed("outdoor air temperature")?,
            energy: [
                observed("HVAC electricity")?,
                observed("HVAC non-electric").or_else(|_| observed("HVAC gas"))?,
            ],
            described,
        })
    }

    /// Returns the value of a column of the metrics.
    pub fn metric(&self, column: &str) -> Option<f64> {
        self.described.rest.get(column)?.as_f64()
    }

    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.outdoor.len()
    }

    /// Returns the title of a comparison: the episode and the number of runs.
    pub fn title(&self, runs: usize) -> String {
        let Described { building, place, period, task, steps_per_hour, .. } = &self.described;
        let minutes = 60 / steps_per_hour;
        format!(
            "{building} in {place}, {period}, task {task}: {runs} runs of {} steps of {minutes} min",
            self.steps()
        )
    }

    /// Returns whether the recorded temperatures have sensor errors, which the metrics do not have.
    pub fn has_faulty_sensors(&self) -> bool {
        let faults = &self.described.task_definition.faults;
        faults.noise > 0.0 || faults.bias > 0.0
    }

    /// Returns the target of all zones if it is constant, °C.
    pub fn constant_target(&self) -> Option<f64> {
        self.described.task_definition.setpoints.constant_target()
    }
}

impl Described {
    fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read(path)
            .with_context(|| format!("cannot read {}, which `b2b run` writes", path.display()))?;
        if seal::is_intact(&text, Summary::SEAL) == Some(false) {
            bail!(
                "{} was changed: it does not have the hash that it states; run the episode again",
                path.display()
            );
        }
        serde_json::from_slice(&text)
            .with_context(|| format!("{} is not a summary written by `b2b run`", path.display()))
    }

    /// Returns who controlled the building.
    fn controls(&self) -> Controls {
        b2b_control::kind(&self.controller).map_or(Controls::Actuators, |kind| kind.controls())
    }

    /// Returns the properties that identify the episode: name, value, and value in messages.
    fn identity(&self) -> [(&'static str, String, String); 7] {
        let plain = |name, value: &str| (name, value.to_owned(), value.to_owned());
        let hash = |name, hash: &Option<String>| {
            let hash = hash.clone().unwrap_or_default();
            let short = hash.chars().take(12).collect();
            (name, hash, short)
        };
        [
            plain("building", &self.building),
            plain("place", &self.place),
            plain("run period", &self.period),
            plain("number of steps per hour", &self.steps_per_hour.to_string()),
            ("task", self.task_hash.clone(), self.task.clone()),
            hash(MODEL, &self.model_sha256),
            hash("weather (SHA-256)", &self.weather_sha256),
        ]
    }
}

impl ZoneRecord {
    fn of(zone: &DescribedZone, described: &Described, stored: &Stored) -> Option<Self> {
        let band = BandRecord::of(&zone.name, stored).filter(|_| described.task_definition.is_operation());
        let both_sides = described.task_definition.heating_only_zones == HeatingOnlyZones::BothSides;
        Some(Self {
            name: zone.name.clone(),
            deviation_metric: if band.is_some() { zone.discomfort_k_h } else { zone.rms_deviation_k },
            penalize_above_target: zone.heating_and_cooling || both_sides,
            temperature: stored.observed(&format!("{} air temperature", zone.name))?,
            target: stored.observed(&format!("{} target", zone.name)),
            band,
        })
    }

    /// Returns the target of a step, °C; in a task with bands, the temperature in the band nearest to the zone's. The
    /// first step's target is not recorded, so the second step's is used.
    pub fn target_of(&self, step: usize, constant: Option<f64>) -> f64 {
        match (&self.band, &self.target) {
            (Some(band), _) => band.nearest(step, self.temperature[step]),
            (None, Some(targets)) => targets[step.saturating_sub(1)],
            (None, None) => constant.unwrap_or(f64::NAN),
        }
    }

    /// Returns the rewarded deviation from target in a step, K: 0 above target where that is not penalized.
    pub fn deviation(&self, step: usize, constant: Option<f64>) -> f64 {
        let deviation = self.temperature[step] - self.target_of(step, constant);
        if self.penalize_above_target { deviation } else { deviation.min(0.0) }
    }
}

impl BandRecord {
    fn of(zone: &str, stored: &Stored) -> Option<Self> {
        let asked = |word: &str| stored.observed(&format!("{zone} {word}")).map(asked);
        Some(Self {
            heating: asked("band heating setpoint")?,
            cooling: asked("band cooling setpoint"),
            occupancy: asked("occupancy")?,
        })
    }

    /// Returns the temperature in the band that is nearest to one, °C.
    fn nearest(&self, step: usize, temperature: f64) -> f64 {
        let above = temperature.max(self.heating[step]);
        self.cooling.as_ref().map_or(above, |cooling| above.min(cooling[step]))
    }
}

/// Errors unless all runs are of the same episode. The model may differ between a building under its own controls and
/// the same building with actuators.
pub fn check_same(runs: &[Recorded]) -> Result<()> {
    let Some((first, others)) = runs.split_first() else { return Ok(()) };
    for other in others {
        let pairs = first.described.identity().into_iter().zip(other.described.identity());
        let same_controls = first.described.controls() == other.described.controls();
        for ((what, ours, ours_text), (_, theirs, theirs_text)) in pairs {
            if ours != theirs && (same_controls || what != MODEL) {
                bail!(
                    "the runs differ in their {what}: {ours_text} in {}, {theirs_text} in {}; compare runs of one \
                     building, period and task",
                    first.folder.display(),
                    other.folder.display()
                );
            }
        }
        if first.steps() != other.steps() {
            bail!(
                "{} has {} steps and {} has {}; compare complete runs",
                first.folder.display(),
                first.steps(),
                other.folder.display(),
                other.steps()
            );
        }
    }
    Ok(())
}

/// Names the runs: as given, or after their controllers, with seeds or folders where these are equal.
pub fn set_names(runs: &mut [Recorded], given: &[String]) {
    if !given.is_empty() {
        runs.iter_mut().zip(given).for_each(|(run, name)| run.name.clone_from(name));
        return;
    }
    let forms: [fn(&Recorded) -> String; 3] = [
        |run| run.described.controller.clone(),
        |run| format!("{}, seed {}", run.described.controller, run.described.seed),
        |run| {
            let name = run.folder.canonicalize().ok();
            let name = name.as_deref().and_then(Path::file_name).map(|name| name.display().to_string());
            name.unwrap_or_else(|| run.folder.display().to_string())
        },
    ];
    let distinct = |names: &[String]| {
        let mut sorted = names.to_vec();
        sorted.sort();
        sorted.dedup();
        sorted.len() == names.len()
    };
    let mut named = forms.iter().map(|form| runs.iter().map(form).collect::<Vec<_>>());
    let fallback = || runs.iter().map(|run| run.folder.display().to_string()).collect();
    let names = named.find(|names| distinct(names)).unwrap_or_else(fallback);
    runs.iter_mut().zip(names).for_each(|(run, name)| run.name = name);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temperature_in_its_band_does_not_deviate() {
        let band = |cooling| BandRecord { heating: vec![21.0], cooling, occupancy: vec![1.0] };
        let zone = |temperature, cooling| ZoneRecord {
            name: "Core".into(),
            deviation_metric: 0.0,
            penalize_above_target: true,
            temperature: vec![temperature],
            target: None,
            band: Some(band(cooling)),
        };
        let deviation = |temperature| zone(temperature, Some(vec![24.0])).deviation(0, None);
        assert_eq!([20.0, 22.0, 25.5].map(deviation), [-1.0, 0.0, 1.5]);
        assert_eq!(zone(30.0, None).deviation(0, None), 0.0);
    }
}
