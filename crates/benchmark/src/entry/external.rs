//! Policies in the author's own program, such as a PyTorch policy in Python.

use std::fmt;

use b2b_control::Controller;

use crate::Error;
use b2b_evaluate::{EpisodeContext, Policy};

/// A policy in the author's own program. When read from a result, it is only described and cannot act.
pub struct External {
    /// Its name.
    pub name: String,
    /// One line that identifies it.
    pub identity: String,
    /// Whether its actions depend on the seed.
    pub by_seed: bool,
    /// The policy itself; `None` when read from a result.
    pub policy: Option<Box<dyn Policy + Send>>,
}

impl External {
    /// Returns a policy that can act.
    pub fn new(policy: Box<dyn Policy + Send>, by_seed: bool) -> Self {
        Self { name: policy.name(), identity: policy.identity(), by_seed, policy: Some(policy) }
    }
}

impl fmt::Debug for External {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "External({})", self.identity)
    }
}

impl Policy for External {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn ignores_interface(&self) -> bool {
        self.policy.as_ref().is_some_and(|policy| policy.ignores_interface())
    }

    fn has_memory(&self) -> bool {
        self.policy.as_ref().is_some_and(|policy| policy.has_memory())
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        match &self.policy {
            Some(policy) => policy.controller(context),
            None => Err(Error::ExternalPolicy { name: self.name.clone() }.into()),
        }
    }
}
