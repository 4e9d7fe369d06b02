//! Trained agents as policies.

use b2b_agent::Agent;
use b2b_control::Controller;
use b2b_env::Task;
use serde_json::Value;

use super::interface::{EpisodeContext, Policy};
use crate::Result;

/// An agent observes the whole building in the form it was trained with, and drives all actuators.
impl Policy for Agent {
    fn name(&self) -> String {
        self.name().to_owned()
    }

    fn identity(&self) -> String {
        self.identity().to_owned()
    }

    fn ignores_interface(&self) -> bool {
        true
    }

    fn has_memory(&self) -> bool {
        self.info().network.state() > 0
    }

    fn trained_task(&self) -> Option<&Task> {
        Some(&self.info().task)
    }

    fn description(&self, context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        let description = self.description(context.spaces)?;
        Ok(description.map(|it| serde_json::to_value(it).expect("JSON has numbers, texts and lists")))
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        Ok(Box::new(self.controller(context.spaces)?))
    }
}
