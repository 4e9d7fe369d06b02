//! Points of a run at which it is suspended.

/// Point of the run at which [`Simulation::advance`](crate::Simulation::advance) returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Before the first zone time step of warm-up: handles can be requested and actuators set.
    Started,
    /// End of a zone time step of warm-up (only with [`Run::yield_in_warmup`](crate::Run::yield_in_warmup)).
    WarmupStep,
    /// End of warm-up: the next step is the first of the run period.
    WarmedUp,
    /// End of a zone time step of the run period.
    Step,
}
