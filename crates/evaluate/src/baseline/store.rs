//! Known baselines, and the computation of unknown ones.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use b2b_base::aside::write_whole;
use b2b_energyplus::install::{cache_dir, seal, unseal};
use b2b_env::Resource;
use serde::{Deserialize, Serialize};

use super::key::{Key, baseline_task};
use super::table;
use crate::error::at;
use crate::evaluation::{EpisodePlan, Evaluation, Lost, Outcome, Progress};
use crate::return_terms::ReturnTerms;
use crate::scores::Baseline;
use crate::tuned::task_for;
use crate::{BuiltIn, Error, Result, SiteInfo};

/// The shipped baselines of the tracking tasks and of operation: `b2b baseline` writes them.
const SHIPPED: [&str; 2] =
    [include_str!("../../data/baselines.csv"), include_str!("../../data/baselines_operation.csv")];

/// A baseline on disk.
#[derive(Serialize, Deserialize)]
struct Cached {
    key: Key,
    terms: ReturnTerms,
}

/// The known baselines: shipped ones, and a folder of cached ones.
#[derive(Debug)]
pub struct Baselines {
    shipped: HashMap<Key, ReturnTerms>,
    /// Baselines that could not be written to the folder.
    unwritten: Mutex<HashMap<Key, ReturnTerms>>,
    folder: PathBuf,
}

impl Baselines {
    /// Opens the shipped baselines and the user's cache folder.
    ///
    /// # Errors
    /// [`Error::Install`] if the home folder is unknown.
    pub fn open() -> Result<Self> {
        Ok(Self::in_folder(&Self::folder_in(&cache_dir()?)))
    }

    /// Returns the folder of baselines in a cache; its number changes with the format of the files.
    pub fn folder_in(cache: &Path) -> PathBuf {
        cache.join("baselines-1")
    }

    /// Opens the shipped baselines and a folder of cached ones.
    pub fn in_folder(folder: &Path) -> Self {
        let tables = SHIPPED.map(|text| table::read(text).expect("a test reads the shipped tables"));
        Self { shipped: tables.into_iter().flatten().collect(), ..Self::without_shipped(folder) }
    }

    /// Opens the baselines in a folder without the shipped ones, in order to recompute them.
    pub fn without_shipped(folder: &Path) -> Self {
        Self { shipped: HashMap::new(), unwritten: Mutex::default(), folder: folder.to_owned() }
    }

    /// Returns the shipped baselines.
    pub fn shipped(&self) -> impl Iterator<Item = (&Key, &ReturnTerms)> {
        self.shipped.iter()
    }

    /// Returns a baseline, if it is known together with its resource.
    pub fn get(&self, key: &Key, resource: Resource) -> Option<ReturnTerms> {
        let has_resource = |terms: &ReturnTerms| terms.used(resource).is_some();
        if let Some(terms) = self.shipped.get(key).filter(|terms| has_resource(terms)) {
            return Some(*terms);
        }
        if let Some(terms) = self.unwritten.lock().unwrap_or_else(PoisonError::into_inner).get(key) {
            return Some(*terms);
        }
        let file = std::fs::read(self.folder.join(key.file_name())).ok()?;
        // A baseline is computed again if its file is unreadable or was changed.
        let cached: Cached = serde_json::from_slice(unseal(&file)?).ok()?;
        Some(cached.terms).filter(|terms| cached.key == *key && has_resource(terms))
    }

