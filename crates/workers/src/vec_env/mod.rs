//! A batch of N environments, stepped synchronously or asynchronously.

pub(crate) mod statistics;
mod succession;

use std::sync::Arc;
use std::time::Instant;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use self::statistics::Statistics;
use super::episode::Episode;
use super::form::{Arrangement, EpisodeForm, Form, Padded};
use super::sampler::{Draw, Sampler};
use super::setting::EpisodeSetting;
use super::workers::worker_options::WorkerOptions;
use super::workers::{Reservation, Workers};
use b2b_env::Metrics;
use b2b_env::Spaces;
use b2b_env::{Amounts, Reward};
use b2b_env::{Error, Result};

/// When an environment begins its next episode, like Gymnasium's `AutoresetMode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Autoreset {
    /// With the step after the last one: that step's action is ignored, its reward is 0.
    #[default]
    NextStep,
    /// Within the last step: the observation is the first of the next episode; the last is in
    /// [`VecEnv::final_observation`].
    SameStep,
    /// Only by [`VecEnv::reset_one`].
    Disabled,
}

/// Options of a [`VecEnv`].
#[derive(Clone, Debug)]
pub struct VecEnvOptions {
    /// How its workers are run.
    pub workers: WorkerOptions,
    /// When the next episode begins.
    pub autoreset: Autoreset,
    /// Widths of a row of actions and a row of observations; `None` for the largest of the first buildings. Smaller
    /// buildings are padded with zeros; larger ones are lost.
    pub widths: Option<(usize, usize)>,
}

/// N environments, each in a worker process, with episodes drawn by a [`Sampler`].
///
/// - Observations: N rows, f64, padded with zeros to a common width; see [`VecEnv::spaces`] for the contents of a row.
/// - Actions: N rows, padded to a common width; values after a building's last actuator are ignored.
/// - A [`Form`] arranges both otherwise: see [`VecEnv::with_form`].
/// - The building of each environment's next episode is prepared while the current episode runs. If it is not ready in
///   time, the environment waits for it: see [`VecEnv::statistics`].
/// - An environment whose worker dies is *lost*: truncated with a reason, and reset like a finished one.
/// - The same seed and actions give the same bits, regardless of the speed of each environment.
///
/// A step allocates only at the end of an episode.
pub struct VecEnv {
    workers: Workers,
    autoreset: Autoreset,
    sampler: Box<dyn Sampler>,
    form: Box<dyn Form>,
    widths: (usize, usize),
    statistics: Statistics,
    environments: Vec<EnvState>,
    observations: Vec<f64>,
    rewards: Vec<Reward>,
    terms: Vec<Amounts>,
    truncated: Vec<bool>,
}

/// One environment.
struct EnvState {
    episode: Option<Episode>,
    state: State,
    random: ChaCha8Rng,
    next: Option<Next>,
    /// Start of its wait for a preparation.
    waiting: Option<Instant>,
    spaces: Option<Arc<Spaces>>,
    form: Option<Box<dyn EpisodeForm>>,
    /// The last action, in physical units.
    action: Vec<f64>,
    lost: Option<String>,
    final_observation: Vec<f64>,
    final_metrics: Option<Metrics>,
    fragment_steps: usize,
}

/// The next episode of an environment, and its template.
struct Next {
    draw: Draw,
    reservation: Reservation,
}

/// What an environment is waiting for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// An action.
    Ready,
    /// A reset: its episode is over.
    Over,
    /// The end of a step.
    Stepping,
    /// The preparation of its next episode.
    Preparing,
    /// The beginning of its next episode.
    Starting,
}

impl EnvState {
    fn new() -> Self {
        Self {
            episode: None,
            state: State::Over,
            random: ChaCha8Rng::seed_from_u64(0),
            next: None,
            waiting: None,
            spaces: None,
            form: None,
            action: Vec::new(),
            lost: None,
            final_observation: Vec::new(),
            final_metrics: None,
            fragment_steps: 0,
        }
    }

    fn is_busy(&self) -> bool {
        matches!(self.state, State::Stepping | State::Preparing | State::Starting)
    }
}

impl VecEnv {
    /// Creates environments, before their first reset.
    ///
    /// # Errors
    /// [`Error::Pool`] when the system refuses resources of the workers; [`Error::NoEnvironment`].
    pub fn new(count: usize, sampler: Box<dyn Sampler>, options: VecEnvOptions) -> Result<Self> {
        if count == 0 {
            return Err(Error::NoEnvironment);
        }
        let widths = options.widths.unwrap_or((0, 0));
        Ok(Self {
            workers: Workers::new(options.workers)?,
            autoreset: options.autoreset,
            sampler,
            form: Box::new(Padded { widths, arrangement: Arrangement::InOrder }),
            widths,
            statistics: Statistics::default(),
            environments: (0..count).map(|_| EnvState::new()).collect(),
            observations: vec![0.0; count * widths.1],
            rewards: vec![Reward::default(); count],
            terms: vec![Amounts::default(); count],
            truncated: vec![false; count],
        })
    }

