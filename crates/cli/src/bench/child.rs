//! Child processes of other programs.

use std::io::{Read, Seek};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::terminal::interrupt;

/// Time that a child has to stop before it is killed.
const GRACE: Duration = Duration::from_secs(5);

/// Runs a command and returns its standard output, or its standard error if it fails. Errors if it cannot be started or
/// is interrupted. Its temporary files are removed in any case.
pub(super) fn output(mut command: Command) -> Result<Result<String, String>> {
    // Files, because a full pipe would block the child.
    let (mut output, mut errors) = (tempfile::tempfile()?, tempfile::tempfile()?);
    let folder = b2b_base::scratch::temporary_folder("b2b-")?;
    command.env("TMPDIR", folder.path());
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
            stop(child)?;
            bail!("interrupted");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Ends a child, which may first end its own children.
fn stop(child: &mut Child) -> Result<()> {
    {
        // Fails if it has just ended.
        let _ = rustix::process::kill_process(
            rustix::process::Pid::from_child(child),
            rustix::process::Signal::TERM,
        );
        let begun = Instant::now();
        while begun.elapsed() < GRACE {
            if child.try_wait()?.is_some() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    child.kill()?;
    child.wait()?;
    Ok(())
}
