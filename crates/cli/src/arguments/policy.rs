//! The policy of an evaluation.

use std::path::Path;

use anyhow::{Result, bail};
use b2b_evaluate::{ActionScale, Policy, is_onnx, without_noise};

/// A policy and the meaning of its actions.
#[derive(clap::Args)]
pub struct PolicyArguments {
    #[arg(long, value_name = "POLICY", required = true, help = policy_help())]
    policy: Option<String>,
    /// Scale of the actions of an ONNX policy [default: rescaled]
    #[arg(long, value_enum)]
    actions: Option<Actions>,
}

/// The scale of the actions of an ONNX policy.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Actions {
    /// -1 for the lower and 1 for the upper bound of an actuator
    Rescaled,
    /// Physical units
    Physical,
}

fn policy_help() -> String {
    let kinds = b2b_control::KINDS.map(b2b_control::Kind::name).join(", ");
    format!("Policy: {kinds}, the folder of an agent, or an ONNX file")
}

impl PolicyArguments {
    /// Returns the scale of the actions of these policies. Errors if it is given and none of them is an ONNX file.
    pub fn scale<'a>(&self, mut policies: impl Iterator<Item = &'a str>) -> Result<ActionScale> {
        let Some(actions) = self.actions else { return Ok(ActionScale::Rescaled) };
        if !policies.any(|text| is_onnx(Path::new(without_noise(text)))) {
            bail!("--actions is for ONNX policies, and {} is none; remove it", self.text());
        }
        Ok(match actions {
            Actions::Rescaled => ActionScale::Rescaled,
            Actions::Physical => ActionScale::Physical,
        })
    }

    /// Returns the policy as given; empty only if a subcommand makes the option unnecessary.
    pub fn text(&self) -> &str {
        self.policy.as_deref().unwrap_or_default()
    }

    /// Returns the policy. Errors if it is unknown or cannot be read.
    pub fn load(&self) -> Result<Box<dyn Policy>> {
        Ok(<dyn Policy>::named(self.text(), self.scale([self.text()].into_iter())?)?)
    }
}
