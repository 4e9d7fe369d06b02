//! Graph networks over batches of different buildings: initialization, passes and gradients.

mod attention;
mod backward;
mod initial;
mod pass;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;

pub use initial::initialize;
pub use pass::{GraphPass, Readout};
