//! A corpus: trajectories of many policies in buildings of all types, as one dataset.
//!
//! Vectors are padded with zeros to one width; the graph of each building says what a value is and which node it
//! belongs to. Every step has the expert's action for its observation. Episodes are written one by one, so that a
//! corpus can be resumed and divided between machines.

mod card;
mod definition;
mod graph;
mod writer;

use std::path::Path;

use b2b_base::shard::Shard;
use b2b_evaluate::{ActionScale, BuiltIn, Evaluation, Policy, Progress, Recorded};

use definition::Planned;
pub use definition::{Behavior, Definition};
use graph::Graph;
use writer::Writer;

use super::collection::{file_of, record_each, unscaled};
use super::dataset::{CorpusEpisode, EpisodeMetadata};
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

/// Runs the remaining episodes of a part, and completes the corpus if no other part has episodes left.
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
    let named = |name: &str| <dyn Policy>::named(name, ActionScale::Rescaled);
    let policies = definition.policies().map(|(_, name)| named(name));
    let policies = policies.collect::<b2b_evaluate::Result<Vec<_>>>()?;
    let writer = Writer::open(destination, &definition, &policies)?;
    let is_left = |each: &&Planned<'_>| part.shard.contains(each.building) && !writer.has(each.number);
    let left: Vec<_> = planned.iter().filter(is_left).collect();
    for (own, policy) in definition.policies().zip(&policies) {
        let of_policy = left.iter().filter(|each| (each.task, each.policy) == own);
        let episodes: Vec<_> = of_policy.map(|each| (each.number, &each.episode)).collect();
        if !episodes.is_empty() {
            record_each(&episodes, policy.as_ref(), evaluation, progress, &|number, recorded| {
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
        policy: planned.policy.to_owned(),
        episode_return: file.rewards.iter().sum(),
        corpus: Some(CorpusEpisode {
            building_type: episode.subject.building_type().to_owned(),
            task: episode.task.to_string(),
            period: episode.period.to_string(),
            expert: if spaces.action.is_empty() { String::new() } else { expert.to_string() },
            graph: Graph::of(spaces)?.write(&writer.graphs())?,
            observation_width: spaces.observation.len(),
            action_width: spaces.action.len(),
        }),
    };
    writer.write(&metadata, file)
}
