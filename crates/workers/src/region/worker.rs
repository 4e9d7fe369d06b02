//! A worker's side of the region.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::handover::{await_slot, give_back};
use super::{COPIES, Command, EXITED, Region, Ticket, pack, unpack};

impl Region {
    /// Attaches this process to a slot. Returns `false` if the slot has been reassigned.
    pub(crate) fn attach(&self, Ticket { slot, generation }: Ticket) -> bool {
        let (awaited, own) = (pack(generation, 0), pack(generation, std::process::id()));
        let occupant = &self.slot(slot).occupant;
        occupant.compare_exchange(awaited, own, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Marks the slot as ready, and wakes the owner if this is the last slot it waits for.
    pub(crate) fn complete(&self, slot: u32) {
        give_back(&self.slot(slot).state, self.bell().words());
    }

    /// Waits for a command; `None` after a timeout or a signal.
    pub(crate) fn next_command(&self, slot: u32, at_most: Duration) -> Option<Command> {
        let slot = self.slot(slot);
        if !await_slot(&slot.state, at_most, |is_over| self.wait_actively(is_over)) {
            return None;
        }
        Some(match slot.command.load(Ordering::Relaxed) {
            0 => Command::Step,
            1 => Command::Copy,
            2 => Command::Fragment,
            _ => Command::LongFragment,
        })
    }

    /// The slots listed for copies, without revoked ones.
    pub(crate) fn copies(&self, slot: u32) -> Vec<Ticket> {
        let entry = self.slot(slot);
        let count = (entry.copies.load(Ordering::Relaxed) as usize).min(COPIES);
        let listed = entry.copy_list.iter().take(count).map(|item| {
            let (generation, slot) = unpack(item.load(Ordering::Relaxed));
            Ticket { slot, generation }
        });
        listed.filter(|ticket| self.ticket(ticket.slot) == *ticket).collect()
    }

    /// Stores the wait status of a process that was attached to a slot.
    pub(crate) fn record_exit(&self, process: u32, status: i32) {
        let slots = self.bell().slots.load(Ordering::SeqCst);
        if let Some(slot) = (0..slots).find(|slot| self.process(*slot) == process) {
            self.slot(slot).exit.store(status as u32 | EXITED, Ordering::Release);
        }
    }
}
