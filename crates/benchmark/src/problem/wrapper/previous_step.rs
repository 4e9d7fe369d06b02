//! The previous step, observed by a policy that keeps its memory over the episodes in a building.

use b2b_env::{ActionSpace, unscale};

/// The previous step of an episode, as it follows an observation:
///
/// | values | quantity | in the first step of an episode |
/// |---|---|---|
/// | one per actuator of the policy | its previous action, scaled from the actuator's bounds to [-1, 1] | 0 |
/// | 1 | its reward | 0 |
/// | 1 | whether this is the first step | 1 |
///
/// Writing it allocates nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct PreviousStep {
    /// Its values; none for a policy that does not observe it.
    values: Vec<f64>,
}

impl PreviousStep {
    /// Returns the previous step of a policy with these actuators, before the first step.
    pub(super) fn of(action: &ActionSpace) -> Self {
        let mut step = Self { values: vec![0.0; action.len() + 2] };
        step.reset();
        step
    }

    /// Returns the names of the values.
    pub(super) fn names(&self, action: &ActionSpace) -> Vec<String> {
        let actions = action.names().iter().map(|name| format!("previous {name}"));
        actions
            .chain(["previous reward".to_owned(), "first step".to_owned()])
            .take(self.values.len())
            .collect()
    }

    /// Returns the number of values.
    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// Writes the values.
    pub(super) fn write(&self, row: &mut [f64]) {
        row.copy_from_slice(&self.values);
    }

    /// Begins an episode.
    pub(super) fn reset(&mut self) {
        self.values.fill(0.0);
        if let [.., first] = &mut self.values[..] {
            *first = 1.0;
        }
    }

    /// Takes the action of a step, in physical units.
    pub(super) fn acted(&mut self, given: &[f64], action: &ActionSpace) {
        let [values @ .., _, first] = &mut self.values[..] else { return };
        let bounds = action.low().iter().zip(action.high());
        for ((value, given), (low, high)) in values.iter_mut().zip(given).zip(bounds) {
            *value = unscale(*given, *low, *high).clamp(-1.0, 1.0);
        }
        *first = 0.0;
    }

    /// Takes the reward of the step.
    pub(super) fn rewarded(&mut self, reward: f64) {
        if let [.., last, _] = &mut self.values[..] {
            *last = reward;
        }
    }
}
