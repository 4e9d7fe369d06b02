//! The spaces and metrics of an episode, from which the files of `b2b run` are written.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use b2b_cli::{Author, Rollout};
use b2b_env::{Metrics, Trajectory};
use b2b_workers::EpisodeReport;
use pyo3::prelude::*;

use crate::interpreter::arrays;
use crate::interpreter::error::Exception;

/// The spaces of an episode, and its metrics if it ran to its end.
#[pyclass(frozen, module = "building2building._core")]
pub struct Record {
    pub spaces: Arc<b2b_env::Spaces>,
    /// Name of the place, or of the weather file.
    pub place: String,
    /// `None` before its end.
    pub metrics: Option<Metrics>,
    /// `None` if the engine did not finish its run.
    pub report: Option<EpisodeReport>,
}

#[pymethods]
impl Record {
    /// Writes the files of `b2b run` to a folder and returns their paths. An episode that did not run to its end has
    /// only the time series. Observations, actions and penalties have one row per step; `wall` is the duration of the
    /// steps, s.
    #[expect(clippy::too_many_arguments, reason = "they are the parts of a Python trajectory")]
    fn write(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        controller: String,
        seed: u64,
        wall: f64,
        observations: &Bound<'_, PyAny>,
        actions: &Bound<'_, PyAny>,
        penalties: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<PathBuf>> {
        if self.metrics.is_some() && self.report.is_none() {
            let why = "the engine of a branch does not finish its run, so its meters and messages are unknown; use \
                       snapshot and restore instead";
            return Err(Exception::Episode.new_err(why));
        }
        let trajectory = trajectory(observations, actions, penalties)?;
        let author = Author { place: self.place.clone(), controller, parameters: None, seed };
        let written = py.detach(|| match (&self.metrics, &self.report) {
            (Some(metrics), Some(report)) => {
                let wall = Duration::try_from_secs_f64(wall).unwrap_or_default();
                let rollout = Rollout::new(metrics.clone(), trajectory, report.clone(), wall);
                author.write_episode(&folder, &self.spaces, &rollout)
            }
            _ => author.write_steps(&folder, &self.spaces, &trajectory),
        });
        written.map_err(|error| Exception::Setting.new_err(format!("{error:#}")))
    }
}

/// Returns the trajectory hash that `b2b run` prints; observations, actions and penalties have one row per step.
#[pyfunction]
pub fn trajectory_hash(
    observations: &Bound<'_, PyAny>,
    actions: &Bound<'_, PyAny>,
    penalties: &Bound<'_, PyAny>,
) -> PyResult<String> {
    Ok(trajectory(observations, actions, penalties)?.hash())
}

fn trajectory(
    observations: &Bound<'_, PyAny>,
    actions: &Bound<'_, PyAny>,
    penalties: &Bound<'_, PyAny>,
) -> PyResult<Trajectory> {
    let (penalties, _) = arrays::rows(penalties)?;
    Ok(Trajectory {
        observations: arrays::rows(observations)?.0,
        actions: arrays::rows(actions)?.0,
        penalties: penalties.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
    })
}
