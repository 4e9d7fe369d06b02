//! Training by Stable-Baselines3, for comparison.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use anyhow::{Result, bail};
use serde::Deserialize;

use super::child;
use crate::terminal::interrupt;

/// The speed of training by Stable-Baselines3.
#[derive(Clone, Copy, Deserialize)]
pub(super) struct Speed {
    pub(super) steps_per_s: f64,
    /// `None` if an episode ended during the measurement.
    pub(super) steps_per_cpu_s: Option<f64>,
}

/// An interpreter with building2building and Stable-Baselines3.
pub(super) struct Python {
    interpreter: String,
}

impl Python {
    /// Returns the interpreter if it can import both; otherwise prints the reason on standard error.
    pub(super) fn find(interpreter: &str) -> Result<Option<Self>> {
        let mut command = isolated(interpreter)?;
        command.args(["-c", "import building2building.bench, stable_baselines3"]);
        let outcome = child::output(command);
        interrupt::check()?;
        let why = match outcome {
            Ok(Ok(_)) => return Ok(Some(Self { interpreter: interpreter.to_owned() })),
            Ok(Err(text)) => text.lines().last().unwrap_or("it failed").to_owned(),
            Err(error) => format!("{error:#}"),
        };
        eprintln!(
            "Stable-Baselines3 is not measured: `{interpreter}` cannot import building2building and stable_baselines3 \
             ({why}); name another interpreter with --python"
        );
        Ok(None)
    }

    /// Measures training on a building of the dataset, over at least `steps` steps after the first rollout.
    pub(super) fn measure(&self, building: &str, environments: u32, steps: u64) -> Result<Speed> {
        let mut command = isolated(&self.interpreter)?;
        command.args(["-m", "building2building.bench", "--json", "--train", building]);
        command.args(["--environments", &environments.to_string(), "--steps", &steps.to_string()]);
        match child::output(command)? {
            Ok(text) => Ok(serde_json::from_str(text.trim())?),
            Err(text) => bail!("training by Stable-Baselines3 failed:\n{text}"),
        }
    }
}

/// Returns a command that starts an interpreter that imports no code from the current folder.
fn isolated(interpreter: &str) -> Result<Command> {
    let path = Path::new(interpreter);
    let path: OsString = match path.components().count() {
        // A bare name, which is looked up in `PATH`.
        0 | 1 => path.into(),
        _ => std::path::absolute(path)?.into(),
    };
    let mut command = Command::new(path);
    command.arg("-I").current_dir("/");
    if let Ok(cache) = b2b_energyplus::install::cache_dir() {
        command.env("B2B_CACHE", cache);
    }
    Ok(command)
}
