//! What the reactive controllers get: shipped for the small test, cached for whatever else was asked for once.
//!
//! What they do depends neither on the weight of energy nor on its scale, and comfort and energy are summed apart: one
//! episode gives the return for every weight.

use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use b2b_building::Class;
use b2b_control::ReactiveParameters;
use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::install::{ENGINE_VERSION, cache_dir};
use b2b_env::{Metrics, Resource, Task};
use serde::{Deserialize, Serialize};

use crate::error::at;
use crate::evaluation::{Episode, Evaluation, Outcome, Progress};
use crate::subject::hex;
use crate::{BuiltIn, Error, Result, Subject, Surroundings};

/// Raised when a change to preparation, environments or controllers changes what the reactive controllers get, so that
/// nothing that was cached before is taken for it.
const REVISION: u32 = 3;

/// The shipped baselines: `b2b baseline` writes them.
const SHIPPED: &str = include_str!("../data/baselines.csv");

/// Parameters of the reactive controllers of a building: those of its type and climate zone.
pub fn controller_parameters(subject: &Subject, surroundings: &Surroundings) -> ReactiveParameters {
    let prototype = subject.placement.is_prototype(&subject.name);
    ReactiveParameters::tuned(subject.class(surroundings), prototype)
}

/// A task as a building is judged by it: its energy scale τ_E is that of the building's type and climate zone.
pub fn task_for(subject: &Subject, surroundings: &Surroundings, task: &Task, steps_per_hour: u32) -> Task {
    let scale = task.scale_for(subject.class(surroundings), steps_per_hour);
    Task { energy_scale: Some(scale), ..task.clone() }
}

/// One hash of the parameters of all reactive controllers.
pub(crate) fn controllers_hash() -> String {
    let classes = Class::all().map(Some).chain([None]);
    let all: String = classes.map(|class| hash(&ReactiveParameters::tuned(class, false))).collect();
    short(&hex(all.as_bytes()))
}

fn hash(parameters: &ReactiveParameters) -> String {
    short(&hex(parameters.fingerprint().as_bytes()))
}

fn short(hash: &str) -> String {
    hash[..16].to_owned()
}

/// What a return for any weight of energy is made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Terms {
    /// Sum of the temperature penalties, K².
    pub temperature_penalty: f64,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Its cost, currency/m².
    pub cost: f64,
    /// Its emissions, g of CO₂/m².
    pub emissions: f64,
    /// Highest electric HVAC power, W/m².
    pub peak: f64,
}

impl Terms {
    /// The terms of an episode.
    pub fn of(metrics: &Metrics) -> Self {
        Self {
            temperature_penalty: metrics.temperature_penalty,
            energy: metrics.electricity + metrics.gas,
            cost: metrics.cost,
            emissions: metrics.emissions,
            peak: metrics.peak_electricity,
        }
    }

    /// The return under a task's weight and scale: see [`task_for`].
    pub fn episode_return(&self, task: &Task) -> f64 {
        let used = match task.resource {
            Resource::Energy => self.energy,
            Resource::Cost => self.cost,
            Resource::Carbon => self.emissions,
            Resource::Peak => self.peak,
        };
        -self.temperature_penalty - task.energy_weight / task.energy_scale.unwrap_or(1.0) * used
    }

    /// All of them, in order.
    pub fn values(&self) -> [f64; 5] {
        [self.temperature_penalty, self.energy, self.cost, self.emissions, self.peak]
    }
}

/// All that a baseline depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// What the building is a function of: [`Subject::identity`].
    pub building: String,
    /// The task but for what it saves: spelling, with a hash where it has none.
    pub task: String,
    /// Run period.
    pub period: String,
    /// Zone time steps an hour.
    pub steps_per_hour: u32,
    /// Version of the buildings.
    pub generator: String,
    /// Version of EnergyPlus.
    pub engine: String,
    /// Hash of the controllers' parameters.
    pub controller: String,
    /// Changes to preparation, environments and controllers.
    pub revision: u32,
}

