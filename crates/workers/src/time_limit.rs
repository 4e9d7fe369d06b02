//! Time limits of workers.

use std::time::{Duration, Instant};

use super::region::LOOK;

/// Maximum counted time between two checks. A waiting owner checks every [`LOOK`].
const BETWEEN_LOOKS: Duration = LOOK.saturating_mul(2);

/// A limit on the time that a worker takes while its owner waits for it.
///
/// Time in which the owner does not check hardly counts, because workers of a stopped owner or machine were stopped,
/// too, and need time to continue. A worker that hangs while its owner is busy elsewhere is detected later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TimeLimit {
    left: Duration,
    /// Time of the last check.
    looked: Instant,
}

impl TimeLimit {
    /// Creates a limit that begins now.
    pub(super) fn new(limit: Duration) -> Self {
        Self { left: limit, looked: Instant::now() }
    }

    /// Checks the clock. Returns whether the limit is exceeded.
    pub(super) fn is_exceeded(&mut self) -> bool {
        let now = Instant::now();
        let passed = now.duration_since(self.looked).min(BETWEEN_LOOKS);
        self.looked = now;
        self.left = self.left.saturating_sub(passed);
        self.left.is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a limit that was last checked some time ago.
    fn looked_at(before: Duration, left: Duration) -> TimeLimit {
        TimeLimit { left, looked: Instant::now().checked_sub(before).unwrap() }
    }

    #[test]
    fn time_without_checks_counts_as_two_intervals() {
        let mut limit = looked_at(Duration::from_secs(3), Duration::from_secs(1));
        assert!(!limit.is_exceeded());
        assert_eq!(limit.left, Duration::from_secs(1) - BETWEEN_LOOKS);
    }

    #[test]
    fn time_between_the_checks_of_a_waiting_owner_counts_in_full() {
        let mut limit = looked_at(LOOK, LOOK * 3);
        assert!(!limit.is_exceeded());
        assert!(limit.left <= LOOK * 2);
    }

    #[test]
    fn a_limit_is_exceeded_even_with_rare_checks() {
        let mut limit = TimeLimit::new(BETWEEN_LOOKS * 5);
        let looks = (1..).find(|_| {
            limit.looked = limit.looked.checked_sub(Duration::from_secs(60)).unwrap();
            limit.is_exceeded()
        });
        assert_eq!(looks, Some(5));
    }
}
