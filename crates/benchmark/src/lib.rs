//! The benchmark: problems, entries, their verification and the leaderboard.
//!
//! 1. [`problem`] has the problems and gives policies the spaces of one: training side, test side and protocol.
//! 2. [`entry`] runs a policy on a problem and verifies the result.
//! 3. [`leaderboard`] ranks results.

pub mod entry;
mod error;
pub mod leaderboard;
pub mod problem;

pub use error::{Error, Result};
pub use leaderboard::RankBy;
pub use problem::Problem;
