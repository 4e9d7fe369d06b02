//! A recorded episode.

use std::borrow::Cow;
use std::sync::Arc;

use b2b_building::{Conditioning, Zone};
use b2b_env::{Pair, Spaces, Target, Trajectory};

use crate::subject::{SiteInfo, Subject};

/// A recorded episode.
#[derive(Clone)]
pub(super) struct Recording {
    /// The observation before the first step.
    pub(super) first_observation: Vec<f64>,
    /// All steps.
    pub(super) trajectory: Trajectory,
}

/// A recorded episode and its spaces, as [`Evaluation::record`](super::Evaluation::record) passes it on.
pub struct Recorded<'a> {
    /// The building.
    pub subject: &'a Subject,
    /// Its site.
    pub site: &'a SiteInfo,
    /// Spaces of the environment.
    pub spaces: &'a Arc<Spaces>,
    /// The observation before the first step.
    pub first_observation: &'a [f64],
    /// All steps.
    pub trajectory: &'a Trajectory,
}

/// A controlled zone in an observation.
pub(super) struct ControlledZone {
    /// Index of its temperature.
    pub(super) slot: usize,
    /// Its target.
    target: Target,
    /// Whether its target is a band.
    has_band: bool,
    /// Whether it has both heating and cooling.
    pub(super) fully_conditioned: bool,
}

impl ControlledZone {
    /// Returns its setpoints for the step after an observation; both are the target where there is no band.
    pub(super) fn setpoints(&self, before: &[f64]) -> Pair {
        self.target.pair_of(before, self.has_band)
    }

    /// Returns its deviation at the end of a step from the target observed before, K; 0 within a band.
    pub(super) fn deviation(&self, before: &[f64], end: &[f64]) -> f64 {
        let (Pair { heating, cooling }, temperature) = (self.setpoints(before), end[self.slot]);
        temperature - temperature.max(heating).min(cooling)
    }
}

impl Recording {
    /// Returns the recording as sensors without errors would have made it.
    pub(super) fn with_true_temperatures(&self, spaces: &Spaces) -> Cow<'_, Self> {
        if spaces.episode.task.faults.is_none() {
            return Cow::Borrowed(self);
        }
        let mut all = self.clone();
        let ends = all.trajectory.observations.chunks_exact_mut(all.first_observation.len());
        spaces.remove_sensor_errors(std::iter::once(all.first_observation.as_mut_slice()).chain(ends));
        Cow::Owned(all)
    }

    /// Returns the observations before and after each step.
    pub(super) fn steps(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let ends = self.trajectory.observations.chunks_exact(self.first_observation.len());
        std::iter::once(self.first_observation.as_slice()).chain(ends.clone()).zip(ends)
    }
}

/// Returns the controlled zones of a building in model order.
pub(super) fn controlled_zones(spaces: &Spaces) -> Vec<ControlledZone> {
    let zones = spaces.building.zones.iter().enumerate();
    let controlled = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None);
    let zone = |(number, (slot, zone)): (usize, (usize, &Zone))| ControlledZone {
        slot,
        target: spaces.observation.target(number),
        has_band: spaces.episode.task.is_operation(),
        fully_conditioned: zone.conditioning == Conditioning::HeatingAndCooling,
    };
    controlled.enumerate().map(zone).collect()
}
