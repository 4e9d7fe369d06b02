//! Staging of a unit's capacity: between two stages, either the flow or the temperature difference changes.

/// A stage: flow, as a share of the design flow, and temperature difference between the supply air and the setpoint
/// that the loop aims at, K. Their product is the capacity, K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stage {
    pub(super) flow: f64,
    pub(super) difference: f64,
}

impl Stage {
    /// Returns the capacity, K: negative if the supply air acts against the loop.
    pub(super) fn capacity(self) -> f64 {
        self.flow * self.difference
    }
}

/// Returns the flow and the temperature difference for a loop output from 0 to 1. The capacity is linear in the output,
/// from the first stage's capacity to the last stage's.
pub(super) fn staged<const STAGES: usize>(output: f64, stages: [Stage; STAGES]) -> Stage {
    let [first, last] = [stages[0], stages[STAGES - 1]].map(Stage::capacity);
    let capacity = first + output * (last - first);
    for pair in stages.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if capacity <= to.capacity() {
            return match from.flow == to.flow {
                true => Stage { flow: from.flow, difference: capacity / from.flow },
                false => Stage { flow: capacity / from.difference, difference: from.difference },
            };
        }
    }
    stages[STAGES - 1]
}
