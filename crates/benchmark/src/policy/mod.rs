//! Policies: built-in controllers, trained agents and networks in ONNX files.

mod action_scale;
mod agent;
mod built_in;
mod form;
mod interface;
mod named;
mod onnx;
mod onnx_format;

pub use action_scale::ActionScale;
pub use built_in::BuiltIn;
pub use form::HouseForm;
pub(crate) use form::{Form, controller};
pub use interface::{EpisodeContext, Interface, Policy};
pub(crate) use named::{is_agent, is_onnx};
pub use onnx::OnnxPolicy;