impl Key {
    /// The key of an episode of a building in some surroundings.
    ///
    /// # Errors
    /// [`Error::Io`] for a file of the user's own that cannot be read.
    pub fn of(episode: &Episode, surroundings: &Surroundings) -> Result<Self> {
        Ok(Self {
            building: episode.subject.identity()?,
            task: bare(&episode.task).to_string(),
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            generator: GENERATOR_VERSION.to_owned(),
            engine: ENGINE_VERSION.to_owned(),
            controller: hash(&controller_parameters(&episode.subject, surroundings)),
            revision: REVISION,
        })
    }

    fn file(&self) -> String {
        let text = serde_json::to_string(self).expect("it is plain data");
        format!("{}.json", &hex(text.as_bytes())[..32])
    }
}

/// A task without what the reactive controllers do not look at.
fn bare(task: &Task) -> Task {
    let Task { energy_weight, energy_scale, resource, comfort_band, .. } = Task::default();
    Task { energy_weight, energy_scale, resource, comfort_band, ..task.clone() }
}

/// A baseline on disk.
#[derive(Serialize, Deserialize)]
struct Cached {
    key: Key,
    terms: Terms,
}

/// What is known of the baselines.
#[derive(Debug)]
pub struct Baselines {
    shipped: HashMap<Key, Terms>,
    folder: PathBuf,
}

impl Baselines {
    /// Those shipped, and those in the user's cache folder.
    ///
    /// # Errors
    /// [`Error::Install`] when no home folder is known.
    pub fn open() -> Result<Self> {
        Ok(Self::in_folder(&cache_dir()?.join("baselines")))
    }

    /// Those shipped, and those in a folder.
    pub fn in_folder(folder: &Path) -> Self {
        let shipped = table::read(SHIPPED).expect("a test reads it");
        Self { shipped: shipped.into_iter().collect(), folder: folder.to_owned() }
    }

    /// Those in a folder alone: to compute again what is shipped.
    pub fn without_shipped(folder: &Path) -> Self {
        Self { shipped: HashMap::new(), folder: folder.to_owned() }
    }

    /// Baselines that are shipped.
    pub fn shipped(&self) -> impl Iterator<Item = (&Key, &Terms)> {
        self.shipped.iter()
    }

    /// A baseline, if it is known.
    pub fn get(&self, key: &Key) -> Option<Terms> {
        if let Some(terms) = self.shipped.get(key) {
            return Some(*terms);
        }
        let text = std::fs::read(self.folder.join(key.file())).ok()?;
        // What cannot be read is computed again.
        let cached: Cached = serde_json::from_slice(&text).ok()?;
        (cached.key == *key).then_some(cached.terms)
    }