    /// Arranges observations and actions by a form, before the first reset.
    #[must_use]
    pub fn with_form(mut self, form: Box<dyn Form>) -> Self {
        self.widths = form.widths();
        self.observations = vec![0.0; self.len() * self.widths.1];
        self.form = form;
        self
    }

    /// Prepares settings before the first reset and returns their spaces.
    ///
    /// # Errors
    /// [`Error::Template`] for a building that cannot become an environment; [`Error::Pool`]; [`Error::Interrupted`].
    pub fn prepare(&mut self, settings: &[EpisodeSetting]) -> Result<Vec<Arc<Spaces>>> {
        self.workers.prepare_all(settings)
    }

    /// Begins an episode in every environment, ending those in progress.
    ///
    /// # Errors
    /// [`Error::Template`] or [`Error::Lost`] when the building of a first episode cannot become an environment, or when
    /// an episode is lost; [`Error::Interrupted`].
    pub fn reset(&mut self, seed: u64) -> Result<()> {
        self.reset_after(seed, &[])
    }

    /// Like [`VecEnv::reset`], but every environment first draws and skips its number of episodes in `skipped`; those
    /// without a number skip none.
    ///
    /// # Errors
    /// Same as [`VecEnv::reset`].
    pub fn reset_after(&mut self, seed: u64, skipped: &[u64]) -> Result<()> {
        self.sampler.restart();
        for index in 0..self.len() {
            self.abandon(index);
            let one = &mut self.environments[index];
            one.random = ChaCha8Rng::seed_from_u64(seed);
            one.random.set_stream(index as u64);
            one.next = None;
            one.waiting = None;
            one.form = None;
            one.lost = None;
            self.truncated[index] = false;
        }
        for index in 0..self.len() {
            for _ in 0..skipped.get(index).copied().unwrap_or(0) {
                self.sampler.draw(index, &mut self.environments[index].random)?;
            }
            self.draw(index)?;
        }
        if self.widths == (0, 0) {
            self.measure()?;
        }
        (0..self.len()).for_each(|index| self.begin(index));
        self.wait(self.len())?;
        match self.environments.iter().find_map(|one| one.lost.as_ref()) {
            None => Ok(()),
            Some(why) => Err(Error::Lost { what: "an environment".into(), why: why.clone() }),
        }
    }

    /// One step of every environment: [`VecEnv::send`] to each and [`VecEnv::recv`] of all. `actions` has a row for
    /// each, of the width of [`VecEnv::widths`].
    ///
    /// # Errors
    /// [`Error::ActionLength`], [`Error::ActionNotFinite`], [`Error::NotReset`] and [`Error::Busy`] before any action
    /// is sent; [`Error::Interrupted`].
    pub fn step(&mut self, actions: &[f64]) -> Result<()> {
        let (width, observed) = self.widths;
        // Determined by the first reset. A building under its own controls has no actions.
        if observed == 0 {
            return Err(Error::NotReset);
        }
        if actions.len() != width * self.len() {
            return Err(Error::ActionLength { given: actions.len(), expected: width * self.len() });
        }
        let action = |index: usize| &actions[index * width..][..width];
        for index in 0..self.len() {
            self.check(index, action(index))?;
        }
        for index in 0..self.len() {
            self.act(index, action(index))?;
        }
        self.wait(self.len())
    }

    /// Sends one environment its action. It is busy until [`VecEnv::recv`] lists it.
    ///
    /// # Errors
    /// [`Error::ActionNotFinite`], [`Error::ActionLength`]; [`Error::Busy`]; [`Error::NotReset`] when its episode is
    /// over without autoreset.
    pub fn send(&mut self, environment: usize, action: &[f64]) -> Result<()> {
        self.check(environment, action)?;
        self.act(environment, action)
    }

    /// Requests a fragment of about `steps` steps from an environment's runner of this kind: see
    /// [`Runner`](super::Runner). It is busy until [`VecEnv::recv`] lists it; [`VecEnv::fragment_steps`] then returns
    /// how many steps were made, fewer than requested if the episode is over.
    ///
    /// # Errors
    /// The errors of [`Episode::send_fragment`].
    pub fn send_fragment(
        &mut self,
        environment: usize,
        runner: &str,
        order: &impl Serialize,
        steps: usize,
    ) -> Result<()> {
        self.clear_outcome(environment);
        let one = &mut self.environments[environment];
        match (&mut one.episode, one.state) {
            (Some(episode), State::Ready) => episode.send_fragment(runner, order, steps)?,
            (_, State::Over) => return Err(Error::NotReset),
            _ => return Err(Error::Busy),
        }
        one.state = State::Stepping;
        Ok(())
    }

    /// Steps of the last fragment of an environment.
    pub fn fragment_steps(&self, environment: usize) -> usize {
        self.environments[environment].fragment_steps
    }

