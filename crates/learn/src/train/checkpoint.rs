//! Checkpoints: everything a run needs to continue bit for bit, in one file.

use std::path::Path;

use b2b_base::aside::write_whole;

use super::judge::Rating;
use super::sealed_state::{seal, unseal};
use crate::error::{Error, Result, at};
use crate::state::State;

/// Name of the file.
pub const CHECKPOINT: &str = "checkpoint.safetensors";

/// The state of a run between two updates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Checkpoint {
    /// Environment steps so far.
    pub(super) steps: u64,
    /// Rating of the best agent in the evaluations so far.
    pub(super) best: Rating,
    /// Seconds of training so far.
    pub(super) seconds: f64,
    /// Logarithm of the standard deviation of actions when training began.
    pub(super) log_std: f64,
    /// Cost of actuator travel.
    pub(super) travel_cost: f32,
    /// Multipliers of the penalty of discomfort.
    pub(super) comfort_weights: Vec<f32>,
    /// State of the learner.
    pub(super) learner: State,
    /// State of the environments.
    pub(super) collector: State,
}

impl Checkpoint {
    /// Writes the checkpoint of a run's folder, replacing the previous one.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let mut all = State::default();
        all.put_u64("steps", &[self.steps]);
        all.put_f64("best", &[self.best.score, self.best.relative_travel, self.seconds, self.log_std]);
        all.put_f32("travel_cost", &[self.travel_cost]);
        all.put_f32("comfort_weights", &self.comfort_weights);
        all.put_all("learner", &self.learner);
        all.put_all("collector", &self.collector);
        let path = folder.join(CHECKPOINT);
        write_whole(&path, &seal(&all)).map_err(at(&path))
    }

    /// Reads the checkpoint of a run's folder; `None` if there is none.
    pub(super) fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(CHECKPOINT);
        let wrong = |why: String| Error::Resume { path: path.clone(), why };
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(wrong(error.to_string())),
        };
        let all = unseal(&bytes).map_err(|error| wrong(error.to_string()))?;
        let [steps] = all.read_u64("steps").map_err(|error| wrong(error.to_string()))?;
        let mut numbers = [0.0; 4];
        all.read_f64("best", &mut numbers).map_err(|error| wrong(error.to_string()))?;
        let [score, relative_travel, seconds, log_std] = numbers;
        let mut travel_cost = [0.0];
        all.read_f32("travel_cost", &mut travel_cost).map_err(|error| wrong(error.to_string()))?;
        let [travel_cost] = travel_cost;
        // Checkpoints of earlier versions lack them.
        let comfort_weights = all.values_f32("comfort_weights").unwrap_or_default();
        let best = Rating { score, relative_travel };
        let (learner, collector) = (all.part("learner"), all.part("collector"));
        Ok(Some(Self { steps, best, seconds, log_std, travel_cost, comfort_weights, learner, collector }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_reads_back_as_it_was_and_a_damaged_one_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Checkpoint::read(folder.path()).unwrap(), None);
        let best = Rating { score: 0.9, relative_travel: 1.5 };
        let mut checkpoint = Checkpoint {
            steps: 7,
            best,
            seconds: 1.5,
            log_std: -2.0,
            travel_cost: 4.0,
            comfort_weights: vec![0.5, 3.0],
            ..Checkpoint::default()
        };
        checkpoint.learner.put_f32("weights", &[1.0, -0.0]);
        checkpoint.collector.put_u64("episodes", &[3]);
        checkpoint.write(folder.path()).unwrap();
        assert_eq!(Checkpoint::read(folder.path()).unwrap(), Some(checkpoint));
        let path = folder.path().join(CHECKPOINT);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(Checkpoint::read(folder.path()).unwrap_err().to_string().contains(CHECKPOINT));
        let mut flipped = bytes.clone();
        // The lowest byte of the last number.
        flipped[bytes.len() - 4] ^= 1;
        std::fs::write(&path, flipped).unwrap();
        let said = Checkpoint::read(folder.path()).unwrap_err().to_string();
        assert!(said.contains(CHECKPOINT) && said.contains("changed"), "{said}");
    }
}
