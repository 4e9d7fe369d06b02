//! Ctrl-C and termination: a flag that long-running work polls to stop cleanly.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// The process that this one belongs to, if it is a command of an experiment's job.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Installs the handler: from now on an interrupt or a request to terminate only sets the flag. A second one ends the process
/// at once, unless its supervisor does.
pub fn listen() -> Result<()> {
    #[cfg(target_os = "linux")]
    if let Some(owner) = std::env::var(b2b_experiment::OWNER).ok().and_then(|owner| owner.parse().ok()) {
        OWNER.get_or_init(|| owner);
    }
    ctrlc::set_handler(|| {
        let repeated = REQUESTED.swap(true, Ordering::Relaxed);
        #[cfg(target_os = "linux")]
        let repeated = repeated && !crate::supervision::is_supervised();
        if repeated {
            std::process::exit(crate::ExitCode::Interrupted as i32);
        }
    })
    .context("cannot install the Ctrl-C handler")
}

/// Returns whether the user asked to stop, or the owner is gone.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed) || is_orphan()
}

#[cfg(target_os = "linux")]
fn is_orphan() -> bool {
    OWNER.get().is_some_and(|owner| std::os::unix::process::parent_id() != *owner)
}

#[cfg(not(target_os = "linux"))]
fn is_orphan() -> bool {
    OWNER.get().is_some()
}

/// Errors if the user asked to stop.
pub fn check() -> Result<()> {
    if requested() {
        bail!("interrupted");
    }
    Ok(())
}
