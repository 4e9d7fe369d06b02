//! Child processes with a reply.

use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ExitStatus};

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::process::{Pid, PidfdFlags, Signal};

use super::region::LOOK;

/// A child process that is killed on drop.
#[derive(Debug)]
pub(super) struct Process {
    pub(super) child: Child,
    /// Becomes readable at its end; `None` if the system cannot watch a process.
    end: Option<OwnedFd>,
}

impl Process {
    pub(super) fn new(child: Child) -> Self {
        let end = rustix::process::pidfd_open(Pid::from_child(&child), PidfdFlags::empty()).ok();
        Self { child, end }
    }

    /// Waits for at most [`LOOK`], and returns how the process ended; `None` if it has not.
    pub(super) fn wait_briefly(&mut self) -> io::Result<Option<ExitStatus>> {
        if let Some(status) = self.child.try_wait()? {
            return Ok(Some(status));
        }
        match &self.end {
            // A signal ends the wait early.
            Some(end) => {
                let look = Timespec { tv_sec: 0, tv_nsec: LOOK.as_nanos() as i64 };
                let _ = rustix::event::poll(&mut [PollFd::new(end, PollFlags::IN)], Some(&look));
            }
            None => std::thread::sleep(LOOK / 10),
        }
        self.child.try_wait()
    }

    /// Asks the process to end.
    pub(super) fn terminate(&self) {
        // It may have ended already.
        let _ = rustix::process::kill_process(Pid::from_child(&self.child), Signal::TERM);
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Describes the end of a process that left no reply.
pub(super) fn describe(status: ExitStatus) -> String {
    let Some(signal) = status.signal() else { return format!("ended without a reply ({status})") };
    let known = [
        (Signal::SEGV, ", a segmentation fault"),
        (Signal::ABORT, ", an abort"),
        (Signal::BUS, ", a bus error"),
        (Signal::ILL, ", an illegal instruction"),
        (Signal::FPE, ", an arithmetic error"),
        (Signal::XFSZ, ", a file that exceeds `ulimit -f`: raise the limit"),
        (Signal::KILL, ", which the system sends when memory is exhausted"),
    ];
    let name = known.iter().find(|(known, _)| known.as_raw() == signal).map_or("", |(_, name)| *name);
    format!("crashed (signal {signal}{name})")
}
