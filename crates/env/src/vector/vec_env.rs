//! N environments that step together, or as they come.

use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::pool::{Live, Pool, PoolOptions, Setting};
use super::region::Start;
use super::sampler::{Draw, Sampler};
use crate::metrics::Metrics;
use crate::reward::Reward;
use crate::spaces::Spaces;
use crate::{Error, Result};

/// When an environment whose episode is over begins the next, after Gymnasium's `AutoresetMode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Autoreset {
    /// With the step after its last: that step's action is ignored, its reward is 0.
    #[default]
    NextStep,
    /// Within its last step: what is seen is the first of the next episode; the last is in
    /// [`VecEnv::final_observation`].
    SameStep,
    /// When asked to: [`VecEnv::reset_one`].
    Disabled,
}

/// How a [`VecEnv`] works.
#[derive(Clone, Debug)]
pub struct VecEnvOptions {
    /// Of its processes.
    pub pool: PoolOptions,
    /// When the next episode begins.
    pub autoreset: Autoreset,
    /// Numbers in an action and in an observation of the batch; those of the largest of the first buildings if
    /// `None`. A building with fewer is padded with zeros, one with more is lost.
    pub widths: Option<(usize, usize)>,
}

/// N environments, each in a process of its own, over episodes that a [`Sampler`] draws.
///
/// - Observations: N rows, padded with zeros to one width, f64; see [`VecEnv::spaces`] for what is in a row.
/// - Actions: N rows, padded to one width; what is behind a building's last actuator is not read.
/// - An environment whose process dies is *lost*: truncated with a reason, and begun anew as one that is over.
/// - The same seed and actions give the same bits, however fast each environment is.
///
/// A step allocates nothing but at the end of an episode.
pub struct VecEnv {
    pool: Pool,
    autoreset: Autoreset,
    sampler: Box<dyn Sampler>,
    widths: (usize, usize),
    lives: Vec<Option<Live>>,
    places: Vec<Place>,
    observations: Vec<f64>,
    rewards: Vec<Reward>,
    truncated: Vec<bool>,
}

/// One environment beside its process.
struct Place {
    random: ChaCha8Rng,
    next: Option<Draw>,
    spaces: Option<Arc<Spaces>>,
    turn: Turn,
    lost: Option<String>,
    final_observation: Vec<f64>,
    final_metrics: Option<Metrics>,
}

/// Whose turn an environment is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    /// The caller's: it stands in an episode.
    Act,
    /// The caller's: its episode is over.
    Over,
    /// Its own, in a step.
    Step,
    /// Its own: it waits for its template.
    Await,
    /// Its own: its next episode begins.
    Begin,
}

impl VecEnv {
    /// Environments before their first reset.
    ///
    /// # Errors
    /// [`Error::Pool`] when the system refuses what processes need; [`Error::NoEnvironment`].
    pub fn new(count: usize, sampler: Box<dyn Sampler>, options: VecEnvOptions) -> Result<Self> {
        if count == 0 {
            return Err(Error::NoEnvironment);
        }
        let place = || Place {
            random: ChaCha8Rng::seed_from_u64(0),
            next: None,
            spaces: None,
            turn: Turn::Over,
            lost: None,
            final_observation: Vec::new(),
            final_metrics: None,
        };
        let widths = options.widths.unwrap_or((0, 0));
        Ok(Self {
            pool: Pool::new(options.pool)?,
            autoreset: options.autoreset,
            sampler,
            widths,
            lives: (0..count).map(|_| None).collect(),
            places: (0..count).map(|_| place()).collect(),
            observations: vec![0.0; count * widths.1],
            rewards: vec![Reward::default(); count],
            truncated: vec![false; count],
        })
    }

    /// Has templates made ahead of the first reset, and waits for them: what is seen and driven of each.
    ///
    /// # Errors
    /// [`Error::Template`] for a building that cannot be made an environment; [`Error::Pool`]; [`Error::Interrupted`].
    pub fn prepare(&mut self, settings: &[Setting]) -> Result<Vec<Arc<Spaces>>> {
        for setting in settings {
            self.pool.prepare(setting)?;
        }
        let spaces = |setting| {
            let template = self.pool.prepare(setting)?;
            self.pool.spaces(template)
        };
        settings.iter().map(spaces).collect()
    }

