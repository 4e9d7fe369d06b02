//! The kind `mpc`.

use std::path::Path;

use b2b_workers::Episode;
use serde_json::Value;

use super::prior::SHIPPED;
use super::{IDENTIFICATION_HOURS, Model, Mpc, NAME, REVISION, identify};
use crate::kind::{self, AnyController, Case};
use crate::parameter_set::{from_json, to_json};
use crate::{Error, Result};

/// The kind `mpc`. Its values are a model, or null: then it is identified before the episode.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        NAME
    }

    fn help(&self) -> &'static str {
        "guideline36 under points planned every hour on a model identified in the two weeks before"
    }

    fn identity(&self) -> String {
        kind::shipped_identity(&format!("{NAME}#{REVISION}"), SHIPPED)
    }

    fn is_stochastic(&self) -> bool {
        true
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn plans(&self) -> bool {
        true
    }

    fn read(&self, path: &Path) -> Result<Value> {
        Ok(to_json(&Model::read(path)?))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        if case.values.is_null() {
            return Err(Error::NeedsEpisode { name: NAME });
        }
        let model: Model = from_json(case.values)?;
        Ok(Box::new(Mpc::new(case.spaces, &model, case.seed)?))
    }

    fn plan(
        &self,
        case: &Case<'_>,
        episode: &mut Episode,
        step: &mut dyn FnMut(),
    ) -> Result<Option<Box<dyn AnyController>>> {
        if !case.values.is_null() {
            return self.make(case).map(Some);
        }
        let mut hour = kind::spread(case.spaces.episode_steps(), IDENTIFICATION_HOURS, step);
        let model = identify(episode, case.seed, &mut hour)?;
        Ok(Some(Box::new(Mpc::new(case.spaces, &model, case.seed)?)))
    }
}
