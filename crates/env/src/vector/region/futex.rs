//! Sleeping and waking on a word of shared memory.

use std::sync::atomic::AtomicU32;
use std::time::Duration;

use rustix::thread::futex::{self, Timespec};

/// Sleeps while the word has this value, until it is woken, the time is over or a signal comes.
pub(super) fn wait(word: &AtomicU32, value: u32, at_most: Duration) {
    let time = Timespec { tv_sec: at_most.as_secs() as i64, tv_nsec: at_most.subsec_nanos().into() };
    // Every way of waking up is followed by another look at the word.
    let _ = futex::wait(word, futex::Flags::empty(), value, Some(&time));
}

/// Wakes one process that sleeps on the word.
pub(super) fn wake(word: &AtomicU32) {
    // Cannot fail on a valid address.
    let _ = futex::wake(word, futex::Flags::empty(), 1);
}
