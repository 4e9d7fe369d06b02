//! Child processes of other programs.

use std::io::{Read, Seek};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::interrupt;

/// Runs a command and returns its standard output, or its standard error if it fails. Errors if it cannot be started or
/// is interrupted.
pub(super) fn output(mut command: Command) -> Result<Result<String, String>> {
    // Files, because a full pipe would block the child.
    let (mut output, mut errors) = (tempfile::tempfile()?, tempfile::tempfile()?);
    command.stdin(Stdio::null()).stdout(output.try_clone()?).stderr(errors.try_clone()?);
    let success = wait(&mut command.spawn().context("cannot start a process")?)?;
    let file = if success { &mut output } else { &mut errors };
    let mut text = String::new();
    file.rewind()?;
    file.read_to_string(&mut text)?;
    Ok(if success { Ok(text) } else { Err(text.trim().to_owned()) })
}

fn wait(child: &mut Child) -> Result<bool> {
    loop {
        if let Some(status) = child.try_wait()? {
            interrupt::check()?;
            return Ok(status.success());
        }
        if interrupt::requested() {
            child.kill()?;
            child.wait()?;
            bail!("interrupted");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}
