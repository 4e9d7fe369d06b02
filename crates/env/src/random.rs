//! Random streams of a seed.
//!
//! Setpoints draw from the stream of a zone and day, the noise of sensors from that of a step, other faults from the last two,
//! and presence from those that start at 2^40.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Returns a stream of a seed.
pub(crate) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(number);
    random
}
