//! Interrupts (Ctrl-C, SIGTERM): a flag that long-running work polls to stop cleanly.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Id of the process that started this one, if this one is a command of an experiment's job.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Installs the handler: an interrupt or a termination request only sets the flag. A second one ends the process
/// immediately, and its workers with it.
pub fn listen() -> Result<()> {
    #[cfg(target_os = "linux")]
    if let Some(owner) = std::env::var(b2b_experiment::OWNER).ok().and_then(|owner| owner.parse().ok()) {
        OWNER.get_or_init(|| owner);
    }
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            std::process::exit(crate::ExitCode::Interrupted as i32);
        }
    })
    .context("cannot install the Ctrl-C handler")
}

/// Returns whether the user asked to stop, or the owner has ended.
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
