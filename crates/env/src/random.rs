//! Random streams of a seed.
//!
//! Setpoints use one stream per zone and day, sensor noise one per step, other faults the last three, presence the
//! streams from 2^40 on, and forecast errors those from 2^41 on.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Returns a stream of a seed.
pub(crate) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}
