//! Replay of recorded actions.

use crate::Controller;

/// Replays a sequence of actions, and holds the last one after the end.
#[derive(Clone, Debug)]
pub struct Replay {
    actions: Vec<f64>,
    width: usize,
    step: usize,
}

impl Replay {
    /// Creates a replay of actions, one row of `width` values per step. At least one row is required.
    pub fn new(actions: Vec<f64>, width: usize) -> Self {
        Self { actions, width, step: 0 }
    }
}

impl Controller for Replay {
    fn reset(&mut self) {
        self.step = 0;
    }

    fn act(&mut self, _observation: &[f64], action: &mut [f64]) {
        let last = self.actions.len() / self.width - 1;
        let row = &self.actions[self.step.min(last) * self.width..][..self.width];
        action.copy_from_slice(row);
        self.step += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_action_is_held_after_the_end() {
        let mut replay = Replay::new(vec![1.0, 2.0, 3.0, 4.0], 2);
        let mut seen = Vec::new();
        for _ in 0..3 {
            let mut action = [0.0; 2];
            replay.act(&[], &mut action);
            seen.extend(action);
        }
        assert_eq!(seen, [1.0, 2.0, 3.0, 4.0, 3.0, 4.0]);
    }
}