    /// Begins an episode in every environment; what was in progress is over.
    ///
    /// # Errors
    /// [`Error::Template`] when the building of the first episode of one cannot be made an environment;
    /// [`Error::Interrupted`].
    pub fn reset(&mut self, seed: u64) -> Result<()> {
        for index in 0..self.len() {
            self.abandon(index);
            let place = &mut self.places[index];
            place.random = ChaCha8Rng::seed_from_u64(seed);
            place.random.set_stream(index as u64);
            place.next = None;
        }
        for index in 0..self.len() {
            self.draw(index)?;
        }
        if self.widths == (0, 0) {
            self.measure()?;
        }
        (0..self.len()).for_each(|index| self.begin(index));
        self.wait(self.len())?;
        match self.places.iter().find_map(|place| place.lost.as_ref()) {
            None => Ok(()),
            Some(why) => Err(Error::Gone { what: "an environment", why: why.clone() }),
        }
    }

    /// One step of every environment: [`VecEnv::send`] to each and [`VecEnv::recv`] of all. `actions` has a row for
    /// each, of the width of [`VecEnv::widths`].
    ///
    /// # Errors
    /// [`Error::ActionLength`] and [`Error::ActionNotFinite`] before any moves; [`Error::Interrupted`].
    pub fn step(&mut self, actions: &[f64]) -> Result<()> {
        let width = self.widths.0;
        if actions.len() != width * self.len() {
            return Err(Error::ActionLength { given: actions.len(), expected: width * self.len() });
        }
        for (index, action) in actions.chunks_exact(width).enumerate() {
            self.check(index, action)?;
        }
        for (index, action) in actions.chunks_exact(width).enumerate() {
            self.act(index, action)?;
        }
        self.wait(self.len())
    }

    /// Gives one environment its action. It is away until [`VecEnv::recv`] tells of it.
    ///
    /// # Errors
    /// [`Error::ActionNotFinite`], [`Error::ActionLength`]; [`Error::Gone`] when it is away, or over without
    /// autoreset.
    pub fn send(&mut self, environment: usize, action: &[f64]) -> Result<()> {
        self.check(environment, action)?;
        self.act(environment, action)
    }

