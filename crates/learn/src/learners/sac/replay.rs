//! The replay buffer: the latest steps of every environment.

use crate::error::Result;
use crate::random::RandomStream;
use crate::rollout::{Rollout, Widths};
use crate::state::State;

/// The latest steps of every environment, in order, in one ring buffer per environment.
#[derive(Clone, Debug)]
pub struct ReplayBuffer {
    widths: Widths,
    environments: usize,
    /// Steps of each environment that the buffer holds.
    capacity: usize,
    /// Steps of each environment added so far.
    added: usize,
    /// Observation before each step: environments × capacity × width.
    observations: Vec<f32>,
    /// Action: environments × capacity × width.
    actions: Vec<f32>,
    /// Sum of the parts of the reward: environments × capacity.
    rewards: Vec<f32>,
    /// Observation after each step: environments × capacity × width.
    next: Vec<f32>,
    /// 1 where the next step does not continue this one, otherwise 0: environments × capacity.
    ends: Vec<f32>,
}

/// An n-step return, and where it is bootstrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Return {
    /// Σ γⁱ rᵢ over the steps.
    sum: f32,
    /// Discount of the value of the observation after the last step.
    discount: f32,
    /// Place of the last step.
    last: usize,
}

/// Steps drawn from a replay buffer.
#[derive(Clone, Debug, Default)]
pub struct ReplayBatch {
    /// Number of rows.
    pub rows: usize,
    /// Observations: rows × width.
    pub observations: Vec<f32>,
    /// Actions: rows × width.
    pub actions: Vec<f32>,
    /// Discounted sum of the rewards of the steps of a return: rows.
    pub returns: Vec<f32>,
    /// Discount of the value of the observation after those steps: rows.
    pub discounts: Vec<f32>,
    /// Observation after those steps: rows × width.
    pub next: Vec<f32>,
    /// Standard normal numbers for actions after those steps: rows × actions.
    pub next_normals: Vec<f32>,
    /// Standard normal numbers for actions of the observations: rows × actions.
    pub normals: Vec<f32>,
}

impl ReplayBuffer {
    /// Returns an empty buffer for `capacity` steps over all environments.
    pub fn new(widths: Widths, environments: usize, capacity: usize) -> Self {
        let capacity = (capacity / environments.max(1)).max(1);
        let room = |width: usize| vec![0.0; environments * capacity * width];
        Self {
            widths,
            environments,
            capacity,
            added: 0,
            observations: room(widths.observation),
            actions: room(widths.action),
            rewards: room(1),
            next: room(widths.observation),
            ends: room(1),
        }
    }

    /// Returns the number of environments.
    pub fn environments(&self) -> usize {
        self.environments
    }

    /// Returns the number of steps over all environments.
    pub fn len(&self) -> usize {
        self.environments * self.filled()
    }

    /// Returns whether the buffer has no steps.
    pub fn is_empty(&self) -> bool {
        self.added == 0
    }

    /// Returns whether the next steps overwrite the oldest ones.
    pub fn is_full(&self) -> bool {
        self.added >= self.capacity
    }

    /// Adds the steps of a rollout, overwriting the oldest ones.
    ///
    /// # Panics
    /// When the rollout has another number of environments.
    pub fn add(&mut self, rollout: &Rollout) {
        assert_eq!(rollout.environments, self.environments, "environments of a replay buffer");
        for environment in 0..self.environments {
            self.end_unless_continued(rollout, environment);
            for step in 0..rollout.steps {
                self.add_step(rollout, environment, step);
            }
        }
        for end in &rollout.ends {
            // Skips ends that the same rollout has already overwritten.
            if end.step + self.capacity >= rollout.steps {
                let place = self.place(end.environment, self.added + end.step);
                self.ends[place] = 1.0;
                write(&mut self.next, place, &end.observation);
            }
        }
        self.added += rollout.steps;
    }

    /// Ends the newest step of an environment if a rollout begins with another observation than the one after it: the
    /// steps in between were lost with their process.
    fn end_unless_continued(&mut self, rollout: &Rollout, environment: usize) {
        if self.is_empty() || rollout.steps == 0 {
            return;
        }
        let (newest, width) = (self.place(environment, self.added - 1), self.widths.observation);
        let first = row(&rollout.observations, environment * rollout.steps, width);
        if row(&self.next, newest, width) != first {
            self.ends[newest] = 1.0;
        }
    }

    /// Marks that the next steps do not continue the newest ones.
    pub fn cut(&mut self) {
        for environment in 0..if self.is_empty() { 0 } else { self.environments } {
            let place = self.place(environment, self.added - 1);
            self.ends[place] = 1.0;
        }
    }

