//! Sleeping and waking on a word of shared memory.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use rustix::thread::futex::{self, Timespec};

use super::handover::Word;

impl Word for AtomicU32 {
    fn load(&self, order: Ordering) -> u32 {
        self.load(order)
    }

    fn store(&self, value: u32, order: Ordering) {
        self.store(value, order);
    }

    fn add(&self, value: u32) -> u32 {
        self.fetch_add(value, Ordering::SeqCst).wrapping_add(value)
    }

    fn sleep(&self, value: u32, at_most: Duration) {
        let time = Timespec { tv_sec: at_most.as_secs() as i64, tv_nsec: at_most.subsec_nanos().into() };
        // After every wake-up, the word is checked again.
        let _ = futex::wait(self, futex::Flags::empty(), value, Some(&time));
    }

    fn wake(&self) {
        // Cannot fail on a valid address.
        let _ = futex::wake(self, futex::Flags::empty(), 1);
    }
}
