//! Draws with varying faults of sensors and equipment.

use b2b_env::Result;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Draw, Sampler};

/// The draws of another sampler with varying fault seeds, so that a learner sees more faults than there are buildings.
/// An environment keeps a seed for several episodes, as with the buildings of [`Kept`](super::Kept).
#[derive(Clone, Debug)]
pub struct WithFaults<S> {
    of: S,
    seeds: u64,
    episodes: u32,
    /// What each environment adds to the seed of its task, with the number of remaining episodes.
    current: Vec<(u64, u32)>,
}

impl<S> WithFaults<S> {
    /// Draws one of `seeds` seeds for every `episodes` episodes; the seeds follow the task's own. 0 `episodes`
    /// count as 1.
    pub fn new(of: S, seeds: u64, episodes: u32) -> Self {
        Self { of, seeds, episodes: episodes.max(1), current: Vec::new() }
    }
}

impl<S: Sampler> Sampler for WithFaults<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        if self.current.len() <= environment {
            self.current.resize(environment + 1, (0, 0));
        }
        let (seed, left) = &mut self.current[environment];
        if *left == 0 {
            (*seed, *left) = (random.random_range(1..=self.seeds), self.episodes);
        }
        *left -= 1;
        let faults = &mut draw.setting.episode.task.faults;
        faults.seed = faults.seed.wrapping_add(*seed);
        Ok(draw)
    }

    fn restart(&mut self) {
        self.current.clear();
        self.of.restart();
    }
}
