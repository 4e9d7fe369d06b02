//! The decisions behind a controller's actions: modes, setpoints and requests, by name.

use crate::environment::Step;
use crate::rollout::Observer;
use crate::{Controller, Result};

/// One slot of a controller's decisions.
#[derive(Clone, Debug, PartialEq)]
pub struct DecisionSlot {
    /// Name, such as `PACU_VAV_bot mode`.
    pub name: String,
    /// Unit; `1` where there is none.
    pub unit: &'static str,
    /// Name of its zone; `None` for a system's slot.
    pub zone: Option<String>,
    /// Names of the states for the values 1, 2, …; empty for a quantity.
    pub states: &'static [&'static str],
}

/// The decisions behind the last action of a controller.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decisions {
    slots: Vec<DecisionSlot>,
    /// One value per slot.
    pub values: Vec<f64>,
}

/// The decisions behind every action of an episode. They are not part of its trajectory or its hash.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DecisionLog {
    slots: Vec<DecisionSlot>,
    /// Row-major, one row per step.
    rows: Vec<f64>,
}

impl Decisions {
    /// Adds a slot with the value 0.
    pub fn add(&mut self, slot: DecisionSlot) {
        self.slots.push(slot);
        self.values.push(0.0);
    }

    /// The slots, in the order of the values.
    pub fn slots(&self) -> &[DecisionSlot] {
        &self.slots
    }
}

impl DecisionLog {
    /// Returns an empty log with room for the decisions of an episode.
    pub fn for_episode(controller: &dyn Controller, steps: usize) -> Self {
        let slots = controller.record().map(|decisions| decisions.slots().to_vec()).unwrap_or_default();
        Self { rows: Vec::with_capacity(slots.len() * steps), slots }
    }

    /// The slots; none for a controller without decisions.
    pub fn slots(&self) -> &[DecisionSlot] {
        &self.slots
    }

    /// The values of a slot, one per step.
    pub fn values(&self, slot: usize) -> impl Iterator<Item = f64> {
        self.rows.iter().skip(slot).step_by(self.slots.len().max(1)).copied()
    }
}

impl Observer for DecisionLog {
    fn decided(&mut self, decisions: &Decisions) {
        self.rows.extend_from_slice(&decisions.values);
    }

    fn step(&mut self, _: &Step<'_>) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts its actions.
    struct Counter(Decisions);

    impl Controller for Counter {
        fn reset(&mut self) {}

        fn act(&mut self, _: &[f64], _: &mut [f64]) {
            self.0.values[1] += 1.0;
        }

        fn record(&self) -> Option<&Decisions> {
            Some(&self.0)
        }
    }

    #[test]
    fn a_log_has_the_values_of_every_action() {
        let mut decisions = Decisions::default();
        for name in ["idle", "count"] {
            decisions.add(DecisionSlot { name: name.into(), unit: "1", zone: None, states: &[] });
        }
        let mut controller = Counter(decisions);
        let mut log = DecisionLog::for_episode(&controller, 3);
        for _ in 0..3 {
            controller.act(&[], &mut []);
            log.decided(controller.record().unwrap());
        }
        assert_eq!(log.values(1).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
        assert_eq!(log.values(0).collect::<Vec<_>>(), [0.0; 3]);
        assert_eq!(log.slots()[1].name, "count");
    }
}
