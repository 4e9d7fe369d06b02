//! What all crates share: files written atomically, locks of folders, temporary folders that end with their owner, digests,
//! random streams, suggestions for misspelled names, and the fingerprint of the machine's arithmetic.

pub mod aside;
pub mod digest;
pub mod digest_list;
pub mod folder_lock;
pub mod machine;
pub mod random;
pub mod scratch;
pub mod seal;
pub mod suggestion;
