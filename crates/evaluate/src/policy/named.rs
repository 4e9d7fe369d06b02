//! Policies by name.

use std::path::Path;

use b2b_agent::{Agent, INFO};

use super::{ActionScale, BuiltIn, OnnxPolicy, Policy};
use crate::Result;

impl dyn Policy {
    /// Returns the policy for a name: a [`BuiltIn`], the folder of an agent, or an ONNX file, whose actions have the
    /// scale `scale`.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`](crate::Error::UnknownPolicy); errors from [`OnnxPolicy::read`] and [`Agent::read`].
    pub fn named(name: &str, scale: ActionScale) -> Result<Box<Self>> {
        let path = Path::new(name);
        if is_onnx(path) {
            return Ok(Box::new(OnnxPolicy::read(path, scale)?));
        }
        if is_agent(path) {
            return Ok(Box::new(Agent::read(path)?));
        }
        Ok(Box::new(name.parse::<BuiltIn>()?))
    }
}

/// Returns whether a policy's name is the folder of an agent.
pub fn is_agent(path: &Path) -> bool {
    path.join(INFO).exists()
}

/// Returns whether a policy's name is the path of an ONNX file.
pub fn is_onnx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("onnx"))
}
