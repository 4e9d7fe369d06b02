//! A corpus: trajectories of many policies in buildings of all types, as one dataset.
//!
//! Vectors are padded with zeros to one width; the graph of each building says what a value is and which node it
//! belongs to. Every step has the expert's action for its observation. Episodes are written one by one, so that a
//! corpus can be resumed and divided between machines.

mod agents;
mod card;
mod definition;
mod graph;
mod history;
mod writer;

use std::path::Path;

use b2b_agent::Agent;
use b2b_base::shard::Shard;
use b2b_building::BuildingType;
use b2b_evaluate::{BuiltIn, Evaluation, Policy, Progress, Recorded};

pub use agents::train_agents;
pub use definition::{Behavior, Definition};
use definition::{Planned, Source, named};
use graph::Graph;
pub use history::History;
use writer::Writer;

use super::collection::{file_of, record_each, unscaled};
use super::dataset::{CorpusEpisode, EpisodeMetadata, ModelReading};
use crate::Result;

/// A part of a corpus to collect.
#[derive(Clone, Copy, Debug)]
pub struct CorpusPart<'a> {
    /// Name of the dataset, such as `b2b/corpus-quick-v0`.
    pub id: &'a str,
    /// Name of the definition, or a TOML file with one.
    pub name: &'a str,
    /// The buildings to run, by number.
    pub shard: Shard,
}

/// The part of a corpus that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Collected {
    /// Episodes that are written.
    pub episodes: usize,
    /// All episodes of the corpus.
    pub of: usize,
    /// Transitions that are written.
    pub transitions: usize,
}

impl Collected {
    /// Returns whether the corpus is complete: a dataset that can be read.
    pub fn is_complete(&self) -> bool {
        self.episodes == self.of
    }
}

/// Runs the remaining episodes of a part, and completes the corpus if no other part has episodes left. [`train_agents`]
/// must have trained its agents.
///
/// # Errors
/// [`Error::Invalid`](crate::Error::Invalid) for an unknown name, a folder of another corpus, a vector wider than the
/// corpus, and when an episode is lost; errors from [`Evaluation::record`].
pub fn collect_corpus(
    part: &CorpusPart<'_>,
    destination: &Path,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<Collected> {
    let definition = Definition::named(part.name)?;
    let planned = definition.plan()?;
    let writer = Writer::open(destination, &definition)?;
    let policies = Played::all(&definition, destination)?;
    let is_left = |each: &&Planned<'_>| part.shard.contains(each.building) && !writer.has(each.number);
    let left: Vec<_> = planned.iter().filter(is_left).collect();
    for played in &policies {
        let of_policy = left.iter().filter(|each| played.is_of(each));
        let episodes: Vec<_> = of_policy.map(|each| (each.number, &each.episode)).collect();
        if !episodes.is_empty() {
            record_each(&episodes, played.policy.as_ref(), evaluation, progress, &|number, recorded| {
                write(&planned[number], recorded, &writer)
            })?;
        }
    }
    let episodes = planned.iter().filter(|each| writer.has(each.number)).count();
    let transitions = definition.transitions() / planned.len() * episodes;
    let collected = Collected { episodes, of: planned.len(), transitions };
    if collected.is_complete() {
        writer.finish(part.id, part.name)?;
    }
    Ok(collected)
}

/// A policy, with the episodes that it runs.
struct Played<'a> {
    task: &'a str,
    source: Source<'a>,
    /// The only type of its buildings; any if `None`.
    building_type: Option<BuildingType>,
    policy: Box<dyn Policy>,
}

impl<'a> Played<'a> {
    /// Reads the policies of a corpus: an agent for each type, and others once.
    fn all(definition: &'a Definition, destination: &Path) -> Result<Vec<Self>> {
        let mut all = Vec::new();
        for (task, source) in definition.policies() {
            match source {
                Source::Named(name) => {
                    let policy = named(name)?;
                    all.push(Self { task, source, building_type: None, policy });
                }
                Source::Stage(stage) => {
                    for &of in &definition.types {
                        let policy = Box::new(Agent::read(&stage.folder(destination, of))?);
                        all.push(Self { task, source, building_type: Some(of), policy });
                    }
                }
            }
        }
        Ok(all)
    }

    fn is_of(&self, planned: &Planned<'_>) -> bool {
        let is_type = |own: BuildingType| planned.episode.subject.building_type() == own.name();
        (planned.task, planned.policy) == (self.task, self.source) && self.building_type.is_none_or(is_type)
    }
}

/// Writes an episode with its labels and its graph.
fn write(planned: &Planned<'_>, recorded: &Recorded<'_>, writer: &Writer<'_>) -> Result<()> {
    let (episode, spaces) = (&planned.episode, recorded.spaces);
    let expert = BuiltIn::baseline_of(&episode.task);
    let mut file = file_of(recorded, true);
    if !spaces.action.is_empty() {
        file.expert = unscaled(&expert.labels(recorded)?, spaces);
    }
    let metadata = EpisodeMetadata {
        id: planned.number,
        total_steps: file.rewards.len(),
        seed: episode.seed,
        building: episode.subject.label(),
        place: None,
        weather: None,
        reading: ModelReading::default(),
        policy: planned.policy.to_string(),
        policy_identity: None,
        period: Some(episode.period.to_string()),
        episode_return: file.rewards.iter().sum(),
        corpus: Some(CorpusEpisode {
            building_type: episode.subject.building_type().to_owned(),
            task: episode.task.to_text(),
            expert: if spaces.action.is_empty() { String::new() } else { expert.to_string() },
            graph: Graph::of(spaces)?.write(&writer.graphs())?,
            observation_width: spaces.observation.len(),
            action_width: spaces.action.len(),
        }),
    };
    writer.write(&metadata, file)
}
