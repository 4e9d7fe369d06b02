//! An evaluation from its first episode to its scored rows.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use crate::Result;
use crate::baseline::{Baselines, Key};
use crate::evaluation::{
    EpisodeInfo, EpisodePlan, EpisodeResult, Evaluation, Finished, Folder, Lost, Progress, sequences,
};
use crate::policy::Policy;
use crate::tuned::task_for;

/// The rows of an evaluation in the order of its episodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// One row per episode.
    pub rows: Vec<EpisodeResult>,
}

/// The result of an episode without a score, and the key of its baseline.
type Unscored = (EpisodeResult, Key);

/// Episodes that were to be run.
struct Ran {
    /// In order; `None` for a lost episode.
    episodes: Vec<Option<Unscored>>,
    /// Lost episodes by number.
    lost: HashMap<usize, Lost>,
}

impl Results {
    /// Runs the episodes that a folder does not contain yet, and scores all of them; unknown baselines are run, too.
    ///
    /// # Errors
    /// The errors of [`Evaluation::run`] and [`Baselines::compute`].
    pub fn of(
        evaluation: &Evaluation<'_>,
        folder: &Folder,
        episodes: &[EpisodePlan],
        policy: &dyn Policy,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let all: Vec<_> = episodes.iter().enumerate().collect();
        let Ran { episodes: ran, mut lost } = run(evaluation, folder, &all, policy, baselines, progress)?;
        let row = |(number, (ran, episode)): (usize, (Option<Unscored>, &EpisodePlan))| match ran {
            Some(ran) => scored(ran, episode, baselines),
            None => {
                let unreadable = || Lost { reason: "its file cannot be read".to_owned() };
                let lost = lost.remove(&number).unwrap_or_else(unreadable);
                EpisodeResult { info: EpisodeInfo::of(episode, policy), outcome: Err(lost) }
            }
        };
        Ok(Self { rows: ran.into_iter().zip(episodes).enumerate().map(row).collect() })
    }
}

/// Runs some episodes of an evaluation, by number, and their unknown baselines, without scoring them, so that several
/// machines can share the work. Stores their baselines, except shipped ones, in `collected`, to be copied to another
/// machine. Returns the lost episodes by number.
///
/// # Errors
/// Same as [`Results::of`].
pub fn run_part(
    evaluation: &Evaluation<'_>,
    folder: &Folder,
    part: &[(usize, &EpisodePlan)],
    policy: &dyn Policy,
    collected: &Baselines,
    progress: &dyn Progress,
) -> Result<HashMap<usize, Lost>> {
    let baselines = Baselines::open()?;
    let Ran { episodes, lost } = run(evaluation, folder, part, policy, &baselines, progress)?;
    for (ran, (_, episode)) in episodes.iter().zip(part) {
        let Some((_, key)) = ran else { continue };
        let of = |baselines: &Baselines| baselines.get(key, episode.task.resource);
        if let (None, Some(terms)) = (of(collected), of(&baselines)) {
            collected.keep(key, terms)?;
        }
    }
    Ok(lost)
}

/// Runs the episodes that a folder does not contain and the unknown baselines.
fn run(
    evaluation: &Evaluation<'_>,
    folder: &Folder,
    episodes: &[(usize, &EpisodePlan)],
    policy: &dyn Policy,
    baselines: &Baselines,
    progress: &dyn Progress,
) -> Result<Ran> {
    let read = |(number, episode): (usize, &EpisodePlan)| {
        folder.read(number).map(|finished| unscored(episode, finished, policy, baselines)).transpose()
    };
    let Parts { mut kept, missing } = parts(episodes, policy, read)?;
    let lost = run_missing(evaluation, folder, &missing, policy, progress)?;
    for each in missing {
        if let Some(ran) = read(each)? {
            kept.insert(each.0, ran);
        }
    }
    let ran: Vec<_> = episodes.iter().map(|(number, _)| kept.remove(number)).collect();
    let keys = ran
        .iter()
        .zip(episodes)
        .filter_map(|(each, (_, episode))| Some((each.as_ref()?.1.clone(), (*episode).clone())));
    let unknown = baselines.missing(keys);
    baselines.compute(evaluation, &unknown, progress)?;
    Ok(Ran { episodes: ran, lost })
}

/// The episodes of an evaluation, by number.
struct Parts<'a> {
    /// Those of complete sequences in the folder.
    kept: HashMap<usize, Unscored>,
    /// Those that are to be run.
    missing: Vec<(usize, &'a EpisodePlan)>,
}

/// Reads the sequences of which a folder contains every episode.
fn parts<'a>(
    episodes: &[(usize, &'a EpisodePlan)],
    policy: &dyn Policy,
    read: impl Fn((usize, &EpisodePlan)) -> Result<Option<Unscored>>,
) -> Result<Parts<'a>> {
    let (mut kept, mut missing) = (HashMap::new(), Vec::new());
    for sequence in sequences(episodes.iter().map(|(_, episode)| *episode), policy) {
        let own = || sequence.iter().map(|position| episodes[*position]);
        let found: Vec<Option<Unscored>> = own().map(&read).collect::<Result<_>>()?;
        match found.into_iter().collect::<Option<Vec<_>>>() {
            Some(found) => kept.extend(own().map(|(number, _)| number).zip(found)),
            None => missing.extend(own()),
        }
    }
    Ok(Parts { kept, missing })
}

/// Runs episodes, keeps them in a folder, and returns the lost ones by number.
fn run_missing(
    evaluation: &Evaluation<'_>,
    folder: &Folder,
    missing: &[(usize, &EpisodePlan)],
    policy: &dyn Policy,
    progress: &dyn Progress,
) -> Result<HashMap<usize, Lost>> {
    progress.begin("episodes", missing.len(), missing.iter().map(|(_, episode)| episode.days()).sum());
    let lost = Mutex::new(HashMap::new());
    evaluation.run(missing, policy, progress, &|number, outcome| match outcome {
        Ok(finished) => folder.keep(number, &finished),
        Err(why) => {
            lost.lock().unwrap_or_else(PoisonError::into_inner).insert(number, why);
            Ok(())
        }
    })?;
    Ok(lost.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Returns the result of a finished episode without a score. An episode of the baseline is cached.
fn unscored(
    episode: &EpisodePlan,
    finished: Finished,
    policy: &dyn Policy,
    baselines: &Baselines,
) -> Result<Unscored> {
    let key = Key::of(episode, &finished.record.info.site())?;
    let resource = episode.task.resource;
    if policy.is_baseline(&episode.task) && baselines.get(&key, resource).is_none() {
        baselines.remember(&key, finished.terms);
    }
    Ok((EpisodeResult::unscored(finished, resource), key))
}

/// Returns the result with its score, if the baseline is known.
fn scored((mut result, key): Unscored, episode: &EpisodePlan, baselines: &Baselines) -> EpisodeResult {
    let EpisodePlan { subject, task, steps_per_hour, .. } = episode;
    if let Some(terms) = baselines.get(&key, task.resource) {
        let task = task_for(subject, &result.info.site(), task, *steps_per_hour);
        result.score_against(terms.baseline(&task));
    }
    result
}
