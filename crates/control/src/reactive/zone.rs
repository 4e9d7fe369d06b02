//! The slots of a zone in the observation.

use b2b_env::Target;

/// Observation slots that the control loop of a zone needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneSlots {
    /// Slot of the air temperature.
    pub(super) temperature: usize,
    pub(super) target: Target,
}
