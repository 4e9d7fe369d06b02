//! Building blocks for all crates: atomic file writes, folder locks, folders that are removed with their owner or if
//! they stay empty, lists of work in parallel and in parts, digests, random streams, evenly spread samples, the
//! calendar, energy carriers, suggestions for misspelled names, and the fingerprint of the machine's arithmetic.

#[cfg(not(target_os = "linux"))]
compile_error!("building2building runs on Linux only");

pub mod aside;
pub mod calendar;
pub mod carrier;
pub mod digest;
pub mod digest_list;
pub mod folder_lock;
mod jobs;
pub mod machine;
pub mod new_folders;
pub mod random;
pub mod scratch;
pub mod seal;
pub mod spread;
pub mod suggestion;

pub use jobs::{parallel, shard};
