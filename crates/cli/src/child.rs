//! This program again, in a process of its own: the engine runs once at a time in a process, and a crash ends it.

use std::io::{Read, Seek};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::interrupt;

/// What a run of this program with these arguments prints, or what it says when it fails. An interrupt ends it.
pub fn run<I: AsRef<std::ffi::OsStr>>(
    arguments: impl IntoIterator<Item = I>,
) -> Result<Result<String, String>> {
    let program = std::env::current_exe()?;
    let mut command = Command::new(program);
    // Files, because a pipe that nobody reads yet holds little.
    let (mut said, mut complaint) = (tempfile::tempfile()?, tempfile::tempfile()?);
    command.args(arguments).stdin(Stdio::null()).stdout(said.try_clone()?).stderr(complaint.try_clone()?);
    let success = wait(&mut command.spawn().context("cannot start a process")?)?;
    let file = if success { &mut said } else { &mut complaint };
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
