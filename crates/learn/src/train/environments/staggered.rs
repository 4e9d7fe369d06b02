//! Environments out of step with each other.

use b2b_workers::{Draw, Sampler};
use rand_chacha::ChaCha8Rng;

/// The draws of another sampler, with the first window of each environment cut short, so that environments are at
/// different hours of the day and their episodes end at different times. Otherwise a rollout of half a day would be
/// daytime for all or nighttime for all, and the critic would learn days and nights in turn.
pub(super) struct Staggered<S> {
    of: S,
    environments: usize,
    /// Steps for which the agent holds a decision.
    hold: usize,
    /// Which environments have drawn.
    has_drawn: Vec<bool>,
}

impl<S> Staggered<S> {
    pub(super) fn new(of: S, environments: usize, hold: usize) -> Self {
        Self { of, environments, hold, has_drawn: vec![false; environments] }
    }
}

impl<S: Sampler> Sampler for Staggered<S> {
    fn draw(&mut self, environment: usize, random: &mut ChaCha8Rng) -> b2b_env::Result<Draw> {
        let mut draw = self.of.draw(environment, random)?;
        let is_first = !std::mem::replace(&mut self.has_drawn[environment], true);
        if let Some(steps) = draw.steps.as_mut().filter(|_| is_first) {
            let day = 24 * draw.setting.episode.steps_per_hour as usize;
            *steps = first_length(*steps, day, (environment, self.environments), self.hold);
        }
        Ok(draw)
    }

    fn restart(&mut self) {
        self.has_drawn.fill(false);
        self.of.restart();
    }
}

/// Returns the steps of the first episode of an environment of several: whole days and a part of a day that differs
/// between environments, in whole decisions, but no more than the whole episode.
fn first_length(whole: usize, day: usize, (environment, environments): (usize, usize), hold: usize) -> usize {
    let days = (whole / day).saturating_sub(1) * environment / environments;
    let part = day * (environment + 1) / environments / hold * hold;
    ((1 + days) * day + part).min(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_episodes_end_on_different_days_at_different_hours() {
        let steps: Vec<usize> =
            (0..7).map(|environment| first_length(14 * 288, 288, (environment, 7), 1)).collect();
        let days: Vec<usize> = steps.iter().map(|steps| steps / 288).collect();
        let hours: Vec<usize> = steps.iter().map(|steps| steps % 288 / 12).collect();
        assert_eq!(days, [1, 2, 4, 6, 8, 10, 13]);
        assert_eq!(hours, [3, 6, 10, 13, 17, 20, 0]);
        assert_eq!(first_length(4032, 288, (0, 1), 1), 576);
        // With a decision every hour, whole hours.
        assert_eq!([1, 12].map(|hold| first_length(4032, 288, (0, 7), hold)), [329, 324]);
        // An episode of a day, or less, stays as it is.
        assert_eq!([first_length(288, 288, (3, 7), 1), first_length(12, 288, (0, 7), 1)], [288, 12]);
    }
}
