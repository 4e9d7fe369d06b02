//! Gains that shrink while a loop hunts.
//!
//! How far full heating takes a zone within a step depends on its capacity, its air and its walls, which no model
//! states. A gain that is too large for it shows: heating or cooling and idling alternate, step by step. An engineer
//! would turn the gain down until they stop, and so does this, separately in occupied mode and in the others, whose
//! flows differ.

/// Smallest change of the temperature within a step that counts, K: a thermometer does not show smaller ones.
const CHANGE: f64 = 0.2;
/// Last steps in which reversals are counted.
const STEPS: u32 = 12;
/// Reversals in these steps from which a loop hunts. People and the sun reverse a zone a few times.
const REVERSALS: u32 = 6;
/// Factor by which the gains of a loop that hunts shrink.
const SHRINKING: f64 = 0.7;
/// Smallest share of the gains that is left.
const LEAST: f64 = 0.1;

/// The share of its gains that a zone uses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hunting {
    /// Air temperature of the last step, °C.
    last: f64,
    /// Its change in that step, K.
    change: f64,
    /// The steps in which it reversed, a bit each, the last one lowest.
    reversals: u32,
    /// Whether the mode was occupied.
    occupied: bool,
    /// Shares in other modes and in occupied mode.
    shares: [f64; 2],
}

impl Hunting {
    pub(super) fn new() -> Self {
        Self { last: f64::NAN, change: 0.0, reversals: 0, occupied: false, shares: [1.0; 2] }
    }

    /// Returns the share of the gains that is stable, for the temperature (°C) of a step.
    pub(super) fn step(&mut self, temperature: f64, occupied: bool) -> f64 {
        if self.occupied != occupied {
            (self.occupied, self.reversals) = (occupied, 0);
        }
        let share = &mut self.shares[usize::from(occupied)];
        let change = temperature - self.last;
        let reverses = change * self.change < 0.0 && change.abs().min(self.change.abs()) > CHANGE;
        self.reversals = (self.reversals << 1 | u32::from(reverses)) & ((1 << STEPS) - 1);
        if self.reversals.count_ones() == REVERSALS {
            self.reversals = 0;
            *share = (*share * SHRINKING).max(LEAST);
        }
        (self.last, self.change) = (temperature, change);
        *share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share_after(temperatures: &[f64]) -> f64 {
        let mut hunting = Hunting::new();
        temperatures.iter().map(|temperature| hunting.step(*temperature, true)).last().unwrap()
    }

    #[test]
    fn only_frequent_reversals_of_tenths_of_a_kelvin_shrink_the_gains() {
        let cycle =
            |cycle: &[f64], steps: usize| -> Vec<f64> { cycle.iter().copied().cycle().take(steps).collect() };
        assert_eq!(share_after(&cycle(&[20.0, 22.0], 7)), 1.0);
        assert_eq!(share_after(&cycle(&[20.0, 22.0], 8)), SHRINKING);
        assert_eq!(share_after(&cycle(&[20.0, 22.0, 21.0], 12)), SHRINKING, "heats fast, cools slowly");
        assert_eq!(share_after(&cycle(&[20.0, 20.1], 100)), 1.0, "too small");
        assert_eq!(share_after(&cycle(&[20.0, 21.0, 22.0, 23.0, 22.0, 21.0], 100)), 1.0, "too slow");
        assert_eq!(share_after(&cycle(&[20.0, 22.0], 1000)), LEAST);
    }

    #[test]
    fn gains_of_a_mode_stay_when_another_hunts() {
        let mut hunting = Hunting::new();
        for step in 0..8 {
            hunting.step(20.0 + f64::from(step % 2), false);
        }
        assert_eq!([hunting.step(20.0, true), hunting.step(20.0, false)], [1.0, SHRINKING]);
    }
}
