//! The stages of a benchmark run.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A stage of a benchmark run. Serialized as its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Stage {
    /// Test environments, zero-shot: without a step of training on them.
    Test,
    /// A sample of the training environments.
    Train,
    /// Test environments under random actions: the level of an untrained policy.
    Untrained,
    /// Test environments, after a number of training steps on each.
    Adapted(u64),
    /// Test environments, each with a specialist trained on it alone for the budget of the problem: an upper bound for
    /// policies that generalize, and not ranked with them.
    UpperBound,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Test => f.write_str("test"),
            Self::Train => f.write_str("train"),
            Self::Untrained => f.write_str("untrained"),
            Self::Adapted(steps) => write!(f, "adapted-{steps}"),
            Self::UpperBound => f.write_str("upper-bound"),
        }
    }
}

impl From<Stage> for String {
    fn from(stage: Stage) -> Self {
        stage.to_string()
    }
}

impl TryFrom<String> for Stage {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Stage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "test" => Ok(Self::Test),
            "train" => Ok(Self::Train),
            "untrained" => Ok(Self::Untrained),
            "upper-bound" => Ok(Self::UpperBound),
            _ => {
                let steps = text.strip_prefix("adapted-").and_then(|steps| steps.parse().ok());
                let unknown = || {
                    format!(
                        "unknown stage `{text}`; expected test, train, untrained, adapted-STEPS or upper-bound"
                    )
                };
                steps.map(Self::Adapted).ok_or_else(unknown)
            }
        }
    }
}
