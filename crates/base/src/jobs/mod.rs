//! Lists of jobs.

pub mod parallel;
pub mod shard;
