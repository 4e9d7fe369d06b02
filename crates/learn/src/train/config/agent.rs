//! Network, observation and actions of an agent.

use std::fmt;

use b2b_agent::{Acting, Interface, ObservationForm, ObservationOptions};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::error::Result;
use crate::limits::require;
use crate::policy::PolicyConfig;

/// Network, observation and actions of an agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AgentConfig {
    /// Kind of network: `{ kind = "flat" }`, `{ kind = "recurrent" }` with the options of
    /// [`RecurrentPolicy`](crate::train::RecurrentPolicy), or `{ kind = "graph" }` with the options of
    /// [`GraphPolicy`](crate::train::GraphPolicy).
    pub policy: PolicyConfig,
    /// What the agent observes: a form, `raw`, `roles` or `features`, or a table with `form`, `attributes`, `forecast`
    /// and `feedback`.
    pub observation: ObservationOptions,
    /// How the agent acts: `{ kind = "direct" }`, `{ kind = "residual", authority = 0.5 }`,
    /// `{ kind = "targets", every = 60, shift = 1.0 }` or `{ kind = "supervisory", every = 60 }`; or a text such as
    /// `supervisory:60`.
    #[serde(deserialize_with = "text_or_table")]
    pub acting: Acting,
}

impl Default for AgentConfig {
    fn default() -> Self {
        Self {
            policy: PolicyConfig::Flat,
            observation: ObservationForm::Features.into(),
            acting: Acting::Direct,
        }
    }
}

impl AgentConfig {
    /// Returns what the agent observes and how it acts.
    pub fn interface(&self) -> Interface {
        Interface { observation: self.observation, acting: self.acting, nodes: self.policy.nodes() }
    }

    /// Returns whether the agent observes the attributes of its building.
    pub(crate) fn observes_attributes(&self) -> bool {
        self.policy.nodes().map_or(self.observation.attributes, |form| form.attributes)
    }

    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        self.policy.check()?;
        if self.policy.is_graph() { self.check_graph() } else { Ok(()) }
    }

    fn check_graph(&self) -> Result<()> {
        let ObservationOptions { form, attributes, forecast, feedback } = self.observation;
        let excluded = [
            ("observation", form == ObservationForm::Roles, "it must be raw or features"),
            ("observation.attributes", attributes, "use `policy.attributes`"),
            ("observation.forecast", forecast > 0, "it must be 0"),
            // Features have each node's previous action.
            ("observation.feedback", feedback && form == ObservationForm::Raw, "`form` must be features"),
        ];
        for (name, is_wrong, remedy) in excluded {
            require(!is_wrong, || format!("`{name}` with graph networks: {remedy}"))?;
        }
        Ok(())
    }
}

/// Reads how an agent acts.
pub(super) fn text_or_table<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Acting, D::Error> {
    struct TextOrTable;

    impl<'de> Visitor<'de> for TextOrTable {
        type Value = Acting;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a text such as `supervisory:60`, or a table with `kind`")
        }

        fn visit_str<E: Error>(self, text: &str) -> std::result::Result<Acting, E> {
            text.parse().map_err(E::custom)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Acting, A::Error> {
            Acting::deserialize(MapAccessDeserializer::new(map))
        }
    }

    deserializer.deserialize_any(TextOrTable)
}
