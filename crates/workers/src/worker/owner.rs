//! The process that a worker belongs to, as the worker sees it.

use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::thread::JoinHandle;

use b2b_energyplus::snapshot::leave;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec};
use rustix::process::{Pid, PidfdFlags};

/// The process that a worker belongs to.
pub(crate) struct Owner {
    process: OwnedFd,
}

impl Owner {
    /// `None` when it is gone already.
    pub(crate) fn find(owner: i32) -> Option<Self> {
        let process = rustix::process::pidfd_open(Pid::from_raw(owner)?, PidfdFlags::empty()).ok()?;
        let is_parent = rustix::process::getppid().is_some_and(|pid| pid.as_raw_pid() == owner);
        is_parent.then_some(Self { process })
    }

    pub(crate) fn is_gone(&self) -> bool {
        let mut ends = [PollFd::new(&self.process, PollFlags::IN)];
        rustix::event::poll(&mut ends, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }

    /// Starts a thread that removes `folder` and ends this process when the owner is gone.
    pub(crate) fn watch(&self, folder: PathBuf) -> std::io::Result<Watch> {
        Watch::start(self.process.try_clone()?, folder)
    }
}

/// A thread that ends this process with its owner, while it is too busy to look.
pub(crate) struct Watch {
    thread: JoinHandle<()>,
    bell: OwnedFd,
}

impl Watch {
    fn start(owner: OwnedFd, folder: PathBuf) -> std::io::Result<Self> {
        let bell = rustix::event::eventfd(0, EventfdFlags::CLOEXEC)?;
        let rung = bell.try_clone()?;
        let thread = std::thread::Builder::new().spawn(move || {
            let mut ends = [PollFd::new(&owner, PollFlags::IN), PollFd::new(&rung, PollFlags::IN)];
            let _ = rustix::event::poll(&mut ends, None);
            if !ends[1].revents().contains(PollFlags::IN) {
                let _ = std::fs::remove_dir_all(folder);
                leave(1);
            }
        })?;
        Ok(Self { thread, bell })
    }

    pub(crate) fn stop(self) -> std::io::Result<()> {
        rustix::io::write(&self.bell, &1u64.to_ne_bytes())?;
        self.thread.join().map_err(|_| std::io::Error::other("the watch panicked"))
    }
}
