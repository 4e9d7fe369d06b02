//! A policy with noise on its actions, for datasets of graded quality.

use b2b_agent::ControllerDescription;
use b2b_building::Controls;
use b2b_control::{Controller, Noise, Noisy};
use b2b_env::{Spaces, Task};
use serde_json::Value;

use super::interface::{EpisodeContext, Policy};
use crate::{Error, Result};

/// Separator of the name of a policy and the level of its noise.
const SEPARATOR: &str = "+noise";

/// A policy with noise that is drawn every hour from the seed of the episode: `reactive+noise0.2`.
pub struct NoisyPolicy {
    policy: Box<dyn Policy>,
    level: f64,
}

/// Returns the name of a policy without its noise.
pub fn without_noise(name: &str) -> &str {
    name.rsplit_once(SEPARATOR).map_or(name, |(policy, _)| policy)
}

impl NoisyPolicy {
    /// Returns the name of the policy and the level of the noise in a name such as `reactive+noise0.2`.
    ///
    /// # Errors
    /// [`Error::NoiseLevel`] for a level that is not from 0 to 2.
    pub(super) fn parts(text: &str) -> Result<Option<(&str, f64)>> {
        let Some((name, level)) = text.rsplit_once(SEPARATOR) else { return Ok(None) };
        let parsed = level.parse().ok().filter(|level| (0.0..=2.0).contains(level));
        let level = parsed.ok_or_else(|| Error::NoiseLevel { text: level.to_owned() })?;
        Ok(Some((name, level)))
    }

    /// Adds noise to a policy.
    ///
    /// # Errors
    /// [`Error::NoiseWithoutActuators`] for a policy that commands no actuators.
    pub(super) fn new(policy: Box<dyn Policy>, level: f64) -> Result<Self> {
        match policy.controls() {
            Controls::Own => Err(Error::NoiseWithoutActuators { policy: policy.name() }),
            Controls::Actuators | Controls::Setpoints => Ok(Self { policy, level }),
        }
    }

    fn noise(&self, spaces: &Spaces, seed: u64) -> Noise {
        Noise { level: self.level, steps: spaces.episode.steps_per_hour, seed }
    }
}

impl Policy for NoisyPolicy {
    fn name(&self) -> String {
        format!("{}{SEPARATOR}{}", self.policy.name(), self.level)
    }

    fn identity(&self) -> String {
        format!("{}{SEPARATOR}{}", self.policy.identity(), self.level)
    }

    fn controls(&self) -> Controls {
        self.policy.controls()
    }

    fn ignores_interface(&self) -> bool {
        self.policy.ignores_interface()
    }

    fn trained_task(&self) -> Option<&Task> {
        self.policy.trained_task()
    }

    fn observation_width(&self) -> Option<usize> {
        self.policy.observation_width()
    }

    fn has_memory(&self) -> bool {
        self.policy.has_memory()
    }

    fn keeps_memory(&self) -> bool {
        self.policy.keeps_memory()
    }

    fn description(&self, context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        let Some(of) = self.policy.description(context)? else { return Ok(None) };
        let of = serde_json::from_value(of).expect("it is the description of a controller");
        let noise = self.noise(context.spaces, context.seed);
        let noisy = ControllerDescription::Noisy { of: Box::new(of), noise };
        Ok(Some(serde_json::to_value(noisy).expect("a description is plain data")))
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let noise = self.noise(context.spaces, context.seed);
        let space = context.interface.action.clone();
        Ok(Box::new(Noisy::new(self.policy.controller(context)?, &space, noise)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ActionScale;

    #[test]
    fn a_name_has_a_policy_and_a_level() {
        let named = |text: &str| <dyn Policy>::named(text, ActionScale::Rescaled);
        let noisy = named("guideline36+noise0.25").unwrap();
        assert_eq!(noisy.name(), "guideline36+noise0.25");
        assert!(noisy.identity().starts_with("guideline36") && noisy.identity() != "guideline36");
        let task = "operate".parse().unwrap();
        assert!(named("guideline36").unwrap().is_baseline(&task) && !noisy.is_baseline(&task));
        for (wrong, word) in [
            ("reactive+noise-1", "-1"),
            ("reactive+noisex", "`x`"),
            ("reactiv+noise0.1", "reactiv"),
            ("own+noise0.1", "`own` commands no actuators"),
        ] {
            let said = named(wrong).err().unwrap().to_string();
            assert!(said.contains(word), "{said}");
        }
    }
}
