//! Episodes of operation over the five two-week periods, kept in a folder.

use std::path::Path;

use anyhow::{Result, bail};
use b2b_building::Period;
use b2b_climate::TwoWeeks;
use b2b_dataset::{BuildingId, BuildingName};
use b2b_env::{Band, Task};
use b2b_evaluate::{Baselines, EpisodePlan, EpisodeResult, Evaluation, Folder, Policy, Results, Subject};

use crate::scoring::evaluation::{Bars, fetch_weather};

/// Returns the episodes of a policy in dataset buildings at constant prices, building by building. Finished ones are
/// read from the folder.
pub fn two_weeks(
    evaluation: &Evaluation<'_>,
    ids: &[BuildingId],
    policy: &dyn Policy,
    folder: &Path,
    quiet: bool,
) -> Result<Vec<EpisodeResult>> {
    let episode = |id: &BuildingId, period: TwoWeeks| EpisodePlan {
        subject: Subject::at_home(BuildingName::Id(*id)),
        task: Task::operate(Band::Own),
        period: Period::TwoWeeks(period),
        seed: 0,
        steps_per_hour: 12,
    };
    let episodes: Vec<EpisodePlan> =
        ids.iter().flat_map(|id| TwoWeeks::ALL.map(|period| episode(id, period))).collect();
    if episodes.is_empty() {
        return Ok(Vec::new());
    }
    let folder = Folder::open(folder, policy, &episodes)?;
    fetch_weather(&episodes, quiet)?;
    let (baselines, bars) = (Baselines::open()?, Bars::new(quiet));
    let results = Results::of(evaluation, &folder, &episodes, policy, &baselines, &bars)?;
    drop(bars);
    match results.rows.iter().find_map(|row| Some((&row.info, row.outcome.as_ref().err()?))) {
        Some((info, lost)) => bail!("{info}: {lost}; run the same command again"),
        None => Ok(results.rows),
    }
}
