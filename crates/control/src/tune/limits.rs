//! Limits of actuator travel and loss.

/// Limits for a set of parameters in every cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest travel of actuators, full strokes/day, or the travel under the defaults if that is larger.
    pub(super) travel: f64,
    /// Relative increase of the loss over the loss of the defaults.
    pub(super) increase: f64,
}

impl Limits {
    /// The limits of unitary systems. A target that jumps up and down once a day moves an actuator there and back
    /// twice: four strokes.
    pub(super) const UNITARY: Self = Self { travel: 5.0, increase: 0.1 };
    /// The limits of central air loops. Their defaults hold constant targets to 0.06 to 0.1 K; 1.5 times their loss
    /// corresponds to 0.16 to 0.19 K, which a sensor does not resolve.
    pub(super) const AIR_LOOP: Self = Self { travel: 5.0, increase: 0.5 };
    /// The same, with a margin for buildings outside the search.
    pub(super) const AIR_LOOP_SEARCH: Self = Self { travel: 4.0, increase: 0.2 };
}
