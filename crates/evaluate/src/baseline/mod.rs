//! Baselines: the reactive controllers, or the guideline controller in an operation task. Shipped for the small test
//! split, cached for everything else once computed.
//!
//! A task is scored against the reactive controllers with the parameters of its objective: comfort alone, or comfort
//! and energy. Within an objective, their actions depend on neither the weight of energy nor its scale, and comfort and
//! energy are summed separately: one episode gives the return for every weight. The same holds for the guideline
//! controller.

mod key;
mod store;
pub mod table;

pub use key::Key;
pub use store::Baselines;