    /// Waits until at least `count` of those that are away are back, and tells which are.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn recv(&mut self, count: usize, back: &mut Vec<usize>) -> Result<()> {
        let is_away = |place: &Place| matches!(place.turn, Turn::Step | Turn::Await | Turn::Begin);
        back.clear();
        back.extend((0..self.len()).filter(|index| is_away(&self.places[*index])));
        let here = self.len() - back.len();
        self.wait(here + count.min(back.len()))?;
        back.retain(|index| !is_away(&self.places[*index]));
        Ok(())
    }

    /// Begins a new episode in one environment; it is away until [`VecEnv::recv`] tells of it.
    ///
    /// # Errors
    /// What [`Sampler::draw`] says.
    pub fn reset_one(&mut self, environment: usize) -> Result<()> {
        self.abandon(environment);
        self.draw(environment)?;
        self.begin(environment);
        Ok(())
    }

    /// Number of environments.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none: never.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Numbers in a row of actions and in a row of observations.
    pub fn widths(&self) -> (usize, usize) {
        self.widths
    }

    /// What an environment sees and drives now. `None` before the first reset.
    pub fn spaces(&self, environment: usize) -> Option<&Spaces> {
        self.places[environment].spaces.as_deref()
    }

    /// Observations, one row each; the first [`VecEnv::spaces`]`.observation.len()` numbers of a row are the building's,
    /// the rest is padding. [`Decomposition::padded`](crate::Decomposition::padded) makes a row arrays of nodes.
    pub fn observations(&self) -> &[f64] {
        &self.observations
    }

    /// Rewards of the last steps.
    pub fn rewards(&self) -> &[Reward] {
        &self.rewards
    }

    /// Whose episode ended with the last step.
    pub fn truncated(&self) -> &[bool] {
        &self.truncated
    }

    /// Whether the episode of an environment is over and the next has not begun.
    pub fn is_over(&self, environment: usize) -> bool {
        self.places[environment].turn == Turn::Over
    }

    /// Why the last episode of an environment was lost, if it was.
    pub fn lost(&self, environment: usize) -> Option<&str> {
        self.places[environment].lost.as_deref()
    }

    /// What was seen at the end of the last episode that ended. Empty before.
    pub fn final_observation(&self, environment: usize) -> &[f64] {
        &self.places[environment].final_observation
    }

    /// The sums over the last episode that ended. `None` before, and when it was lost.
    pub fn final_metrics(&self, environment: usize) -> Option<&Metrics> {
        self.places[environment].final_metrics.as_ref()
    }

    /// The process of an environment, for those who measure it.
    pub fn process(&self, environment: usize) -> Option<u32> {
        self.lives[environment].as_ref().and_then(|live| self.pool.process(live))
    }

    /// The pool.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    fn check(&self, environment: usize, action: &[f64]) -> Result<()> {
        match (self.places[environment].turn, &self.places[environment].spaces) {
            (Turn::Act, Some(spaces)) => {
                let width = spaces.action.len();
                if action.len() < width {
                    return Err(Error::ActionLength { given: action.len(), expected: width });
                }
                spaces.action.check(&action[..width])
            }
            (Turn::Over, _) if self.autoreset != Autoreset::Disabled => Ok(()),
            (Turn::Over, _) => Err(gone("its episode is over: reset it")),
            _ => Err(gone("it is busy with another step: receive it first")),
        }
    }

    /// An action that was checked.
    fn act(&mut self, index: usize, action: &[f64]) -> Result<()> {
        self.rewards[index] = Reward::default();
        self.truncated[index] = false;
        self.places[index].lost = None;
        match (&mut self.lives[index], self.places[index].turn) {
            (Some(live), Turn::Act) => {
                let width = live.spaces().action.len();
                self.pool.send(live, &action[..width])?;
                self.places[index].turn = Turn::Step;
            }
            _ => self.begin(index),
        }
        Ok(())
    }

    /// Draws the next episode and has its template made.
    fn draw(&mut self, index: usize) -> Result<()> {
        let place = &mut self.places[index];
        if place.next.is_none() {
            let draw = self.sampler.draw(index, &mut place.random)?;
            self.pool.prepare(&draw.setting)?;
            place.next = Some(draw);
        }
        Ok(())
    }

    /// The widths of the largest of the episodes to come.
    fn measure(&mut self) -> Result<()> {
        let settings: Vec<Setting> =
            self.places.iter().filter_map(|place| Some(place.next.as_ref()?.setting.clone())).collect();
        for setting in &settings {
            let template = self.pool.prepare(setting)?;
            let spaces = self.pool.spaces(template)?;
            self.widths.0 = self.widths.0.max(spaces.action.len());
            self.widths.1 = self.widths.1.max(spaces.observation.len());
        }
        self.observations = vec![0.0; self.len() * self.widths.1];
        Ok(())
    }

    /// Begins the next episode as soon as its template stands.
    fn begin(&mut self, index: usize) {
        self.abandon(index);
        self.places[index].turn = Turn::Await;
        if let Err(error) = self.draw(index) {
            self.lose(index, error.to_string());
        }
    }

    /// Lets those begin whose templates stand, all of one template at once.
    fn begin_those_awaited(&mut self) {
        for index in 0..self.len() {
            if self.places[index].turn != Turn::Await {
                continue;
            }
            if let Err(error) = self.try_to_begin(index) {
                self.lose(index, error.to_string());
            }
        }
    }

    fn try_to_begin(&mut self, first: usize) -> Result<()> {
        let Some(draw) = &self.places[first].next else { return Ok(()) };
        let setting = draw.setting.clone();
        let template = self.pool.prepare(&setting)?;
        if !self.pool.is_ready(template) {
            return Ok(());
        }
        let spaces = self.pool.spaces(template)?;
        self.fits(&spaces)?;
        let mut together = Vec::new();
        for index in first..self.len() {
            let place = &self.places[index];
            let same = |draw: &Draw| self.pool.is_of(template, &draw.setting);
            if place.turn == Turn::Await && place.next.as_ref().is_some_and(same) {
                together.push(index);
            }
        }
        let start = |index: &usize| Start {
            steps: self.places[*index].next.as_ref().and_then(|draw| draw.steps),
            processor: Some(*index as u32),
        };
        let starts: Vec<_> = together.iter().map(start).collect();
        let lives = self.pool.begin_several(template, &starts)?;
        for (index, live) in together.into_iter().zip(lives) {
            self.lives[index] = Some(live);
            let place = &mut self.places[index];
            place.turn = Turn::Begin;
            place.next = None;
            place.spaces = Some(Arc::clone(&spaces));
            // The template of the episode after this one is made while this one runs. What cannot be drawn now is
            // drawn again, and reported, when its turn comes.
            let _ = self.draw(index);
        }
        Ok(())
    }

    fn fits(&self, spaces: &Spaces) -> Result<()> {
        let name = || spaces.building.name.clone();
        let (actions, observations) = self.widths;
        for (what, width, most) in [
            ("actuators", spaces.action.len(), actions),
            ("observation slots", spaces.observation.len(), observations),
        ] {
            if width > most {
                return Err(Error::TooWide { name: name(), what, width, most });
            }
        }
        Ok(())
    }

    /// Waits until so many environments are the caller's.
    fn wait(&mut self, count: usize) -> Result<()> {
        loop {
            let done = self.pool.done();
            self.begin_those_awaited();
            (0..self.len()).for_each(|index| self.take_back(index));
            let mut here = 0;
            let mut awaited = 0;
            for place in &self.places {
                here += usize::from(matches!(place.turn, Turn::Act | Turn::Over));
                awaited += usize::from(place.turn == Turn::Await);
            }
            if here >= count {
                return Ok(());
            }
            // A template that stands up is one event; steps are waited for together.
            let ready = if awaited > 0 { here + awaited + 1 } else { count };
            self.pool.rest(&mut self.lives, ready, done)?;
        }
    }

    /// Reads what an environment that is no longer busy has to say.
    fn take_back(&mut self, index: usize) {
        let away = matches!(self.places[index].turn, Turn::Step | Turn::Begin);
        let Some(live) = self.lives[index].as_ref().filter(|live| away && !live.is_busy()) else { return };
        if let Some(why) = live.lost() {
            let why = why.to_owned();
            return self.lose(index, why);
        }
        let width = live.spaces().observation.len();
        let start = index * self.widths.1;
        let row = &mut self.observations[start..start + self.widths.1];
        self.pool.observation(live, &mut row[..width]);
        row[width..].fill(0.0);
        if self.places[index].turn == Turn::Step {
            self.rewards[index] = self.pool.reward(live);
        }
        self.places[index].turn = Turn::Act;
        if live.is_truncated() {
            self.truncated[index] = true;
            self.places[index].final_metrics = self.pool.metrics(live);
            self.end(index);
        }
    }

    /// An episode is over, and the next may begin.
    fn end(&mut self, index: usize) {
        let row = &self.observations[index * self.widths.1..][..self.widths.1];
        let place = &mut self.places[index];
        let width = place.spaces.as_ref().map_or(0, |spaces| spaces.observation.len());
        place.final_observation.clear();
        place.final_observation.extend_from_slice(&row[..width]);
        place.turn = Turn::Over;
        match self.autoreset {
            Autoreset::SameStep => self.begin(index),
            _ => self.abandon(index),
        }
    }

    /// Reports an episode as lost: truncated where it was last seen. The next begins as after any other, but never
    /// within the same step, lest one that fails at once fail for ever.
    fn lose(&mut self, index: usize, why: String) {
        self.abandon(index);
        let place = &mut self.places[index];
        place.lost = Some(why);
        place.final_metrics = None;
        place.next = None;
        self.truncated[index] = true;
    }

    fn abandon(&mut self, index: usize) {
        if let Some(live) = self.lives[index].take() {
            self.pool.stop(live);
        }
        self.places[index].turn = Turn::Over;
    }
}

fn gone(why: &str) -> Error {
    Error::Gone { what: "the environment", why: why.to_owned() }
}