    /// Writes a baseline to the cache.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, key: &Key, terms: ReturnTerms) -> Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(at(&self.folder))?;
        let text = serde_json::to_vec_pretty(&Cached { key: key.clone(), terms })
            .expect("plain data always serializes");
        // Another process may write the same file.
        let path = self.folder.join(key.file_name());
        write_whole(&path, &seal(&text)).map_err(at(&path))
    }

    /// Writes a baseline to the cache, or remembers it if the cache cannot be written, which only costs time later.
    pub(crate) fn remember(&self, key: &Key, terms: ReturnTerms) {
        if self.keep(key, terms).is_err() {
            self.unwritten.lock().unwrap_or_else(PoisonError::into_inner).insert(key.clone(), terms);
        }
    }

    /// Computes baselines and caches them. Returns the lost episodes by their keys.
    ///
    /// # Errors
    /// [`Error::Interrupted`]; [`Error::Io`].
    pub fn compute(
        &self,
        evaluation: &Evaluation<'_>,
        episodes: &[(Key, EpisodePlan)],
        progress: &dyn Progress,
    ) -> Result<HashMap<Key, Lost>> {
        let days = episodes.iter().map(|(_, episode)| episode.days()).sum();
        progress.begin("baselines", episodes.len(), days);
        let lost = Mutex::new(HashMap::new());
        let keep = |number: usize, outcome: Outcome| {
            let key = &episodes[number].0;
            match outcome {
                Ok(finished) => self.remember(key, finished.terms),
                Err(why) => {
                    lost.lock().unwrap_or_else(PoisonError::into_inner).insert(key.clone(), why);
                }
            }
            Ok(())
        };
        for policy in BuiltIn::baselines() {
            let is_own = |(_, episode): &(usize, &EpisodePlan)| BuiltIn::baseline_of(&episode.task) == policy;
            let numbered = episodes.iter().map(|(_, episode)| episode).enumerate().filter(is_own);
            evaluation.run(&numbered.collect::<Vec<_>>(), &policy, progress, &keep)?;
        }
        Ok(lost.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns the episodes whose baselines are unknown, once each and with the energy term of their
    /// objective, in their order.
    pub fn missing(&self, episodes: impl IntoIterator<Item = (Key, EpisodePlan)>) -> Vec<(Key, EpisodePlan)> {
        let mut seen = HashSet::new();
        let unknown = episodes.into_iter().filter(|(key, episode)| {
            self.get(key, episode.task.resource).is_none() && seen.insert(key.clone())
        });
        unknown
            .map(|(key, episode)| {
                let task = baseline_task(&episode.task, key.objective);
                (key, EpisodePlan { task, seed: 0, ..episode })
            })
            .collect()
    }

    /// Returns the baseline of an episode's building, task and days, computed if unknown.
    ///
    /// # Errors
    /// Same as [`Baselines::of_all`].
    pub fn baseline(
        &self,
        evaluation: &Evaluation<'_>,
        episode: &EpisodePlan,
        site: &SiteInfo,
        progress: &dyn Progress,
    ) -> Result<Baseline> {
        Ok(self.of_all(evaluation, &[(episode.clone(), site.clone())], progress)?[0])
    }

    /// Returns the baselines of episodes at their sites. Unknown ones are computed in parallel.
    ///
    /// # Errors
    /// [`Error::NoBaseline`] if an episode of the baseline is lost; [`Error::Interrupted`]; [`Error::Io`].
    pub fn of_all(
        &self,
        evaluation: &Evaluation<'_>,
        episodes: &[(EpisodePlan, SiteInfo)],
        progress: &dyn Progress,
    ) -> Result<Vec<Baseline>> {
        let keys: Vec<Key> =
            episodes.iter().map(|(episode, site)| Key::of(episode, site)).collect::<Result<_>>()?;
        let keyed = keys.iter().zip(episodes).map(|(key, (episode, _))| (key.clone(), episode.clone()));
        let lost = match &self.missing(keyed)[..] {
            [] => HashMap::new(),
            missing => self.compute(evaluation, missing, progress)?,
        };
        let known = |(key, (episode, site)): (&Key, &(EpisodePlan, SiteInfo))| {
            let EpisodePlan { subject, task, period, steps_per_hour, .. } = episode;
            let terms = self.get(key, task.resource).ok_or_else(|| Error::NoBaseline {
                building: subject.label(),
                task: task.to_string(),
                period: period.to_string(),
                why: lost.get(key).map_or_else(String::new, |lost| lost.reason.clone()),
            })?;
            Ok(terms.baseline(&task_for(subject, site, task, *steps_per_hour)))
        };
        keys.iter().zip(episodes).map(known).collect()
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::Period;
    use b2b_dataset::GENERATOR_VERSION;
    use b2b_energyplus::install::ENGINE_VERSION;
    use b2b_env::Task;

    use super::super::key::REVISION;
    use super::*;
    use crate::Subject;

    fn episode(task: &str) -> EpisodePlan {
        EpisodePlan {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: task.parse().unwrap(),
            period: Period::WINTER,
            seed: 0,
            steps_per_hour: 12,
        }
    }

    fn key(task: &str) -> Key {
        let site = SiteInfo { place: "Denver".into(), climate_zone: "5B".into() };
        Key::of(&episode(task), &site).unwrap()
    }

    const TERMS: ReturnTerms = ReturnTerms {
        temperature_penalty: 614.725_113_2,
        used: [Some(11_620.1 + 0.2), Some(1.37), Some(4120.0), Some(13.9)],
        discomfort: None,
    };

    #[test]
    fn a_cache_that_cannot_be_written_is_not_needed() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let baselines = Baselines::in_folder(&file.path().join("cache"));
        assert!(baselines.keep(&key("constant"), TERMS).is_err());
        baselines.remember(&key("constant"), TERMS);
        assert_eq!(baselines.get(&key("constant"), Resource::ENERGY), Some(TERMS));
    }

    #[test]
    fn one_episode_gives_the_return_for_every_weight_of_every_resource() {
        let of = |text: &str| TERMS.episode_return(&text.parse().unwrap());
        let [energy, cost] =
            ["energy", "cost"].map(|word| TERMS.used(Resource::of_word(word).unwrap()).unwrap());
        assert_eq!(of("constant"), -TERMS.temperature_penalty);
        assert_eq!(of("constant+energy0.5"), -TERMS.temperature_penalty - 0.5 * energy);
        assert_eq!(of("constant+cost2"), -TERMS.temperature_penalty - 2.0 * cost);
        let scaled = Task { energy_scale: Some(0.25), ..episode("constant+energy0.5").task };
        assert_eq!(TERMS.episode_return(&scaled), -TERMS.temperature_penalty - 2.0 * energy);
        assert_eq!(key("occupancy+cost2"), key("occupancy+energy0.5"));
        assert_ne!(key("occupancy"), key("occupancy+energy0.5"), "each objective has its own parameters");
        assert_ne!(key("occupancy"), key("constant"));
        assert_ne!(key("constant+deadband"), key("constant"), "comfort is judged otherwise");
        assert_ne!(key("random:1"), key("random:2"));
        let [plain, priced] = ["operate", "operate+tou"].map(|task| key(task).controller);
        assert_ne!(plain, priced, "a corrected tariff is another baseline");
    }

    #[test]
    fn what_is_kept_is_found_again_by_its_whole_key() {
        let folder = tempfile::tempdir().unwrap();
        let baselines = Baselines::without_shipped(folder.path());
        let missing = baselines.missing([
            (key("constant+energy2"), episode("constant+energy2")),
            (key("constant+energy0.5"), episode("constant+energy0.5")),
        ]);
        assert_eq!(missing.len(), 1, "both weights are one episode");
        assert_eq!(missing[0].1.task.to_string(), "constant+energy0.5");
        baselines.keep(&key("constant"), TERMS).unwrap();
        assert_eq!(baselines.get(&key("constant"), Resource::ENERGY), Some(TERMS));
        assert_eq!(baselines.get(&Key { revision: REVISION + 1, ..key("constant") }, Resource::ENERGY), None);
        assert_eq!(baselines.missing([(key("constant"), episode("constant"))]), []);
        // A file that was cut short or edited is no baseline.
        let file = folder.path().join(key("constant").file_name());
        let whole = std::fs::read_to_string(&file).unwrap();
        let edited = whole.replace("614.725", "614725.");
        assert_ne!(edited, whole);
        for damaged in [&whole[..40], &edited] {
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(baselines.get(&key("constant"), Resource::ENERGY), None);
        }
    }

    #[test]
    fn the_shipped_tables_read_back_as_they_are_and_are_of_these_controllers() {
        for (text, is_operation) in SHIPPED.into_iter().zip([false, true]) {
            let rows = table::read(text).unwrap();
            assert_eq!(table::text(&rows), text);
            for (row, terms) in &rows {
                assert_eq!(
                    (row.generator.as_str(), row.engine.as_str()),
                    (GENERATOR_VERSION, ENGINE_VERSION)
                );
                let own = key(&row.task);
                assert_eq!(row.revision, own.revision, "{row:?}");
                assert!(!is_operation || row.controller == own.controller, "{row:?}");
                assert_eq!(terms.discomfort.is_some(), is_operation, "{row:?}");
                assert!(
                    terms.temperature_penalty >= 0.0
                        && terms.used.iter().all(|used| used.is_some_and(|used| used > 0.0)),
                    "{row:?}"
                );
            }
        }
        let one = vec![(key("constant"), TERMS)];
        assert_eq!(table::read(&table::text(&one)), Some(one));
    }

    #[test]
    fn a_baseline_from_before_a_resource_is_unknown_to_its_tasks_alone() {
        let folder = tempfile::tempdir().unwrap();
        let baselines = Baselines::without_shipped(folder.path());
        let peak = Resource::of_word("peak").unwrap();
        let mut old = TERMS;
        old.used[Resource::ALL.iter().position(|each| *each == peak).unwrap()] = None;
        baselines.keep(&key("constant+energy1"), old).unwrap();
        assert_eq!(baselines.get(&key("constant+energy1"), Resource::ENERGY), Some(old));
        let missing = ["constant+energy1", "constant+peak1"].map(|task| (key(task), episode(task)));
        assert_eq!(baselines.missing(missing).len(), 1, "the peak of the same episode");
        let table = table::text(&[(key("constant"), old)]);
        assert!(!table.contains("peak_w_m2"), "{table}");
        assert_eq!(table::read(&table), Some(vec![(key("constant"), old)]));
    }
}
