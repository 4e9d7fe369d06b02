//! The calls of the interface: what a client asks, its arguments, and the answer or the refusal.

mod answer;
mod arguments;
mod call;

pub(crate) use answer::{Answer, Refusal};
pub(crate) use arguments::{Arguments, shown, to_number, unknown};
pub(crate) use call::Call;
