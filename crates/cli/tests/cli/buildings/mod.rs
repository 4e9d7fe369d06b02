//! Commands about buildings and models.

#[cfg(target_os = "linux")]
mod calibrate;
#[cfg(unix)]
mod dataset;
#[cfg(unix)]
mod edit;
#[cfg(unix)]
mod import;
#[cfg(unix)]
mod show;