    /// Draws steps at random, with returns of up to `steps` steps.
    ///
    /// A return stops early at the end of an episode, which is a truncation, and at the newest step. It continues with
    /// the value of the observation there.
    pub fn sample(
        &self,
        rows: usize,
        steps: usize,
        gamma: f32,
        random: &mut RandomStream,
        batch: &mut ReplayBatch,
    ) {
        batch.clear(rows);
        for _ in 0..rows {
            let (environment, age) = (random.below(self.environments), random.below(self.filled()));
            let step = self.added - 1 - age;
            let found = self.look_ahead(environment, step, steps, gamma);
            let place = self.place(environment, step);
            batch.observations.extend_from_slice(row(&self.observations, place, self.widths.observation));
            batch.actions.extend_from_slice(row(&self.actions, place, self.widths.action));
            batch.next.extend_from_slice(row(&self.next, found.last, self.widths.observation));
            batch.returns.push(found.sum);
            batch.discounts.push(found.discount);
        }
        for normals in [&mut batch.next_normals, &mut batch.normals] {
            normals.resize(rows * self.widths.action, 0.0);
            random.normals(normals);
        }
    }

    /// Adds the steps to a state.
    pub fn save(&self, state: &mut State) {
        state.put_u64("replay.added", &[self.added as u64, self.filled() as u64]);
        let saved = |values: &[f32], width: usize| -> Vec<f32> {
            let rings = values.chunks_exact(self.capacity * width);
            rings.flat_map(|ring| &ring[..self.filled() * width]).copied().collect()
        };
        for (name, values, width) in self.arrays() {
            state.put_f32(name, &saved(values, width));
        }
    }

