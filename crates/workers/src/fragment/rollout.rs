//! Rollouts whose controller runs in the worker of the episode.
//!
//! In a small building, exchanging every step with the owner costs more than the step. A controller that can be created
//! from a description therefore runs in the worker, a day of steps at a time; [`SharedMemory`] returns the results.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::value::RawValue;

use super::{Runner, RunnerError, SharedMemory};
use crate::batch::wait;
use crate::episode::Episode;
use crate::workers::Workers;
use b2b_env::Metrics;
use b2b_env::Spaces;
use b2b_env::{Controller, Env, Error, Observer, Result};
use b2b_env::{Environment, Step};
use b2b_env::{StepNumbers, from_numbers};

/// The kind of the runner of rollouts, which makes a [`ControllerRunner`].
pub const ROLLOUT: &str = "rollout";

/// A request for a part of a rollout. The worker's program makes a [`ControllerRunner`] from the first one of a
/// controller.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RolloutOrder<C = Value> {
    /// Description of the controller, in a form that the program defines.
    pub controller: C,
    /// Maximum number of steps.
    steps: usize,
    /// Position of their records in the shared memory.
    record: Option<usize>,
}

/// Runs rollouts under a controller, inside a worker.
pub struct ControllerRunner {
    controller: Box<dyn Controller>,
    /// Its description, as requested. `None` before the first request.
    description: Option<Box<RawValue>>,
    action: Vec<f64>,
    /// Record of a step.
    row: Vec<f64>,
}

impl ControllerRunner {
    /// A runner in an episode.
    pub fn new(mut controller: Box<dyn Controller>, env: &Env) -> Self {
        controller.reset();
        Self {
            controller,
            description: None,
            action: vec![0.0; env.spaces().action.len()],
            row: vec![0.0; width(env.spaces())],
        }
    }
}

impl Runner for ControllerRunner {
    fn run(
        &mut self,
        env: &mut Env,
        order: &[u8],
        memory: &SharedMemory,
    ) -> std::result::Result<usize, RunnerError> {
        let RolloutOrder::<&RawValue> { controller, steps, record } = serde_json::from_slice(order)?;
        self.description.get_or_insert_with(|| controller.to_owned());
        let mut done = 0;
        while done < steps && !env.is_truncated() {
            self.controller.act(env.observation(), &mut self.action);
            let step = env.step(&self.action)?;
            self.controller.reward(step.reward.total());
            if let Some(place) = record {
                write_record(&mut self.row, &step);
                memory.write_f64(place + done * 2 * self.row.len(), &self.row);
            }
            done += 1;
        }
        Ok(done)
    }

    /// A different description is a different controller.
    fn serves(&self, order: &[u8]) -> bool {
        let Some(own) = &self.description else { return true };
        let order = serde_json::from_slice::<RolloutOrder<&RawValue>>(order);
        order.is_ok_and(|order| order.controller.get() == own.get())
    }
}

/// Memory of a set of workers for the records of consecutive rollouts.
#[derive(Debug)]
pub struct RolloutMemory {
    workers: Workers,
    memory: SharedMemory,
    place: usize,
    /// Capacity, as a number of f64.
    room: usize,
    records: Vec<f64>,
}

impl RolloutMemory {
    /// Creates the memory, reserved when a rollout needs it.
    pub fn new(workers: &Workers) -> Self {
        let memory = workers.memory();
        Self { workers: workers.clone(), memory, place: 0, room: 0, records: Vec::new() }
    }

    fn make_room(&mut self, count: usize) -> Result<()> {
        if self.room < count {
            self.place = self.workers.reserve_memory(2 * count)?;
            self.room = count;
        }
        self.records.resize(count, 0.0);
        Ok(())
    }
}

