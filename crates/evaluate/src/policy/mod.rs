//! Policies: built-in controllers, trained agents and networks in ONNX files.

mod ablation;
mod action_scale;
mod agent;
mod built_in;
mod form;
mod interface;
mod limited;
mod named;
mod noisy;
mod onnx;
mod onnx_format;
mod onnx_state;

pub use ablation::Ablation;
pub use action_scale::ActionScale;
pub use built_in::BuiltIn;
pub(crate) use form::controller;
pub use form::{HouseForm, PolicyForm};
pub use interface::{EpisodeContext, Policy, PolicyInterface};
pub use named::{is_agent, is_onnx};
pub use noisy::without_noise;
pub use onnx::OnnxPolicy;
