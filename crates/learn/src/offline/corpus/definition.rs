//! Definitions of corpora.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

use b2b_building::{BuildingType, Date, RunPeriod};
use b2b_dataset::{BuildingId, BuildingName, Split};
use b2b_env::Task;
use b2b_evaluate::{ActionScale, EpisodePlan, Policy, Subject};
use serde::{Deserialize, Serialize};

use super::history::{History, Stage};
use crate::error::at;
use crate::{Error, Result};

/// Days of an episode.
const DAYS: u32 = 7;
/// Whole weeks of a year.
const WEEKS: u32 = 52;
/// Zone time steps per hour.
pub(super) const STEPS_PER_HOUR: u32 = 12;

/// The definition of a corpus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// Building types; all six by default.
    #[serde(default = "all_types")]
    pub types: Vec<BuildingType>,
    /// Buildings of each type, from the training split.
    pub buildings: u32,
    /// Weeks in each building, spread over the year.
    pub weeks: u32,
    /// Widths that observations and actions are padded to.
    pub widths: [usize; 2],
    /// Policies by task.
    pub episodes: Vec<Behavior>,
    /// Agents at stages of their training.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub histories: Vec<History>,
}

/// Policies under a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Behavior {
    /// The task.
    pub task: String,
    /// The policies.
    pub policies: Vec<String>,
}

/// A policy of a corpus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source<'a> {
    /// A policy with a name.
    Named(&'a str),
    /// The agent of a stage for the type of the building.
    Stage(Stage<'a>),
}

impl fmt::Display for Source<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => f.write_str(name),
            Self::Stage(stage) => stage.fmt(f),
        }
    }
}

/// Returns the policy with a name.
pub(super) fn named(name: &str) -> Result<Box<dyn Policy>> {
    Ok(<dyn Policy>::named(name, ActionScale::Rescaled)?)
}

/// An episode of a corpus.
pub(super) struct Planned<'a> {
    /// Number.
    pub number: usize,
    /// Number of its building.
    pub building: usize,
    /// Its task.
    pub task: &'a str,
    /// Its policy.
    pub policy: Source<'a>,
    /// The episode.
    pub episode: EpisodePlan,
}

impl Definition {
    /// Returns the definition with a name, or the one in a TOML file.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown name and a definition with an error; [`Error::Io`].
    pub fn named(name: &str) -> Result<Self> {
        let mut all: BTreeMap<String, Self> =
            toml::from_str(include_str!("../../../data/corpora.toml")).expect("a test reads it");
        let path = Path::new(name);
        if path.extension().is_none_or(|extension| extension != "toml") {
            let known = all.keys().cloned().collect::<Vec<_>>().join(", ");
            let unknown = || format!("unknown corpus `{name}`; expected {known} or a TOML file");
            return all.remove(name).ok_or_else(|| Error::Invalid(unknown()));
        }
        let text = std::fs::read_to_string(path).map_err(at(path))?;
        let mut definition: Self =
            toml::from_str(&text).map_err(|error| Error::Invalid(format!("{name}: {error}")))?;
        definition.read_tasks()?;
        definition.check().map_err(|why| Error::Invalid(format!("{name}: {why}")))?;
        Ok(definition)
    }

    /// Replaces the paths of task files by their content, so that the definition is complete.
    fn read_tasks(&mut self) -> Result<()> {
        let of_histories = self.histories.iter_mut().map(|history| &mut history.task);
        for task in self.episodes.iter_mut().map(|behavior| &mut behavior.task).chain(of_histories) {
            if task.parse::<Task>().is_err() {
                *task = Task::from_text(task)?.to_text();
            }
        }
        Ok(())
    }

    fn check(&self) -> std::result::Result<(), String> {
        let buildings = self.types.iter().map(|building_type| training(*building_type).count() as u32).min();
        let (Some(buildings), Some(_)) = (buildings, self.policies().next()) else {
            return Err("it has no types or no policies; expected at least one of each".into());
        };
        if self.widths.contains(&0) {
            return Err(format!(
                "`widths` are {:?}; expected at least 1 for observations and for actions",
                self.widths
            ));
        }
        self.histories.iter().try_for_each(|history| history.check(&self.types))?;
        let names: BTreeSet<&str> = self.histories.iter().map(|history| &*history.name).collect();
        if names.len() < self.histories.len() {
            return Err("two `histories` have one name; expected different ones".into());
        }
        let numbers = [("buildings", self.buildings, buildings), ("weeks", self.weeks, WEEKS)];
        match numbers.into_iter().find(|(_, value, most)| !(1..=*most).contains(value)) {
            Some((name, value, most)) => Err(format!("`{name}` is {value}; expected 1 to {most}")),
            None => Ok(()),
        }
    }

    /// Returns the number of buildings of all types.
    pub fn all_buildings(&self) -> usize {
        self.types.len() * self.buildings as usize
    }

    /// Returns the number of episodes.
    pub(super) fn episode_count(&self) -> usize {
        self.all_buildings() * self.weeks as usize * self.policies().count()
    }

    /// Returns the number of transitions.
    pub fn transitions(&self) -> usize {
        self.episode_count() * (DAYS * 24 * STEPS_PER_HOUR) as usize
    }

