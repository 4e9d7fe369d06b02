//! The `b2b` program from the outside, on the real engine. One program, so that its tests fill all cores to the end.

#[cfg(target_os = "linux")]
mod agents;
mod buildings;
#[cfg(unix)]
mod command;
mod contributing;
#[cfg(target_os = "linux")]
mod current_folder;
#[cfg(target_os = "linux")]
mod gate;
mod golden;
#[cfg(target_os = "linux")]
mod pages;
#[cfg(target_os = "linux")]
mod policies;
mod program;
mod readme;
mod seasons;
#[cfg(target_os = "linux")]
mod serve;
mod terminal;
#[cfg(target_os = "linux")]
mod trust;
