//! Spinning for a moment before sleeping.
//!
//! Waking a process that sleeps on a futex takes 50 to 150 µs if its core sleeps too, longer than a step of a house. If
//! every process has its own core, both sides therefore spin for the time of a long step first.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Longest spin.
const AT_MOST: Duration = Duration::from_micros(400);
/// Number of checks between two readings of the clock.
const LOOKS: u32 = 32;
/// Maximum number of consecutive waits without spinning after unsuccessful spins, when the other side is slow or other
/// programs use the cores.
const LONGEST_PAUSE: u32 = 256;

/// The spins of one side.
#[derive(Debug, Default)]
pub(super) struct Spin {
    /// Length of the last pause, in waits.
    pause: AtomicU32,
    /// Waits left in the pause.
    left: AtomicU32,
}

impl Spin {
    /// Spins until a condition holds, and returns whether it does. After every unsuccessful spin, pauses for twice as
    /// many waits as before.
    pub(super) fn until(&self, is_over: impl Fn() -> bool) -> bool {
        let left = self.left.load(Ordering::Relaxed);
        if left > 0 {
            self.left.store(left - 1, Ordering::Relaxed);
            return is_over();
        }
        let began = Instant::now();
        while began.elapsed() < AT_MOST {
            for _ in 0..LOOKS {
                if is_over() {
                    self.pause.store(0, Ordering::Relaxed);
                    return true;
                }
                std::hint::spin_loop();
            }
        }
        let pause = (2 * self.pause.load(Ordering::Relaxed)).clamp(1, LONGEST_PAUSE);
        self.pause.store(pause, Ordering::Relaxed);
        self.left.store(pause, Ordering::Relaxed);
        is_over()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn unsuccessful_spins_become_rare_until_one_succeeds() {
        let (spin, looks) = (Spin::default(), Cell::new(0u64));
        let never = || {
            looks.set(looks.get() + 1);
            false
        };
        let active = |spin: &Spin| {
            looks.set(0);
            assert!(!spin.until(never));
            looks.get() > 1
        };
        let actives = (0..100).filter(|_| active(&spin)).count();
        assert_eq!(actives, 7, "the 1st, 3rd, 6th, 11th, 20th, 37th and 70th wait");
        for _ in 0..LONGEST_PAUSE {
            spin.until(|| true);
        }
        assert!(spin.until(|| true) && active(&spin), "after a success the next wait is active");
    }
}