    /// Returns the tasks and policies, in the order of the episodes of a week.
    pub(super) fn policies(&self) -> impl Iterator<Item = (&str, Source<'_>)> {
        let named = self.episodes.iter().flat_map(|behavior| {
            let Behavior { task, policies } = behavior;
            policies.iter().map(|policy| (task.as_str(), Source::Named(policy)))
        });
        let learned = self.histories.iter().flat_map(|history| {
            history.all_stages().map(|stage| (history.task.as_str(), Source::Stage(stage)))
        });
        named.chain(learned)
    }

    /// Returns the histories, each with every type.
    pub(super) fn trainings(&self) -> impl Iterator<Item = (&History, BuildingType)> {
        self.types.iter().flat_map(|of| self.histories.iter().map(move |history| (history, *of)))
    }

    /// Returns all episodes, by building, week and policy.
    ///
    /// # Errors
    /// [`Error::Env`] for an invalid task.
    pub(super) fn plan(&self) -> Result<Vec<Planned<'_>>> {
        let mut planned = Vec::with_capacity(self.episode_count());
        let mut policies = Vec::new();
        for (task, policy) in self.policies() {
            policies.push((Task::from_text(task)?, task, policy));
        }
        for (building, id) in self.ids().into_iter().enumerate() {
            for week in 0..self.weeks {
                let period = self.week(building as u32 % self.buildings, week);
                for &(ref parsed, task, policy) in &policies {
                    let number = planned.len();
                    let episode = EpisodePlan {
                        subject: Subject::at_home(BuildingName::Id(id)),
                        task: parsed.clone(),
                        period: period.into(),
                        seed: number as u64,
                        steps_per_hour: STEPS_PER_HOUR,
                    };
                    planned.push(Planned { number, building, task, policy, episode });
                }
            }
        }
        Ok(planned)
    }

    /// Returns the buildings: the first ones of the training split, by type.
    pub fn ids(&self) -> Vec<BuildingId> {
        let of_type = |building_type| training(building_type).take(self.buildings as usize);
        self.types.iter().copied().flat_map(of_type).collect()
    }

    /// Returns the days of a week in a building, both given by number.
    fn week(&self, building: u32, week: u32) -> RunPeriod {
        let number = (building * WEEKS / self.buildings + week * WEEKS / self.weeks) % WEEKS;
        let first = 1 + DAYS * number;
        RunPeriod::new(Date::of_day(first), Date::of_day(first + DAYS - 1))
    }
}

/// Returns the training split of a type.
fn training(building_type: BuildingType) -> impl Iterator<Item = BuildingId> {
    b2b_dataset::rows(building_type).iter().filter(|row| row.split == Split::Train).map(|row| row.id)
}

fn all_types() -> Vec<BuildingType> {
    BuildingType::ALL.to_vec()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_corpora_have_their_sizes_and_weeks_all_over_the_year() {
        let quick = Definition::named("quick").unwrap();
        let full = Definition::named("full").unwrap();
        assert_eq!((quick.transitions(), full.transitions()), (2_032_128, 103_638_528));
        assert_eq!(full.check(), Ok(()));
        assert!(full.all_buildings() >= 1000);
        for definition in [quick, full] {
            let planned = definition.plan().unwrap();
            assert_eq!(planned.len(), definition.episode_count());
            assert!(planned.iter().enumerate().all(|(number, each)| each.number == number));
            let weeks: HashSet<String> = planned.iter().map(|each| each.episode.period.to_string()).collect();
            assert!(weeks.len() >= 24 && weeks.contains("01-01..01-07"), "{weeks:?}");
            assert!(planned.iter().all(|each| each.episode.days() == u64::from(DAYS)));
        }
        assert!(Definition::named("huge").unwrap_err().to_string().contains("full, quick"));
    }

    #[test]
    fn a_corpus_may_have_every_building_of_the_training_split() {
        let with = |buildings| Definition { buildings, ..Definition::named("quick").unwrap() };
        assert_eq!(with(900).check(), Ok(()));
        assert_eq!(with(900).all_buildings(), with(900).ids().len());
        assert_eq!(with(901).check().unwrap_err(), "`buildings` is 901; expected 1 to 900");
        let narrow = Definition { widths: [192, 0], ..with(1) };
        assert!(narrow.check().unwrap_err().starts_with("`widths` are [192, 0]"));
        let none = Definition { types: Vec::new(), ..with(1) };
        assert!(none.check().unwrap_err().contains("no types"));
    }

    #[test]
    fn a_history_whose_setting_would_have_no_effect_is_an_error() {
        let full = Definition::named("full").unwrap();
        let said = |change: &dyn Fn(&mut Vec<History>)| {
            let mut histories = full.histories.clone();
            change(&mut histories);
            Definition { histories, ..full.clone() }.check().unwrap_err()
        };
        let with = |option: &'static str, value: i64| {
            said(&|all| drop(all[0].train.insert(option.into(), value.into())))
        };
        assert_eq!(
            with("stage_every", 5),
            "`train.stage_every` of the history `direct` is set by the corpus; remove it"
        );
        assert_eq!(with("steps", 3), "`steps` is 3; expected at least the 4 `stages`");
        assert!(said(&|all| all[1].name = "direct".into()).contains("two `histories` have one name"));
        assert!(said(&|all| all[0].name = "a/b".into()).contains("`a/b`; expected letters"));
        assert!(said(&|all| all[0].stages = 0).contains("`stages` is 0"));
    }
}
