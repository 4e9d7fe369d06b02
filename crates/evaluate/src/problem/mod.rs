//! Benchmark problems as data: training side, test side and protocol.
//!
//! 1. A [`Problem`] has two [`Side`]s, training and test, each with buildings, tasks and actuators, and a [`Protocol`].
//!    The named ones are JSON files under `data/problems`; a user's own file has the same format.
//! 2. [`Problem::check`] rejects a problem that cannot measure generalization, such as one that trains on test
//!    buildings.
//! 3. [`Changes`] derive another problem, for example with other run periods; its [`Problem::hash`] differs.

mod as_text;
mod buildings;
mod changes;
mod check;
mod definition;
mod list;
mod protocol;
mod restriction;
mod shipped;
mod side;
mod stage;

pub use buildings::{Buildings, Subset};
pub use changes::{Changes, differences};
pub use definition::{Family, Problem};
pub use protocol::{Attributes, Memory, Protocol};
pub use restriction::{Fallback, RestrictedAction, Restriction};
pub use side::{Side, Size};
pub use stage::Stage;

#[cfg(test)]
mod tests;