    /// Waits until at least `count` of the busy environments have finished, and lists their indices in `ready`.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn recv(&mut self, count: usize, ready: &mut Vec<usize>) -> Result<()> {
        ready.clear();
        ready.extend((0..self.len()).filter(|index| self.environments[*index].is_busy()));
        let idle = self.len() - ready.len();
        self.wait(idle + count.min(ready.len()))?;
        ready.retain(|index| !self.environments[*index].is_busy());
        Ok(())
    }

    /// Begins a new episode in one environment; it is busy until [`VecEnv::recv`] lists it.
    ///
    /// # Errors
    /// The errors of [`Sampler::draw`].
    pub fn reset_one(&mut self, environment: usize) -> Result<()> {
        self.abandon(environment);
        self.environments[environment].lost = None;
        self.truncated[environment] = false;
        self.draw(environment)?;
        self.begin(environment);
        Ok(())
    }

    /// Number of environments.
    pub fn len(&self) -> usize {
        self.environments.len()
    }

    /// Always `false`.
    pub fn is_empty(&self) -> bool {
        self.environments.is_empty()
    }

    /// Widths of a row of actions and a row of observations.
    pub fn widths(&self) -> (usize, usize) {
        self.widths
    }

    /// The spaces of an environment's current episode. `None` before the first reset.
    pub fn spaces(&self, environment: usize) -> Option<&Spaces> {
        self.environments[environment].spaces.as_deref()
    }

    /// Like [`VecEnv::spaces`], but shared.
    pub fn shared_spaces(&self, environment: usize) -> Option<&Arc<Spaces>> {
        self.environments[environment].spaces.as_ref()
    }

    /// The form of an environment's current episode. `None` before the first reset.
    pub fn form(&self, environment: usize) -> Option<&dyn EpisodeForm> {
        self.environments[environment].form.as_deref()
    }

    /// Observations, one row each; unless a form arranges them otherwise, the first
    /// [`VecEnv::spaces`]`.observation.len()` numbers of a row are the building's, the rest is padding.
    /// [`Decomposition::padded`](b2b_env::Decomposition::padded) splits a row into arrays of nodes.
    pub fn observations(&self) -> &[f64] {
        &self.observations
    }

    /// Rewards of the last steps.
    pub fn rewards(&self) -> &[Reward] {
        &self.rewards
    }

    /// Energy, cost, emissions and the other terms of the last steps.
    pub fn terms(&self) -> &[Amounts] {
        &self.terms
    }

    /// Returns whether each episode ended with the last step.
    pub fn truncated(&self) -> &[bool] {
        &self.truncated
    }

    /// Returns whether the episode of an environment is over and the next has not begun.
    pub fn is_over(&self, environment: usize) -> bool {
        self.environments[environment].state == State::Over
    }

    /// Why the last episode of an environment was lost, if it was.
    pub fn lost(&self, environment: usize) -> Option<&str> {
        self.environments[environment].lost.as_deref()
    }

    /// The last observation of the last finished episode, as a row; for an episode lost in a step, the observation
    /// before the step. Empty before the first end.
    pub fn final_observation(&self, environment: usize) -> &[f64] {
        &self.environments[environment].final_observation
    }

    /// The metrics of the last finished episode. `None` before the first end, and if the episode was lost. With
    /// [`Autoreset::SameStep`], a finished episode has its metrics even if the next was lost before it began.
    pub fn final_metrics(&self, environment: usize) -> Option<&Metrics> {
        self.environments[environment].final_metrics.as_ref()
    }

    /// The worker process of an environment. `None` between episodes.
    pub fn process(&self, environment: usize) -> Option<u32> {
        self.environments[environment].episode.as_ref().and_then(Episode::process)
    }

    /// Counts of episodes, building changes and waits for preparations.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// The workers.
    pub fn workers(&self) -> &Workers {
        &self.workers
    }

    fn check(&self, environment: usize, action: &[f64]) -> Result<()> {
        let one = &self.environments[environment];
        match (one.state, &one.form) {
            (State::Ready, Some(form)) => {
                let space = form.actions();
                let (given, expected) = (action.len(), space.len());
                space.check(action.get(..expected).ok_or(Error::ActionLength { given, expected })?)
            }
            (State::Over, _) if self.autoreset != Autoreset::Disabled => Ok(()),
            (State::Over, _) => Err(Error::NotReset),
            _ => Err(Error::Busy),
        }
    }

    /// Clears the outcome of the previous step.
    fn clear_outcome(&mut self, index: usize) {
        self.rewards[index] = Reward::default();
        self.terms[index] = Amounts::default();
        self.truncated[index] = false;
        self.environments[index].lost = None;
    }

    /// Sends a checked action, or begins the next episode.
    fn act(&mut self, index: usize, action: &[f64]) -> Result<()> {
        self.clear_outcome(index);
        let one = &mut self.environments[index];
        match (&mut one.episode, &mut one.form, one.state) {
            (Some(episode), Some(form), State::Ready) => {
                form.act(episode.observation(), action, &mut one.action);
                episode.send(&one.action)?;
                one.state = State::Stepping;
            }
            _ => self.begin(index),
        }
        Ok(())
    }
}
