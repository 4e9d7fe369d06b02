//! The task of a command that is given none.

use b2b_env::{Band, Task};

/// Returns the task of an episode unless another one is given: operation with the bands of the building's own
/// thermostats.
pub fn usual() -> Task {
    Task::operate(Band::Own)
}