    /// Keeps a baseline in the cache.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, key: &Key, terms: Terms) -> Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(at(&self.folder))?;
        let text = serde_json::to_vec_pretty(&Cached { key: key.clone(), terms }).expect("it is plain data");
        // Another process may keep the same.
        let aside = tempfile::NamedTempFile::new_in(&self.folder).map_err(at(&self.folder))?;
        aside.as_file().write_all(&text).map_err(at(aside.path()))?;
        let path = self.folder.join(key.file());
        aside.persist(&path).map_err(|error| at(&path)(error.error))?;
        Ok(())
    }

    /// Computes the baselines of episodes that are not known, and keeps them. Gives the reasons where that is not
    /// possible, by the key.
    ///
    /// # Errors
    /// [`Error::Interrupted`]; [`Error::Io`].
    pub fn compute(
        &self,
        evaluation: &Evaluation<'_>,
        episodes: &[(Key, Episode)],
        progress: &dyn Progress,
    ) -> Result<HashMap<Key, String>> {
        let days = episodes.iter().map(|(_, episode)| episode.days()).sum();
        progress.begin("baselines", episodes.len(), days);
        let lost = std::sync::Mutex::new(HashMap::new());
        let numbered: Vec<_> = episodes.iter().map(|(_, episode)| episode).enumerate().collect();
        evaluation.run(&numbered, &BuiltIn::Reactive, progress, &|number, outcome| {
            let key = &episodes[number].0;
            match outcome {
                Outcome::Finished(finished) => return self.keep(key, finished.terms),
                Outcome::Lost(why) => {
                    lost.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(key.clone(), why)
                }
            };
            Ok(())
        })?;
        Ok(lost.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// Those of some episodes that are not known, once each and without what is saved, in their order.
    pub fn missing(&self, episodes: impl IntoIterator<Item = (Key, Episode)>) -> Vec<(Key, Episode)> {
        let mut seen = std::collections::HashSet::new();
        let unknown =
            episodes.into_iter().filter(|(key, _)| seen.insert(key.clone()) && self.get(key).is_none());
        unknown
            .map(|(key, episode)| (key, Episode { task: bare(&episode.task), seed: 0, ..episode }))
            .collect()
    }

    /// The return of the reactive controllers for an episode's building, task and days, run now if it is not known.
    ///
    /// # Errors
    /// [`Error::NoBaseline`] when they cannot be run; [`Error::Interrupted`]; [`Error::Io`].
    pub fn episode_return(
        &self,
        evaluation: &Evaluation<'_>,
        episode: &Episode,
        surroundings: &Surroundings,
        progress: &dyn Progress,
    ) -> Result<f64> {
        let Episode { subject, task, period, steps_per_hour, .. } = episode;
        let key = Key::of(episode, surroundings)?;
        let missing = self.missing([(key.clone(), episode.clone())]);
        let mut lost = match &missing[..] {
            [] => HashMap::new(),
            missing => self.compute(evaluation, missing, progress)?,
        };
        let terms = self.get(&key).ok_or_else(|| Error::NoBaseline {
            building: subject.name.to_string(),
            task: task.to_string(),
            period: period.to_string(),
            why: lost.remove(&key).unwrap_or_default(),
        })?;
        Ok(terms.episode_return(&task_for(subject, surroundings, task, *steps_per_hour)))
    }
}

/// The table of shipped baselines.
pub mod table {
    use std::fmt::Write;

    use super::{Key, Terms};

    const HEADER: &str = "building,task,period,steps_per_hour,generator,engine,controller,revision,\
                          temperature_penalty,energy_wh_m2,cost_m2,emissions_g_m2,peak_w_m2";

    /// As text: numbers in the shortest form that reads back the same.
    pub fn text(rows: &[(Key, Terms)]) -> String {
        let mut text = format!("{HEADER}\n");
        for (key, terms) in rows {
            let Key { building, task, period, steps_per_hour, generator, engine, controller, revision } = key;
            let Terms { temperature_penalty, energy, cost, emissions, peak } = terms;
            write!(
                text,
                "{building},{task},{period},{steps_per_hour},{generator},{engine},{controller},{revision},"
            )
            .and_then(|()| writeln!(text, "{temperature_penalty},{energy},{cost},{emissions},{peak}"))
            .expect("a string takes everything");
        }
        text
    }

    /// Reads it; `None` when it is no such table.
    pub fn read(text: &str) -> Option<Vec<(Key, Terms)>> {
        let mut lines = text.lines();
        if lines.next() != Some(HEADER) {
            return None;
        }
        lines.map(row).collect()
    }

    fn row(line: &str) -> Option<(Key, Terms)> {
        let cells: Vec<&str> = line.split(',').collect();
        let [
            building,
            task,
            period,
            steps_per_hour,
            generator,
            engine,
            controller,
            revision,
            temperature,
            energy,
            cost,
            emissions,
            peak,
        ] = cells[..]
        else {
            return None;
        };
        let key = Key {
            building: building.into(),
            task: task.into(),
            period: period.into(),
            steps_per_hour: steps_per_hour.parse().ok()?,
            generator: generator.into(),
            engine: engine.into(),
            controller: controller.into(),
            revision: revision.parse().ok()?,
        };
        let terms = Terms {
            temperature_penalty: temperature.parse().ok()?,
            energy: energy.parse().ok()?,
            cost: cost.parse().ok()?,
            emissions: emissions.parse().ok()?,
            peak: peak.parse().ok()?,
        };
        Some((key, terms))
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::RunPeriod;

    use super::*;

    fn episode(task: &str) -> Episode {
        Episode {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: task.parse().unwrap(),
            period: RunPeriod::WINTER,
            seed: 0,
            steps_per_hour: 12,
        }
    }

    fn key(task: &str) -> Key {
        let surroundings = Surroundings { place: "Denver".into(), climate_zone: "5B".into() };
        Key::of(&episode(task), &surroundings).unwrap()
    }

    const TERMS: Terms = Terms {
        temperature_penalty: 614.725_113_2,
        energy: 11_620.1 + 0.2,
        cost: 1.37,
        emissions: 4120.0,
        peak: 13.9,
    };

    #[test]
    fn one_episode_gives_the_return_for_every_weight_of_every_resource() {
        let of = |text: &str| TERMS.episode_return(&text.parse().unwrap());
        assert_eq!(of("constant"), -TERMS.temperature_penalty);
        assert_eq!(of("constant+energy0.5"), -TERMS.temperature_penalty - 0.5 * TERMS.energy);
        assert_eq!(of("constant+cost2"), -TERMS.temperature_penalty - 2.0 * TERMS.cost);
        let scaled = Task { energy_scale: Some(0.25), ..episode("constant+energy0.5").task };
        assert_eq!(TERMS.episode_return(&scaled), -TERMS.temperature_penalty - 2.0 * TERMS.energy);
        assert_eq!(key("occupancy"), key("occupancy+energy0.5"));
        assert_ne!(key("occupancy"), key("constant"));
        assert_ne!(key("constant+deadband"), key("constant"), "comfort is judged otherwise");
        assert_ne!(key("random:1"), key("random:2"));
    }

    #[test]
    fn what_is_kept_is_found_again_by_its_whole_key() {
        let folder = tempfile::tempdir().unwrap();
        let baselines = Baselines::without_shipped(folder.path());
        let missing = baselines.missing([
            (key("constant"), episode("constant")),
            (key("constant+energy0.5"), episode("constant+energy0.5")),
        ]);
        assert_eq!(missing.len(), 1, "both weights are one episode");
        baselines.keep(&key("constant"), TERMS).unwrap();
        assert_eq!(baselines.get(&key("constant")), Some(TERMS));
        assert_eq!(baselines.get(&Key { revision: REVISION + 1, ..key("constant") }), None);
        assert_eq!(baselines.missing([(key("constant"), episode("constant"))]), []);
        // A file that was cut short is no baseline.
        let file = folder.path().join(key("constant").file());
        std::fs::write(&file, &std::fs::read(&file).unwrap()[..40]).unwrap();
        assert_eq!(baselines.get(&key("constant")), None);
    }

    #[test]
    fn the_shipped_table_reads_back_as_it_is_and_is_of_these_controllers() {
        let rows = table::read(SHIPPED).unwrap();
        assert_eq!(table::text(&rows), SHIPPED);
        for (key, terms) in &rows {
            assert_eq!((key.generator.as_str(), key.engine.as_str()), (GENERATOR_VERSION, ENGINE_VERSION));
            assert_eq!(key.revision, REVISION);
            assert!(terms.temperature_penalty >= 0.0 && terms.energy > 0.0, "{key:?}");
        }
        let one = vec![(key("constant"), TERMS)];
        assert_eq!(table::read(&table::text(&one)), Some(one));
    }
}
