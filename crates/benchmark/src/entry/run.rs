//! Runs an entry stage by stage.

use std::path::Path;

use super::definition::Entry;
use super::result::{RunResult, Stages, UNFINISHED, check_new, check_no_links, find_result};
use crate::Result;
use crate::error::at;
use crate::problem::{Stage, WrappedPolicy};
use b2b_base::new_folders::NewFolders;
use b2b_evaluate::Baselines;
use b2b_evaluate::Results;
use b2b_evaluate::{EpisodeResult, Evaluation, Folder, Progress};

/// The outcome of a run.
#[derive(Debug)]
pub enum RunOutcome {
    /// The result with its rows by stage.
    Complete(Box<RunResult>, Stages),
    /// The episodes that were lost or have no score; no result is written.
    Incomplete(Vec<EpisodeResult>),
}

impl Entry {
    /// Runs the episodes that a folder does not contain yet, and writes the result to it. A folder that
    /// has the result already does not change.
    ///
    /// # Errors
    /// The errors of [`Entry::check`]; [`Error::OtherEvaluation`](b2b_evaluate::Error::OtherEvaluation) for the folder
    /// of another entry; errors from [`Folder::open`] and [`Results::of`].
    pub fn run(
        &self,
        folder: &Path,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<RunOutcome> {
        self.check()?;
        check_no_links(folder)?;
        if let Some((there, stages)) = find_result(folder)? {
            let here = RunResult::of(self, &stages)?;
            there.check_same(&here, folder)?;
            clear(folder)?;
            return Ok(RunOutcome::Complete(Box::new(there), stages));
        }
        check_new(folder)?;
        let mut stages = Vec::new();
        let mut lost = Vec::new();
        for stage in self.stages() {
            let rows = self.run_stage(stage, folder, evaluation, baselines, progress)?;
            lost.extend(rows.iter().filter(|row| row.score().is_none()).cloned());
            stages.push((stage, rows));
        }
        if !lost.is_empty() {
            return Ok(RunOutcome::Incomplete(lost));
        }
        let result = RunResult::of(self, &stages)?;
        result.write(self, &stages, folder)?;
        clear(folder)?;
        Ok(RunOutcome::Complete(Box::new(result), stages))
    }

    fn run_stage(
        &self,
        stage: Stage,
        folder: &Path,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<Vec<EpisodeResult>> {
        let policy =
            WrappedPolicy::new(self.policy_of(stage).policy(), &self.problem, self.problem.side(stage));
        let episodes = self.episodes(stage);
        let unfinished = folder.join(UNFINISHED);
        let created = NewFolders::create(&unfinished).map_err(at(&unfinished))?;
        let results = Folder::open(&unfinished.join(stage.to_string()), &policy, &episodes)?
            .carry_out(|folder| Results::of(evaluation, folder, &episodes, &policy, baselines, progress))?;
        created.keep();
        Ok(results.rows)
    }
}

/// Removes the folder of an unfinished run.
fn clear(folder: &Path) -> Result<()> {
    let unfinished = folder.join(UNFINISHED);
    match unfinished.exists() {
        true => std::fs::remove_dir_all(&unfinished).map_err(at(&unfinished)),
        false => Ok(()),
    }
}
