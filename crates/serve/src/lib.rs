//! BOPTEST's interface: a building behind the REST calls of the Building Optimization Testing Framework, so that
//! clients written for it run against any building here.
//!
//! - A [`Subject`] is the served building: prepared, with its weather, task and baseline controller, and the points,
//!   prices and forecasts derived from them.
//! - [`serve`] answers HTTP requests until it is stopped. `http` has the routes and the tests in progress,
//!   `calls` the calls with their arguments and answers.
//! - Each test runs in a thread with its own worker processes (`simulation`), so a crash of the engine is an answer
//!   with status 500 and the server keeps running.
//!
//! `docs/serve.md` describes the calls and what differs from BOPTEST.
#![forbid(unsafe_code)]

mod calls;
mod error;
mod http;
mod simulation;
mod subject;

pub use error::{Error, Result};
pub use http::{Options, serve};
pub use subject::{Subject, SubjectOptions};