    /// Restores the steps from a state.
    ///
    /// # Errors
    /// When the state does not contain them.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        let [added, filled] = state.read_u64("replay.added")?;
        self.added = added as usize;
        let (capacity, filled) = (self.capacity, filled as usize);
        let mut saved = Vec::new();
        for (name, values, width) in self.arrays_mut() {
            saved.resize(values.len() / capacity * filled, 0.0);
            state.read_f32(name, &mut saved)?;
            let rings = values.chunks_exact_mut(capacity * width);
            for (ring, saved) in rings.zip(saved.chunks_exact((filled * width).max(1))) {
                ring[..filled * width].copy_from_slice(saved);
            }
        }
        Ok(())
    }

    fn arrays(&self) -> [(&'static str, &[f32], usize); 5] {
        let Widths { observation, action, .. } = self.widths;
        [
            ("replay.observations", &self.observations, observation),
            ("replay.actions", &self.actions, action),
            ("replay.rewards", &self.rewards, 1),
            ("replay.next", &self.next, observation),
            ("replay.ends", &self.ends, 1),
        ]
    }

    fn arrays_mut(&mut self) -> [(&'static str, &mut [f32], usize); 5] {
        let Widths { observation, action, .. } = self.widths;
        [
            ("replay.observations", &mut self.observations, observation),
            ("replay.actions", &mut self.actions, action),
            ("replay.rewards", &mut self.rewards, 1),
            ("replay.next", &mut self.next, observation),
            ("replay.ends", &mut self.ends, 1),
        ]
    }

    /// Returns the number of steps of each environment.
    fn filled(&self) -> usize {
        self.added.min(self.capacity)
    }

    /// Returns the place of a step, counted from the first that was added.
    fn place(&self, environment: usize, step: usize) -> usize {
        environment * self.capacity + step % self.capacity
    }

    fn add_step(&mut self, rollout: &Rollout, environment: usize, step: usize) {
        let place = self.place(environment, self.added + step);
        let from = environment * rollout.steps + step;
        let Widths { observation, action, parts, .. } = self.widths;
        let next = match step + 1 < rollout.steps {
            true => row(&rollout.observations, from + 1, observation),
            false => row(&rollout.next, environment, observation),
        };
        write(&mut self.observations, place, row(&rollout.observations, from, observation));
        write(&mut self.actions, place, row(&rollout.actions, from, action));
        write(&mut self.next, place, next);
        self.rewards[place] = row(&rollout.rewards, from, parts).iter().sum();
        self.ends[place] = 0.0;
    }

    /// Returns the return of up to `steps` steps from this one.
    fn look_ahead(&self, environment: usize, step: usize, steps: usize, gamma: f32) -> Return {
        let (mut sum, mut discount) = (0.0, 1.0);
        let end = self.added.min(step + steps);
        let mut last = self.place(environment, step);
        for place in (step..end).map(|step| self.place(environment, step)) {
            sum += discount * self.rewards[place];
            discount *= gamma;
            last = place;
            if self.ends[place] > 0.0 {
                break;
            }
        }
        Return { sum, discount, last }
    }
}

impl ReplayBatch {
    fn clear(&mut self, rows: usize) {
        self.rows = rows;
        let Self { observations, actions, returns, discounts, next, .. } = self;
        [observations, actions, returns, discounts, next].into_iter().for_each(Vec::clear);
    }
}

fn row(values: &[f32], row: usize, width: usize) -> &[f32] {
    &values[row * width..(row + 1) * width]
}

fn write(values: &mut [f32], row: usize, from: &[f32]) {
    values[row * from.len()..(row + 1) * from.len()].copy_from_slice(from);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rollout::End;

    const WIDTHS: Widths = Widths { observation: 1, action: 1, parts: 2, nodes: 1 };
    const GAMMA: f32 = 0.9;

    /// A step: observation, reward, observation after it, and whether it ended an episode.
    type Known = (f32, f32, f32, bool);

    /// Returns a rollout of two environments whose observations are numbered from `first`, with episodes of five steps.
    fn rollout(first: usize, steps: usize, known: &mut [Vec<Known>; 2]) -> Rollout {
        let mut rollout = Rollout { environments: 2, steps, ..Rollout::default() };
        for (environment, known) in known.iter_mut().enumerate() {
            for step in 0..steps {
                let number = (1000 * environment + first + step) as f32;
                let (reward, end) = (number.sin(), (first + step) % 5 == 4);
                rollout.observations.push(number);
                rollout.actions.push(-number);
                rollout.rewards.extend([reward - 1.0, 1.0]);
                let next = if end { number + 0.5 } else { number + 1.0 };
                if end {
                    rollout.ends.push(End { environment, step, observation: vec![next] });
                }
                known.push((number, reward, next, end));
            }
            rollout.next.push((1000 * environment + first + steps) as f32);
        }
        rollout
    }

    /// Returns the return from a step by its definition: sum, discount and last observation.
    fn brute_force(known: &[Known], step: usize, steps: usize) -> (f32, f32, f32) {
        let (mut sum, mut count) = (0.0, 0);
        for (_, reward, next, end) in &known[step..] {
            sum += GAMMA.powi(count) * reward;
            count += 1;
            if *end || count as usize == steps || step + count as usize == known.len() {
                return (sum, GAMMA.powi(count), *next);
            }
        }
        unreachable!("a return has at least one step")
    }

    #[test]
    fn returns_do_not_continue_over_lost_steps() {
        let mut known = [vec![], vec![]];
        let mut replay = ReplayBuffer::new(WIDTHS, 2, 2 * 17);
        replay.add(&rollout(0, 2, &mut known));
        let mut second = rollout(2, 2, &mut known);
        // The second environment begins elsewhere.
        second.observations[2] = 77.0;
        replay.add(&second);
        let last = |environment: usize| replay.look_ahead(environment, 1, 3, GAMMA).last;
        assert_eq!([last(0), last(1)], [replay.place(0, 3), replay.place(1, 1)]);
    }

    #[test]
    fn returns_are_sums_up_to_the_end_of_an_episode() {
        let mut known = [vec![], vec![]];
        let mut replay = ReplayBuffer::new(WIDTHS, 2, 2 * 17);
        for (first, steps) in [(0, 7), (7, 7), (14, 9)] {
            replay.add(&rollout(first, steps, &mut known));
        }
        assert_eq!(replay.len(), 34);
        for steps in 1..8 {
            let mut batch = ReplayBatch::default();
            replay.sample(200, steps, GAMMA, &mut RandomStream::new(steps as u64, 0), &mut batch);
            for row in 0..200 {
                let number = batch.observations[row] as usize;
                let (environment, step) = (number / 1000, number % 1000);
                assert!(step >= 23 - 17, "{step} is overwritten");
                let (sum, discount, next) = brute_force(&known[environment], step, steps);
                assert_eq!(batch.actions[row], -(number as f32));
                assert!(
                    (batch.returns[row] - sum).abs() < 1e-5 && (batch.discounts[row] - discount).abs() < 1e-6
                );
                assert_eq!(batch.next[row], next);
            }
        }
    }

    #[test]
    fn returns_stop_at_a_cut() {
        let mut known = [vec![], vec![]];
        let mut replay = ReplayBuffer::new(WIDTHS, 2, 100);
        replay.add(&rollout(0, 3, &mut known));
        replay.cut();
        replay.add(&rollout(30, 3, &mut known));
        let found = replay.look_ahead(0, 1, 5, GAMMA);
        assert_eq!((found.last, found.discount), (2, GAMMA * GAMMA));
    }

    #[test]
    fn a_restored_buffer_has_the_same_steps() {
        for steps in [5, 40] {
            let mut known = [vec![], vec![]];
            let mut replay = ReplayBuffer::new(WIDTHS, 2, 2 * 17);
            replay.add(&rollout(0, steps, &mut known));
            let mut state = State::default();
            replay.save(&mut state);
            let mut restored = ReplayBuffer::new(WIDTHS, 2, 2 * 17);
            restored.restore(&state).unwrap();
            assert_eq!(restored.added, replay.added);
            assert_eq!(restored.arrays(), replay.arrays());
        }
    }
}
