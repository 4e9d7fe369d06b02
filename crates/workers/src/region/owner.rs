//! The owner's side of the region.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::handover::{await_done, give, is_back};
use super::{BUSY, Command, EpisodeOptions, READY, Region, Status, Ticket, pack};

impl Region {
    /// Initializes a slot for a new worker: busy until the worker reports.
    pub(crate) fn init(&self, slot: u32, options: EpisodeOptions) {
        let entry = self.slot(slot);
        let Ticket { generation, .. } = self.ticket(slot);
        entry.report_bytes.store(0, Ordering::Relaxed);
        entry.exit.store(0, Ordering::Relaxed);
        let steps = options.max_steps.map_or(0, |steps| steps.clamp(1, u32::MAX as usize) as u32);
        entry.steps.store(steps, Ordering::Relaxed);
        entry.processor.store(options.processor.map_or(0, |processor| processor + 1), Ordering::Relaxed);
        entry.finish_run.store(options.finish_run.into(), Ordering::Relaxed);
        entry.status.store(Status::Running as u32, Ordering::Relaxed);
        entry.state.store(BUSY, Ordering::Relaxed);
        entry.occupant.store(pack(generation.wrapping_add(1), 0), Ordering::Release);
    }

    /// Revokes a slot from a worker that has not attached, which it then never can. Returns `false` if it has attached.
    pub(crate) fn revoke(&self, slot: u32) -> bool {
        let Ticket { generation, .. } = self.ticket(slot);
        let (awaited, next) = (pack(generation, 0), pack(generation.wrapping_add(1), 0));
        let occupant = &self.slot(slot).occupant;
        occupant.compare_exchange(awaited, next, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Reports a failure on behalf of a worker that never attached.
    pub(crate) fn fail(&self, slot: u32, why: &str) {
        self.write_report(slot, why.as_bytes());
        self.set_status(slot, Status::Failed);
        self.slot(slot).state.store(READY, Ordering::Release);
    }

    /// Sends a command to the worker of a ready slot.
    pub(crate) fn command(&self, slot: u32, command: Command) {
        let slot = self.slot(slot);
        slot.command.store(command as u32, Ordering::Relaxed);
        give(&slot.state);
    }

    /// Lists the slots for [`Command::Copy`].
    pub(crate) fn list_copies(&self, slot: u32, copies: &[u32]) {
        let entry = self.slot(slot);
        for (item, copy) in entry.copy_list.iter().zip(copies) {
            let Ticket { slot, generation } = self.ticket(*copy);
            item.store(pack(generation, slot), Ordering::Relaxed);
        }
        entry.copies.store(copies.len() as u32, Ordering::Relaxed);
    }

    /// Returns whether the owner holds a slot.
    pub(crate) fn is_ready(&self, slot: u32) -> bool {
        is_back(&self.slot(slot).state)
    }

    /// Number of commands executed so far, to read before checking slots and pass to [`Region::sleep`].
    pub(crate) fn done(&self) -> u32 {
        self.bell().done.load(Ordering::SeqCst)
    }

    /// Sleeps until `more` commands after `done` are executed, a timeout, or a signal.
    pub(crate) fn sleep(&self, done: u32, more: u32, at_most: Duration) {
        await_done(self.bell().words(), (done, more), at_most, |is_over| self.wait_actively(is_over));
    }
}
