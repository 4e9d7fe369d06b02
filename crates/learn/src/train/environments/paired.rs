//! Environments in pairs, with the same episodes.

use b2b_workers::{Draw, Sampler};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A sampler whose draws are the same for both environments of a pair: 0 and 1, 2 and 3, and so on.
pub(super) struct Paired<S> {
    /// A sampler for the first environment of every pair, and an equal one for the second.
    samplers: [S; 2],
    seed: u64,
    /// The random stream of each environment, the same for both of a pair.
    random: Vec<ChaCha8Rng>,
}

impl<S> Paired<S> {
    /// Pairs environments, given two equal samplers.
    pub(super) fn new(samplers: [S; 2], seed: u64) -> Self {
        Self { samplers, seed, random: Vec::new() }
    }
}

impl<S: Sampler> Sampler for Paired<S> {
    fn draw(&mut self, environment: usize, _: &mut ChaCha8Rng) -> b2b_env::Result<Draw> {
        for number in self.random.len()..=environment {
            let mut random = ChaCha8Rng::seed_from_u64(self.seed);
            random.set_stream((number / 2) as u64);
            self.random.push(random);
        }
        self.samplers[environment % 2].draw(environment / 2, &mut self.random[environment])
    }

    fn restart(&mut self) {
        self.random.clear();
        self.samplers.iter_mut().for_each(Sampler::restart);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    #[test]
    fn pairs_draw_alike_in_any_order_and_again_after_a_restart() {
        let mut drawn = Vec::new();
        let sampler = || {
            |pair: usize, random: &mut ChaCha8Rng| -> b2b_env::Result<Draw> {
                let (name, why) = (pair.to_string(), random.random_range(0..1_000_000).to_string());
                Err(b2b_env::Error::Template { name, why })
            }
        };
        let mut paired = Paired::new([sampler(), sampler()], 5);
        let mut unused = ChaCha8Rng::seed_from_u64(0);
        for environment in [0, 3, 2, 1, 1, 0] {
            drawn.push(paired.draw(environment, &mut unused).unwrap_err().to_string());
        }
        assert_eq!((&drawn[0], &drawn[1], &drawn[5]), (&drawn[3], &drawn[2], &drawn[4]));
        assert!(drawn[0] != drawn[1] && drawn[0] != drawn[5], "{drawn:?}");
        paired.restart();
        assert_eq!(paired.draw(1, &mut unused).unwrap_err().to_string(), drawn[0]);
    }
}
