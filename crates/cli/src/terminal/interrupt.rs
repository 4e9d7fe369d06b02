//! Signals. Interrupts (Ctrl-C, SIGTERM) set a flag that long-running work polls to stop cleanly. A file beyond the
//! size limit is an error for its writer and does not end the process.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Id of the process that started this one, if this is an action that ends with it.
static OWNER: OnceLock<u32> = OnceLock::new();

/// Whether a file exceeded the size limit of this process.
static TOO_LARGE: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Time for a command to stop before it is killed, s.
const GRACE: u32 = 10;
/// Whether the command may take longer to stop.
static PATIENT: AtomicBool = AtomicBool::new(false);

/// Installs the handlers. An interrupt or a termination request only sets the flag; a second one, or [`GRACE`] after
/// the first unless [`be_patient`] was called, ends the process and its workers immediately.
pub fn listen() -> Result<()> {
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::clone(&TOO_LARGE))
        .context("cannot install the handler of file sizes")?;
    let handled =
        [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| *signal != SIGHUP || !ignores_hangups());
    let mut signals = Signals::new(handled).context("cannot install the Ctrl-C handler")?;
    std::thread::spawn(move || signals.forever().for_each(|_| request()));
    Ok(())
}

/// Returns whether the process was started with `nohup`: hangups are ignored, and stay so.
fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 1)
}

/// Requests the end of the command; the second time, ends it.
fn request() {
    if REQUESTED.swap(true, Ordering::Relaxed) {
        end();
    }
    if !PATIENT.load(Ordering::Relaxed) {
        std::thread::spawn(end_after_grace);
    }
}

/// Installs the handlers in a process that stops when the one that started it has ended.
pub fn listen_with_owner() -> Result<()> {
    OWNER.get_or_init(std::os::unix::process::parent_id);
    listen()
}

/// Ends a process whose work does not poll the flag, such as a network that never ends. Time during which the process
/// is stopped does not count.
fn end_after_grace() {
    (0..GRACE).for_each(|_| std::thread::sleep(Duration::from_secs(1)));
    eprintln!("interrupted; work that did not stop within {GRACE} s was killed");
    end();
}

/// Ends the process and its workers, after removing its temporary folders.
fn end() -> ! {
    b2b_base::scratch::remove_all();
    std::process::exit(crate::ExitCode::Interrupted as i32)
}

/// Returns a remedy for an error, if a file exceeded the size limit.
pub fn remedy() -> Option<&'static str> {
    TOO_LARGE
        .load(Ordering::Relaxed)
        .then_some("a file exceeded the size that `ulimit -f` allows: raise the limit")
}

/// Lets the command take longer to stop, because it writes a checkpoint first.
pub fn be_patient() {
    PATIENT.store(true, Ordering::Relaxed);
}

/// Returns whether the user asked to stop, or the owner has ended.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed) || is_orphan()
}

fn is_orphan() -> bool {
    OWNER.get().is_some_and(|owner| std::os::unix::process::parent_id() != *owner)
}

/// Errors if the user asked to stop, or the owner has ended.
pub fn check() -> Result<()> {
    if requested() {
        bail!("interrupted");
    }
    Ok(())
}
