//! The calls of the interface, with their arguments, answers and refusals.

mod answer;
mod arguments;
mod call;

pub(crate) use answer::{Answer, Refusal};
pub(crate) use arguments::{Arguments, shown, to_number, unknown};
pub(crate) use call::Call;
