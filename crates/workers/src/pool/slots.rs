//! The owner's table of worker slots and the processes in them.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Signal};

use crate::episode::episode_options::EpisodeOptions;
use crate::region::{LONG_ORDER, LONG_REPORT, Region, SLOTS, Ticket};

/// Time for the parent of an ended process to report its exit status.
const REAPING: Duration = Duration::from_millis(100);
/// Time until the exit status of a lost worker is known, on a busy machine.
const EXIT_STATUS: Duration = Duration::from_secs(1);
/// Length of a worker's last output quoted in an error, bytes.
const LAST_WORDS: usize = 2000;

/// The process of a slot.
#[derive(Debug)]
enum SlotProcess {
    /// Not attached yet, or its handle could not be opened yet.
    Expected,
    /// Attached, by its handle.
    Attached(OwnedFd),
    /// Ended before its handle was opened.
    Ended,
}

/// The worker slots of a pool.
#[derive(Debug)]
pub(crate) struct Slots {
    region: Arc<Region>,
    /// Folder of the workers' log files.
    folder: PathBuf,
    processes: Vec<Option<SlotProcess>>,
    free: Vec<u32>,
    /// Slots whose processes were killed and may not have ended yet.
    dying: Vec<u32>,
}

impl Slots {
    pub(crate) fn new(region: Arc<Region>, folder: &Path) -> Self {
        let folder = folder.to_owned();
        Self { region, folder, processes: Vec::new(), free: Vec::new(), dying: Vec::new() }
    }

    /// Takes a slot for a new worker.
    pub(crate) fn take(&mut self, options: EpisodeOptions) -> io::Result<u32> {
        self.reap();
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => self.another()?,
        };
        self.processes[slot as usize] = Some(SlotProcess::Expected);
        self.region.init(slot, options);
        Ok(slot)
    }

    fn another(&mut self) -> io::Result<u32> {
        let slot = self.processes.len();
        if slot == SLOTS {
            return Err(io::Error::other(format!("all {SLOTS} worker slots are taken")));
        }
        self.region.reserve(slot as u32)?;
        self.processes.push(None);
        Ok(slot as u32)
    }

    /// Ends the worker of a slot; the slot is free once the process has ended.
    pub(crate) fn release(&mut self, slot: u32) {
        let ticket = self.region.ticket(slot);
        if self.region.revoke(slot) {
            self.free(ticket);
        } else {
            self.kill(slot);
            self.dying.push(slot);
        }
    }

    fn free(&mut self, ticket: Ticket) {
        self.processes[ticket.slot as usize] = None;
        self.free.push(ticket.slot);
        for extension in ["log", "json", "mtr", LONG_ORDER, LONG_REPORT] {
            // Most files were never written.
            let _ = std::fs::remove_file(self.folder.join(ticket.file(extension)));
        }
    }

    /// A file of the worker in a slot.
    pub(crate) fn file(&self, slot: u32, extension: &str) -> PathBuf {
        self.folder.join(self.region.ticket(slot).file(extension))
    }

    /// Frees the slots of processes that have ended.
    fn reap(&mut self) {
        for slot in std::mem::take(&mut self.dying) {
            if self.has_ended(slot) {
                self.free(self.region.ticket(slot));
            } else {
                self.dying.push(slot);
            }
        }
    }

    /// Opens a handle to the process in a slot, once it has attached. If the system refuses, for example because of too
    /// many open files, the process stays expected, and the next call tries again.
    pub(crate) fn adopt(&mut self, slot: u32) {
        let Some(process) = Pid::from_raw(self.region.process(slot) as i32) else { return };
        if let Some(entry @ SlotProcess::Expected) = &mut self.processes[slot as usize] {
            match rustix::process::pidfd_open(process, PidfdFlags::empty()) {
                Ok(handle) => *entry = SlotProcess::Attached(handle),
                Err(Errno::SRCH) => *entry = SlotProcess::Ended,
                Err(_) => {}
            }
        }
    }

    /// Assigns a child of this process to a slot.
    pub(crate) fn adopt_child(&mut self, slot: u32, child: u32) -> io::Result<()> {
        let pid = Pid::from_raw(child as i32).ok_or_else(|| io::Error::other("a process without an ID"))?;
        let handle = rustix::process::pidfd_open(pid, PidfdFlags::empty())?;
        self.processes[slot as usize] = Some(SlotProcess::Attached(handle));
        Ok(())
    }

    /// Returns whether the process in a slot has ended. A process without a handle counts as running.
    pub(crate) fn has_ended(&mut self, slot: u32) -> bool {
        self.adopt(slot);
        match &self.processes[slot as usize] {
            None | Some(SlotProcess::Ended) => true,
            Some(SlotProcess::Expected) => false,
            Some(SlotProcess::Attached(handle)) => {
                let mut ends = [PollFd::new(handle, PollFlags::IN)];
                rustix::event::poll(&mut ends, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
            }
        }
    }

    /// Kills the process in a slot, if there is one.
    pub(crate) fn kill(&mut self, slot: u32) {
        self.adopt(slot);
        if let Some(SlotProcess::Attached(handle)) = &self.processes[slot as usize] {
            // It may have ended already.
            let _ = rustix::process::pidfd_send_signal(handle, Signal::KILL);
        }
    }

    /// Describes how the process in a slot ended, if known, with its last output.
    pub(crate) fn describe_end(&self, slot: u32, status: Option<ExitStatus>) -> String {
        let began = Instant::now();
        let status = loop {
            let status = status.or(self.region.exit(slot).map(ExitStatus::from_raw));
            if status.is_some() || began.elapsed() > EXIT_STATUS {
                break status;
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let process = match self.region.process(slot) {
            0 => "a worker process".to_owned(),
            process => format!("worker process {process}"),
        };
        let end = match status {
            Some(status) if status.signal() == Some(Signal::XFSZ.as_raw()) => {
                format!("wrote a file that exceeds `ulimit -f`: raise the limit ({status})")
            }
            Some(status) if status.signal().is_some() => format!("was killed or crashed ({status})"),
            Some(status) => format!("ended by itself ({status})"),
            None => "was killed or crashed".to_owned(),
        };
        match self.last_words(slot) {
            Some(words) => format!("{process} {end}; its last output:\n{words}"),
            None => format!("{process} {end}"),
        }
    }

    /// The last lines that a worker wrote to its standard error.
    fn last_words(&self, slot: u32) -> Option<String> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = File::open(self.file(slot, "log")).ok()?;
        let length = file.metadata().ok()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LAST_WORDS as u64))).ok()?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).ok()?;
        let text = String::from_utf8_lossy(&bytes).trim().to_owned();
        (!text.is_empty()).then_some(text)
    }

    /// Kills all processes except those in the `spared` slots, and waits until they have ended and been reaped.
    pub(crate) fn end_all_but(&mut self, spared: &[u32]) {
        let all = 0..self.processes.len() as u32;
        let others: Vec<u32> = all.filter(|slot| !spared.contains(slot)).collect();
        others.iter().for_each(|slot| self.kill(*slot));
        let deadline = Instant::now() + Duration::from_secs(5);
        for slot in others {
            let used = matches!(self.processes[slot as usize], Some(SlotProcess::Attached(_)));
            while used && !self.has_ended(slot) && Instant::now() < deadline {
                std::thread::sleep(Duration::from_micros(200));
            }
            let reaped = Instant::now() + REAPING;
            while used && self.region.exit(slot).is_none() && Instant::now() < reaped.min(deadline) {
                std::thread::sleep(Duration::from_micros(200));
            }
        }
    }
}
