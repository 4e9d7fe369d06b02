//! Random numbers that are the same on every machine and with every version of the random-number crates.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Returns the stream of a name, a seed and a number. Only the first 24 bytes of the name are used.
pub fn stream(name: &str, seed: u64, number: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    let (head, tail) = key.split_at_mut(24);
    head.iter_mut().zip(name.bytes()).for_each(|(byte, letter)| *byte = letter);
    tail.copy_from_slice(&seed.to_le_bytes());
    let mut random = ChaCha8Rng::from_seed(key);
    random.set_stream(number);
    random
}

/// Draws a uniform number from 0 (included) to 1 (excluded), with 53 bits.
pub fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Draws a standard normal number by the Box–Muller transform (Box and Muller 1958), from two uniform ones.
///
/// Targets of tasks depend on these bits. The planner of `b2b-control` keeps its own polar method, because published
/// results depend on its draws.
pub fn standard_normal(random: &mut ChaCha8Rng) -> f64 {
    let (radius, angle) = (1.0 - uniform(random), uniform(random));
    (-2.0 * libm::log(radius)).sqrt() * libm::cos(std::f64::consts::TAU * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn standard_normal_numbers_have_mean_0_deviation_1_and_normal_tails() {
        const COUNT: usize = 20_000;
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let numbers: Vec<f64> = (0..COUNT).map(|_| standard_normal(&mut random)).collect();
        let mean = numbers.iter().sum::<f64>() / COUNT as f64;
        let variance = numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>() / COUNT as f64;
        let beyond_two = numbers.iter().filter(|number| number.abs() > 2.0).count() as f64 / COUNT as f64;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
        assert!((beyond_two - 0.0455).abs() < 0.006, "{beyond_two}");
    }

    #[test]
    fn the_stream_is_the_same_on_every_machine() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let first = [uniform(&mut random), standard_normal(&mut random)];
        let mut again = ChaCha8Rng::seed_from_u64(7);
        assert_eq!(first, [uniform(&mut again), standard_normal(&mut again)]);
    }
}
