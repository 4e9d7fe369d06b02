//! The `b2b` program from the outside, on the real engine. One program, so that its tests fill all cores to the end.

#[cfg(target_os = "linux")]
mod benchmark;
#[cfg(target_os = "linux")]
mod browser;
#[cfg(target_os = "linux")]
mod calibrate;
#[cfg(unix)]
mod command;
#[cfg(target_os = "linux")]
mod compare;
#[cfg(target_os = "linux")]
mod current_folder;
#[cfg(unix)]
mod dataset;
#[cfg(unix)]
mod edit;
#[cfg(target_os = "linux")]
mod evaluate;
#[cfg(target_os = "linux")]
mod evaluation;
#[cfg(target_os = "linux")]
mod experiment;
#[cfg(target_os = "linux")]
mod gate;
mod golden;
#[cfg(unix)]
mod import;
#[cfg(target_os = "linux")]
mod offline;
#[cfg(target_os = "linux")]
mod onnx_file;
#[cfg(target_os = "linux")]
mod operation;
#[cfg(target_os = "linux")]
mod pages;
mod program;
mod readme;
mod seasons;
#[cfg(target_os = "linux")]
mod serve;
#[cfg(unix)]
mod show;
mod terminal;
#[cfg(target_os = "linux")]
mod train;
#[cfg(target_os = "linux")]
mod trust;
#[cfg(target_os = "linux")]
mod tune;
#[cfg(target_os = "linux")]
mod verification;
