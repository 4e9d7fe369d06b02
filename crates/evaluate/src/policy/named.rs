//! Policies by name.

use std::path::Path;

use b2b_agent::{Agent, INFO};

use super::noisy::NoisyPolicy;
use super::{ActionScale, BuiltIn, OnnxPolicy, Policy};
use crate::Result;

impl dyn Policy {
    /// Returns the policy for a name: a [`BuiltIn`], the folder of an agent, or an ONNX file, whose actions have the
    /// scale `scale`; `NAME+noise0.2` adds [noise](b2b_control::Noise) to the actions of any of them.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`](crate::Error::UnknownPolicy); [`Error::NoiseLevel`](crate::Error::NoiseLevel);
    /// [`Error::NoiseWithoutActuators`](crate::Error::NoiseWithoutActuators); errors from [`OnnxPolicy::read`] and
    /// [`Agent::read`].
    pub fn named(name: &str, scale: ActionScale) -> Result<Box<Self>> {
        let path = Path::new(name);
        if is_onnx(path) {
            return Ok(Box::new(OnnxPolicy::read(path, scale)?));
        }
        if is_agent(path) {
            return Ok(Box::new(Agent::read(path)?));
        }
        if let Some((name, level)) = NoisyPolicy::parts(name)? {
            return Ok(Box::new(NoisyPolicy::new(Self::named(name, scale)?, level)?));
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
