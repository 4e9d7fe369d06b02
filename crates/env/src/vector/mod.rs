//! Many environments at once, each in a process of its own, and copies of an environment where it stands.
//!
//! The engine runs once at a time in a process, and a crash of it takes the process along; so every episode has a
//! process. A [`Pool`] starts one [template](Pool::prepare) a building, which warms it up and stands there; an
//! [episode](Pool::begin) is a copy of the template by `fork`, in milliseconds, and a
//! [snapshot](Pool::snapshot) is a copy of an episode. [`VecEnv`] is N environments on a pool.

mod launcher;
mod order;
mod pool;
mod region;
mod sampler;
mod vec_env;
mod worker;

pub use launcher::Launcher;
pub use order::Source;
pub use pool::{Held, Live, Pool, PoolOptions, Setting, TemplateId};
pub use region::Start;
pub use sampler::{AnyOf, Buildings, Draw, Fixed, Population, Sampler, Windows};
pub use vec_env::{Autoreset, VecEnv, VecEnvOptions};
pub use worker::run_if_worker;
