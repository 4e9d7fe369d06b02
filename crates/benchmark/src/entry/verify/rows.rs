//! Checks of every row that need no simulation.

use std::collections::HashMap;

use b2b_dataset::BuildingName;
use b2b_env::EpisodeMetrics;

use super::{CheckOutcome, ROUNDING, TOLERANCE, agree, agrees, expected, near};
use crate::entry::result::RunResult;
use crate::problem::Stage;
use b2b_evaluate::task_for;
use b2b_evaluate::{Baseline, Scores};
use b2b_evaluate::{Baselines, Key};
use b2b_evaluate::{EpisodeInfo, EpisodePlan, EpisodeResult, Scored};

/// Length of a trajectory hash: a SHA-256 in hexadecimal.
const HASH_DIGITS: usize = 64;

/// Returns whether a row belongs to an episode. Task hashes are not compared: they include the building's energy scale.
pub(super) fn is_of(row: &EpisodeResult, episode: &EpisodePlan) -> bool {
    let EpisodeInfo { building, building_type, split, task, period, seed, steps_per_hour, .. } = &row.info;
    let EpisodePlan { subject, .. } = episode;
    *building == subject.name.to_string()
        && building_type == subject.building_type()
        && *split == subject.split()
        && *task == episode.task.to_string()
        && *period == episode.period.to_string()
        && *seed == episode.seed
        && *steps_per_hour == episode.steps_per_hour
        && is_at(row, episode)
        && row.metrics().is_none_or(|metrics| metrics.steps as u64 == episode.steps())
}

/// Returns whether a row has its building's place and, if the dataset lists one, climate zone.
fn is_at(row: &EpisodeResult, episode: &EpisodePlan) -> bool {
    let BuildingName::Id(id) = episode.subject.name else { return true };
    let building = &b2b_dataset::row(id).building;
    row.info.place == building.place()
        && building.location().ashrae_zone().is_none_or(|zone| row.info.climate_zone == zone)
}

/// Checks the sums and scores of every row.
pub(super) fn scores(stages: &[(Stage, Vec<EpisodeResult>)]) -> CheckOutcome {
    for (stage, row) in stages.iter().flat_map(|(stage, rows)| rows.iter().map(move |row| (stage, row))) {
        score(row).map_err(|why| format!("{stage}: {}: {why}", row.info))?;
    }
    Ok("returns are the sums of their penalties, and scores are the ratios of returns".into())
}

fn score(row: &EpisodeResult) -> Result<(), String> {
    let scored = row.outcome.as_ref().map_err(|lost| format!("the episode was lost: {lost}"))?;
    let EpisodeMetrics { episode_return, temperature_penalty, energy_penalty, steps, .. } = scored.metrics;
    let sum = -temperature_penalty - energy_penalty;
    if !near(episode_return, sum) {
        return Err(format!("the return is {episode_return}; its penalties sum to {sum}"));
    }
    let counted: u64 = scored.step_rewards.counts.iter().map(|count| u64::from(*count)).sum();
    if counted != steps as u64 {
        return Err(format!("the histogram has {counted} step rewards; the episode has {steps} steps"));
    }
    let hash = &scored.trajectory_hash;
    if hash.len() != HASH_DIGITS || !hash.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return Err(format!("`{hash}` is not a trajectory hash; expected {HASH_DIGITS} hexadecimal digits"));
    }
    let baseline = scored.baseline().ok_or("its baseline is missing")?;
    let Scores { score, resolved } =
        baseline.scores(&scored.metrics, scored.resource, row.info.steps_per_hour);
    if score.is_none() || score != scored.score {
        return Err(format!("the score is {:?}; the baseline gives {score:?}", scored.score));
    }
    if resolved.is_none() || resolved != scored.resolved_score {
        return Err(format!("the resolved score is {:?}; expected {resolved:?}", scored.resolved_score));
    }
    Ok(())
}

/// Checks the baseline of every row: rows that share a baseline agree, and each agrees with `known` where it has an
/// entry. Known baselines may come from a machine that rounds differently.
pub(super) fn baselines(
    result: &RunResult,
    stages: &[(Stage, Vec<EpisodeResult>)],
    known: &Baselines,
) -> CheckOutcome {
    let mut first: HashMap<(Key, String), Baseline> = HashMap::new();
    let (mut rows_checked, mut rows_known) = (0, 0);
    for (stage, rows) in stages {
        let episodes = expected(result, *stage).unwrap_or_default();
        for (row, episode) in rows.iter().zip(&episodes) {
            let Ok(scored) = &row.outcome else { continue };
            let Some(here) = scored.baseline() else { continue };
            let site = row.info.site();
            let key = Key::of(episode, &site).map_err(|error| error.to_string())?;
            let named = |why: String| format!("{stage}: {}: {why}", row.info);
            resource(scored, episode).map_err(named)?;
            if let Some(terms) = known.get(&key, episode.task.resource) {
                let there =
                    terms.baseline(&task_for(&episode.subject, &site, &episode.task, episode.steps_per_hour));
                agree(Some(&here), &there, TOLERANCE)
                    .map_err(|why| named(format!("{why}, as the known baseline has")))?;
                rows_known += 1;
            }
            let there = first.entry((key, row.info.task.clone())).or_insert(here);
            agree(Some(&here), there, ROUNDING)
                .map_err(|why| named(format!("{why}, as another row of the same episode has")))?;
            rows_checked += 1;
        }
    }
    Ok(format!(
        "rows with the same baseline agree; {rows_known} of {rows_checked} agree with known baselines"
    ))
}

/// Checks the amount of the task's resource, if the metrics have it.
fn resource(scored: &Scored, episode: &EpisodePlan) -> Result<(), String> {
    match scored.metrics.used(episode.task.resource) {
        None => Ok(()),
        own => agrees("its resource", scored.resource, own, TOLERANCE),
    }
}
