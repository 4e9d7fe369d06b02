//! The policy of an evaluation.

use b2b_evaluate::{ActionScale, Policy};

/// A policy and the meaning of its actions.
#[derive(clap::Args)]
pub struct PolicyArguments {
    #[arg(long, value_name = "POLICY", required = true, help = policy_help())]
    policy: Option<String>,
    /// Scale of the actions of an ONNX policy
    #[arg(long, value_enum, default_value_t = Actions::Rescaled)]
    actions: Actions,
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
    /// Returns the scale of the actions.
    pub fn scale(&self) -> ActionScale {
        match self.actions {
            Actions::Rescaled => ActionScale::Rescaled,
            Actions::Physical => ActionScale::Physical,
        }
    }

    /// Returns the policy as given; empty only if a subcommand makes the option unnecessary.
    pub fn text(&self) -> &str {
        self.policy.as_deref().unwrap_or_default()
    }

    /// Returns the policy. Errors if it is unknown or cannot be read.
    pub fn load(&self) -> b2b_evaluate::Result<Box<dyn Policy>> {
        <dyn Policy>::named(self.text(), self.scale())
    }
}
