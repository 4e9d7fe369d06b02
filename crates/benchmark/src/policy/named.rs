//! Policies by name.

use std::path::Path;

use super::{ActionScale, BuiltIn, OnnxPolicy, Policy};
use crate::Result;

impl dyn Policy {
    /// Returns the policy of a name: a [`BuiltIn`], or an ONNX file whose actions are scaled by `scale`.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`](crate::Error::UnknownPolicy); those of [`OnnxPolicy::read`].
    pub fn named(name: &str, scale: ActionScale) -> Result<Box<Self>> {
        let path = Path::new(name);
        if is_onnx(path) {
            return Ok(Box::new(OnnxPolicy::read(path, scale)?));
        }
        Ok(Box::new(name.parse::<BuiltIn>()?))
    }
}

/// Returns whether a policy's name is the path of an ONNX file.
pub(crate) fn is_onnx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("onnx"))
}