impl Episode {
    /// Resets the episode, runs it to its end under a controller that the worker creates from its description, and
    /// passes the steps to the observer, a day at a time. Metrics and steps equal the results of
    /// [`rollout`](b2b_env::rollout) bit for bit.
    ///
    /// # Errors
    /// The errors of the environment and of the observer; [`Error::Lost`] when the worker cannot create the controller.
    pub fn rollout(
        &mut self,
        controller: &Value,
        memory: &mut RolloutMemory,
        observer: &mut dyn Observer,
    ) -> Result<Metrics> {
        let spaces = Arc::clone(self.known_spaces());
        let (width, steps) = (width(&spaces), 24 * spaces.episode.steps_per_hour as usize);
        memory.make_room(steps * width)?;
        observer.begin(self.reset()?)?;
        let order = order(controller, steps, Some(memory.place));
        while !self.is_truncated() {
            self.send_fragment(ROLLOUT, &order, steps)?;
            wait(std::slice::from_mut(self), 1)?;
            self.last_step()?;
            let count = self.fragment_steps();
            let records = &mut memory.records[..count * width];
            memory.memory.read_f64(memory.place, records);
            for (index, record) in records.chunks_exact(width).enumerate() {
                let truncated = self.is_truncated() && index + 1 == count;
                observer.step(&step_of_record(record, &spaces, truncated))?;
            }
        }
        self.metrics().cloned().ok_or(Error::NotReset)
    }

    /// Starts running a ready episode to its end under a controller that the worker creates from its description,
    /// without waiting.
    ///
    /// # Errors
    /// Same as [`Episode::send_fragment`].
    pub fn send_rollout(&mut self, controller: &Value) -> Result<()> {
        let steps = self.known_spaces().episode_steps();
        self.send_fragment(ROLLOUT, &order(controller, steps, None), steps)
    }
}

fn order(controller: &Value, steps: usize, record: Option<usize>) -> RolloutOrder<&Value> {
    RolloutOrder { controller, steps, record }
}

/// Numbers in the record of a step: observation, action, reward and terms.
fn width(spaces: &Spaces) -> usize {
    spaces.observation.len() + spaces.action.len() + StepNumbers::default().len()
}

fn write_record(record: &mut [f64], step: &Step<'_>) {
    let (observation, rest) = record.split_at_mut(step.observation.len());
    let (action, numbers) = rest.split_at_mut(step.action.len());
    observation.copy_from_slice(step.observation);
    action.copy_from_slice(step.action);
    numbers.copy_from_slice(&step.numbers());
}

fn step_of_record<'a>(record: &'a [f64], spaces: &Spaces, truncated: bool) -> Step<'a> {
    let (observation, rest) = record.split_at(spaces.observation.len());
    let (action, numbers) = rest.split_at(spaces.action.len());
    let (reward, terms) = from_numbers(numbers.try_into().expect("the record has this width"));
    Step { observation, action, reward, terms, truncated }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    struct Idle;

    impl Controller for Idle {
        fn reset(&mut self) {}

        fn act(&mut self, _: &[f64], _: &mut [f64]) {}
    }

    #[test]
    fn a_runner_serves_only_orders_of_its_own_controller() {
        let description = |order: &[u8]| {
            let order: RolloutOrder<&RawValue> = serde_json::from_slice(order).unwrap();
            Some(order.controller.to_owned())
        };
        let order = |controller: &Value, steps, record| {
            serde_json::to_vec(&super::order(controller, steps, record)).unwrap()
        };
        let first = order(&json!({"kind": "a", "gain": 0.5}), 3, None);
        let mut runner =
            ControllerRunner { controller: Box::new(Idle), description: None, action: vec![], row: vec![] };
        assert!(runner.serves(&first), "it was made from it");
        runner.description = description(&first);
        assert!(runner.serves(&order(&json!({"kind": "a", "gain": 0.5}), 288, Some(7))));
        assert!(!runner.serves(&order(&json!({"kind": "a", "gain": 0.25}), 3, None)));
        assert!(!runner.serves(br#"{"steps": 3}"#));
    }
}
