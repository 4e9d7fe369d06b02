//! Installation of EnergyPlus, its example models and weather files from the Python package registry.
//!
//! 1. A [`Package`] is pinned: name, version and the SHA-256 of its wheel for each platform.
//! 2. [`Package::find`] looks in the user's [`Cache`]. If a file changed since they were last verified, all are read
//!    again and compared with the pinned SHA-256.
//! 3. [`Package::ensure`] downloads missing packages with the user's Python package client, verifies the wheel, unpacks
//!    the wanted files to a temporary folder and moves them into place by one rename.
//! 4. [`Engine`] locates the shared library and its files, in the cache or in an installation of the user.
//! 5. [`doctor::report`] reports what is installed and whether it is intact.
//!
//! A [`Progress`] receives the number of bytes and can cancel: the client is then stopped and nothing is left behind.

mod cache;
mod client;
pub mod doctor;
mod engine;
mod error;
mod manifest;
mod package;
mod pinned;
mod progress;
mod sealed;
mod stamp;

pub use cache::{Cache, cache_dir, use_packages_in};
pub use engine::{ENGINE, Engine, Source};
pub use error::{Error, Result};
pub use manifest::{Manifest, UnpackedFile};
pub use package::{Installed, State};
pub use pinned::{Package, Platform, Wheel};
pub use progress::{Progress, Quiet};
pub use sealed::{check as check_sealed, seal, unseal};

/// Version of the packaged EnergyPlus.
pub const ENGINE_VERSION: &str = "25.2.0";
