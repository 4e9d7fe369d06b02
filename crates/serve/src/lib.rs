//! BOPTEST's interface: a building behind the REST calls of the Building Optimization Testing Framework, so that clients
//! written for it run against any building here.
//!
//! - A [`Subject`] is what is served: a prepared building with its weather, task and baseline controller, and the points,
//!   prices and forecasts that follow from them.
//! - [`serve`] answers HTTP requests until it is told to stop. `http` has the calls and the tests in progress.
//! - Each test runs in a thread with worker processes of its own (`simulation`): a crash of the engine is an answer with
//!   status 500, and the server goes on.
//!
//! `docs/serve.md` describes the calls and what differs from BOPTEST.
#![cfg(target_os = "linux")]
#![forbid(unsafe_code)]

mod error;
mod http;
mod simulation;
mod subject;

pub use error::{Error, Result};
pub use http::{Options, serve};
pub use subject::{Subject, SubjectOptions};
