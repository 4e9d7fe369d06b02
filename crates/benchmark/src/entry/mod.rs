//! A run of a benchmark problem, and the folder that it leaves.
//!
//! 1. An [`Entry`] is a problem and who runs in it; its stages are lists of episodes.
//! 2. [`Entry::run`] evaluates them stage by stage, each kept under `unfinished/` as it ends, so that the same entry
//!    goes on where it was interrupted.
//! 3. A [`RunResult`] is what is left: `result.json`, `episodes.parquet`, and the networks in `policy/`. Two runs leave the
//!    same bytes.
//! 4. [`verify`] tells whether a folder holds what it says.

mod entrant;
mod measures;
mod result;
mod verify;

use std::collections::BTreeMap;
use std::path::Path;

pub use entrant::{About, Entrant};
pub use measures::{Adaptation, Measures, Point, Score, Stratum, measures_of};
pub use result::{RunResult, Stages, read_result};
pub use verify::{Check, Rerun, verify};

use crate::error::at;
use crate::evaluation::{Episode, Evaluation, Folder, Progress, Row};
use crate::policy::BuiltIn;
use crate::problem::{Problem, Stage, Through};
use crate::results::Results;
use crate::{Baselines, Error, Result};

/// Where stages are kept until all have ended.
const UNFINISHED: &str = "unfinished";

/// A problem, and who runs in it.
#[derive(Debug)]
pub struct Entry {
    /// The problem.
    pub problem: Problem,
    /// Name on the leaderboard.
    pub name: String,
    /// How it came about, in a line.
    pub description: Option<String>,
    /// Steps that it was trained for, as who runs it says.
    pub training_steps: Option<u64>,
    /// Who is tested.
    pub policy: Entrant,
    /// Who acts on training buildings, if another: where the sides have other shapes.
    pub train_policy: Option<Entrant>,
    /// Who acts after so many steps on each test environment.
    pub adapted: BTreeMap<u64, Entrant>,
}

/// How a run ended.
#[derive(Debug)]
pub enum Ended {
    /// With a result, and its rows by stage.
    Finished(Box<RunResult>, Vec<(Stage, Vec<Row>)>),
    /// Without one: these episodes were lost, each with the reason.
    Lost(Vec<Row>),
}

impl Entry {
    /// Whether the rules of the problem allow it.
    ///
    /// # Errors
    /// [`Error::Problem`] naming what they do not.
    pub fn check(&self) -> Result<()> {
        self.problem.check()?;
        let protocol = &self.problem.protocol;
        let refuse = |why: String| Err(Error::Problem { name: self.problem.name.clone(), why });
        if let Some(steps) = self.training_steps.filter(|steps| *steps > protocol.training_steps) {
            let budget = protocol.training_steps;
            return refuse(format!(
                "{} was trained for {steps} steps, and the budget is {budget}",
                self.name
            ));
        }
        if let Some(steps) = self.adapted.keys().find(|steps| !protocol.adaptation.contains(steps)) {
            let known = &protocol.adaptation;
            return refuse(format!("there is no adaptation test after {steps} steps: there are {known:?}"));
        }
        Ok(())
    }

    /// Its parts, in order.
    pub fn stages(&self) -> Vec<Stage> {
        let mut stages = vec![Stage::Test];
        if self.problem.protocol.train_sample > 0 {
            stages.push(Stage::Train);
        }
        if !self.adapted.is_empty() {
            stages.push(Stage::Untrained);
            stages.extend(self.adapted.keys().map(|steps| Stage::Adapted(*steps)));
        }
        stages
    }

    /// Who acts in a stage.
    pub fn entrant(&self, stage: Stage) -> &Entrant {
        const UNTRAINED: &Entrant = &Entrant::BuiltIn(BuiltIn::Random);
        match stage {
            Stage::Test => &self.policy,
            Stage::Train => self.train_policy.as_ref().unwrap_or(&self.policy),
            Stage::Untrained => UNTRAINED,
            Stage::Adapted(steps) => self.adapted.get(&steps).unwrap_or(&self.policy),
        }
    }

    /// The episodes of a stage.
    pub fn episodes(&self, stage: Stage) -> Vec<Episode> {
        let seeds = self.entrant(stage).seeds(&self.problem.protocol.seeds);
        self.problem.episodes(stage, &seeds)
    }

    /// Runs what a folder does not hold yet, and leaves the result there. A folder with the result is left as it is.
    ///
    /// # Errors
    /// Those of [`Entry::check`]; [`Error::OtherEvaluation`] for a folder of another entry; those of
    /// [`Folder::open`] and [`Results::of`].
    pub fn run(
        &self,
        folder: &Path,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<Ended> {
        self.check()?;
        if let Some((there, rows)) = result::there(folder)? {
            let here = RunResult::of(self, &rows)?;
            there.refuse_other(&here, folder)?;
            self.clear(folder)?;
            return Ok(Ended::Finished(Box::new(there), rows));
        }
        result::refuse_foreign(folder)?;
        let mut stages = Vec::new();
        let mut lost = Vec::new();
        for stage in self.stages() {
            let rows = self.run_stage(stage, folder, evaluation, baselines, progress)?;
            lost.extend(rows.iter().filter(|row| row.lost.is_some() || row.score.is_none()).cloned());
            stages.push((stage, rows));
        }
        if !lost.is_empty() {
            return Ok(Ended::Lost(lost));
        }
        let result = RunResult::of(self, &stages)?;
        result.write(self, &stages, folder)?;
        self.clear(folder)?;
        Ok(Ended::Finished(Box::new(result), stages))
    }

    fn run_stage(
        &self,
        stage: Stage,
        folder: &Path,
        evaluation: &Evaluation<'_>,
        baselines: &Baselines,
        progress: &dyn Progress,
    ) -> Result<Vec<Row>> {
        let policy = Through::new(self.entrant(stage).policy(), &self.problem, self.problem.side(stage));
        let episodes = self.episodes(stage);
        let folder = Folder::open(&folder.join(UNFINISHED).join(stage.to_string()), &policy, &episodes)?;
        Ok(Results::of(evaluation, &folder, &episodes, &policy, baselines, progress)?.rows)
    }

    fn clear(&self, folder: &Path) -> Result<()> {
        let unfinished = folder.join(UNFINISHED);
        match unfinished.exists() {
            true => std::fs::remove_dir_all(&unfinished).map_err(at(&unfinished)),
            false => Ok(()),
        }
    }
}
