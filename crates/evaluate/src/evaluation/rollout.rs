//! One episode, from its first step to its last.

use std::sync::Arc;
use std::time::{Duration, Instant};

use b2b_control::Controller;
use b2b_env::{Environment, Inputs, Observer, Spaces, Step, Trajectory, rollout, rollout_next};

use super::bench::{Bench, Located};
use super::episode::EpisodePlan;
use super::finished::Finished;
use super::info::EpisodeInfo;
use super::parallel::Work;
use super::recording::{Recorded, Recording};
use crate::policy::{self, EpisodeContext, PolicyInterface};
use crate::{Error, Result};

/// The controller of a sequence, which keeps its memory from one episode to the next; `None` before the first, and for
/// a policy that does not keep its memory.
pub(super) type SequenceController = Option<Box<dyn Controller>>;

/// Runs an episode.
pub(super) fn run(
    bench: &mut Bench,
    (number, episode): (usize, &EpisodePlan),
    memory: &mut SequenceController,
    work: &Work<'_>,
) -> Result<Finished> {
    let mut environment = bench.workers.episode(&bench.setting(episode)?)?;
    let spaces = Arc::clone(environment.spaces());
    let context = EpisodeContext {
        subject: &bench.located.subject,
        site: &bench.located.site,
        spaces: &spaces,
        interface: &PolicyInterface::of(&spaces),
        seed: episode.seed,
        episode: &mut environment,
    };
    let mut recorder = Recorder::new(&spaces, work);
    let ran = if work.policy.keeps_memory() {
        // In this process, because a worker's controller ends with its episode.
        match memory {
            Some(controller) => rollout_next(&mut environment, controller.as_mut(), &mut recorder),
            none => {
                let controller = none.insert(policy::controller(work.policy, context)?);
                rollout(&mut environment, controller.as_mut(), &mut recorder)
            }
        }
    } else if let Some(description) = work.policy.description(&context)? {
        environment.rollout(&description, &mut bench.memory, &mut recorder)
    } else {
        let mut controller = policy::controller(work.policy, context)?;
        rollout(&mut environment, controller.as_mut(), &mut recorder)
    };
    let metrics = ran.map_err(|error| match error {
        b2b_env::Error::Interrupted => Error::Interrupted,
        error => error.into(),
    })?;
    let Recording { first_observation, trajectory } = &recorder.recording;
    let Located { subject, site, .. } = &*bench.located;
    (work.recorded)(number, &Recorded { subject, site, spaces: &spaces, first_observation, trajectory })?;
    let info = EpisodeInfo::of_run(episode, work.policy, &spaces, &bench.located.site);
    let inputs = match &mut bench.inputs {
        Some(inputs) => inputs,
        none => none.insert(Inputs::of(&spaces)?),
    };
    bench.prepared.get_or_insert_with(|| Arc::clone(&spaces.building));
    Ok(Finished::new(info, inputs.clone(), &spaces, &metrics, &recorder.recording))
}

/// Records an episode, reports simulated days, and ends it when the evaluation is interrupted.
struct Recorder<'a> {
    recording: Recording,
    work: &'a Work<'a>,
    steps_per_day: usize,
    checked: Instant,
}

/// Interval at which an episode checks whether the evaluation is interrupted, however slow its policy is.
const CHECK: Duration = Duration::from_millis(500);

impl<'a> Recorder<'a> {
    fn new(spaces: &Spaces, work: &'a Work<'a>) -> Self {
        let trajectory = Trajectory::for_episode(spaces);
        let recording = Recording { first_observation: Vec::new(), trajectory };
        Self {
            recording,
            work,
            steps_per_day: 24 * spaces.episode.steps_per_hour as usize,
            checked: Instant::now(),
        }
    }

    fn check(&self) -> b2b_env::Result<()> {
        self.work.check().map_err(|_| b2b_env::Error::Interrupted)
    }
}

impl Observer for Recorder<'_> {
    fn begin(&mut self, observation: &[f64]) -> b2b_env::Result<()> {
        self.recording.first_observation = observation.to_vec();
        self.check()
    }

    fn step(&mut self, step: &Step<'_>) -> b2b_env::Result<()> {
        self.recording.trajectory.push(step);
        if self.recording.trajectory.len().is_multiple_of(self.steps_per_day) {
            self.work.progress.day();
            self.check()?;
        } else if self.checked.elapsed() > CHECK {
            self.checked = Instant::now();
            self.check()?;
        }
        Ok(())
    }
}
