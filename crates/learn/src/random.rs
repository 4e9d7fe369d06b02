//! Random numbers with a state that can be saved. Uniform ones are the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct RandomStream(ChaCha8Rng);

impl RandomStream {
    /// Number of words of [`RandomStream::words`].
    pub const WORDS: usize = 7;

    /// Returns the stream of a seed with this number.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self(random)
    }

    /// Draws a uniform number from 0 (included) to 1 (excluded), on 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Draws a whole number from 0 to `end - 1`.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.0.next_u64()) * end as u128) >> 64) as usize
    }

    /// Draws a standard normal number by the Box-Muller transform (Box and Muller 1958), from two uniform ones.
    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }

    /// Draws standard normal numbers.
    pub fn normals(&mut self, values: &mut [f32]) {
        values.iter_mut().for_each(|value| *value = self.normal() as f32);
    }

    /// Shuffles values (Fisher-Yates).
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.below(last + 1));
        }
    }

    /// Returns the state: seed, stream and position.
    pub fn words(&self) -> [u64; Self::WORDS] {
        let mut words = [0; Self::WORDS];
        for (word, bytes) in words.iter_mut().zip(self.0.get_seed().as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*bytes);
        }
        let position = self.0.get_word_pos();
        words[4..].copy_from_slice(&[self.0.get_stream(), position as u64, (position >> 64) as u64]);
        words
    }

    /// Returns the stream with the state that [`RandomStream::words`] returned.
    pub fn from_words(words: [u64; Self::WORDS]) -> Self {
        let mut seed = [0; 32];
        for (bytes, word) in seed.as_chunks_mut::<8>().0.iter_mut().zip(words) {
            *bytes = word.to_le_bytes();
        }
        let mut random = ChaCha8Rng::from_seed(seed);
        random.set_stream(words[4]);
        random.set_word_pos(u128::from(words[5]) | u128::from(words[6]) << 64);
        Self(random)
    }
}

/// Standard normal noise of the actions of one environment, correlated from step to step.
///
/// Each number is ρ × the previous one + √(1 - ρ²) × a new one: an autoregressive process of first order with
/// variance 1. A ρ of 0 is independent noise. Action densities still assume independent noise.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Correlation ρ between consecutive steps, from 0 to 1.
    pub correlation: f32,
    random: RandomStream,
    values: Vec<f32>,
    /// 1, or -1 for mirrored noise.
    sign: f32,
}

impl Noise {
    /// Returns the noise of `actions` actions.
    pub fn new(actions: usize, correlation: f32, mut random: RandomStream) -> Self {
        let mut values = vec![0.0; actions];
        random.normals(&mut values);
        Self { correlation, random, values, sign: 1.0 }
    }

    /// Returns the noise of opposite sign.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        self.values.iter_mut().for_each(|value| *value = -*value);
        Self { sign: -self.sign, ..self }
    }

    /// Draws the numbers of the next step, one per action, as [`Actor::sample`](b2b_agent::network::Actor::sample)
    /// takes them.
    pub fn draw(&mut self) -> &[f32] {
        let innovation = self.sign * (1.0 - self.correlation * self.correlation).max(0.0).sqrt();
        for value in &mut self.values {
            *value = self.correlation * *value + innovation * self.random.normal() as f32;
        }
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restored_stream_continues() {
        let mut random = RandomStream::new(5, 2);
        for _ in 0..37 {
            random.normal();
        }
        let mut restored = RandomStream::from_words(random.words());
        for _ in 0..100 {
            assert_eq!(random.uniform(), restored.uniform());
        }
    }

    #[test]
    fn normal_numbers_have_mean_0_and_deviation_1() {
        let mut random = RandomStream::new(1, 0);
        let numbers: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        let mean = numbers.iter().sum::<f64>() / 20_000.0;
        let variance = numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
    }

    #[test]
    fn correlated_noise_has_variance_1_and_its_correlation() {
        let mut noise = Noise::new(1, 0.8, RandomStream::new(3, 0));
        let numbers: Vec<f32> = (0..50_000).map(|_| noise.draw()[0]).collect();
        let product = |lag: usize| {
            numbers.iter().zip(&numbers[lag..]).map(|(a, b)| f64::from(a * b)).sum::<f64>() / 50_000.0
        };
        assert!((product(0) - 1.0).abs() < 0.05, "{}", product(0));
        assert!((product(1) - 0.8).abs() < 0.05, "{}", product(1));
        assert!((product(2) - 0.64).abs() < 0.05, "{}", product(2));
    }

    #[test]
    fn a_shuffle_keeps_all_values() {
        let mut values: Vec<usize> = (0..100).collect();
        RandomStream::new(0, 0).shuffle(&mut values);
        assert_ne!(values, (0..100).collect::<Vec<_>>());
        values.sort_unstable();
        assert_eq!(values, (0..100).collect::<Vec<_>>());
    }
}
