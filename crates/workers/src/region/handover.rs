//! How a slot passes between the sides, and how each waits for the other. The tests explore all interleavings.

use std::sync::atomic::Ordering;
use std::time::Duration;

/// The slot waits for the owner.
pub(super) const READY: u32 = 0;
/// A command is in progress.
pub(super) const BUSY: u32 = 1;

/// A word of shared memory that processes can sleep on.
pub(super) trait Word {
    fn load(&self, order: Ordering) -> u32;

    fn store(&self, value: u32, order: Ordering);

    /// Adds to the word, and returns the sum; sequentially consistent.
    fn add(&self, value: u32) -> u32;

    /// Sleeps while the word has this value, until a wake-up, the timeout or a signal.
    fn sleep(&self, value: u32, at_most: Duration);

    /// Wakes one process that sleeps on the word.
    fn wake(&self);
}

/// The words by which the owner waits for several workers at once.
pub(super) struct Bell<'a, W> {
    /// Number of commands executed by all workers.
    pub(super) done: &'a W,
    /// The owner is woken when `done` reaches this.
    pub(super) wanted: &'a W,
}

/// Passes a slot, with the owner's writes, to the worker.
pub(super) fn give(state: &impl Word) {
    state.store(BUSY, Ordering::Release);
    state.wake();
}

/// Waits for the worker's slot, and returns whether the worker has it. `actively` checks whether the wait is over, once
/// or repeatedly.
pub(super) fn await_slot(
    state: &impl Word,
    at_most: Duration,
    actively: impl FnOnce(&dyn Fn() -> bool) -> bool,
) -> bool {
    let is_given = || state.load(Ordering::Acquire) != READY;
    actively(&is_given) || {
        state.sleep(READY, at_most);
        is_given()
    }
}

/// Returns the worker's slot, and wakes the owner if this is the last slot it waits for.
pub(super) fn give_back<W: Word>(state: &W, bell: Bell<'_, W>) {
    state.store(READY, Ordering::Release);
    let done = bell.done.add(1);
    if done.wrapping_sub(bell.wanted.load(Ordering::SeqCst)) as i32 >= 0 {
        bell.done.wake();
    }
}

/// Returns whether the owner has a slot.
pub(super) fn is_back(state: &impl Word) -> bool {
    state.load(Ordering::Acquire) == READY
}

/// Waits until `more` commands after `done` are executed; may return early.
pub(super) fn await_done<W: Word>(
    bell: Bell<'_, W>,
    (done, more): (u32, u32),
    at_most: Duration,
    actively: impl FnOnce(&dyn Fn() -> bool) -> bool,
) {
    bell.wanted.store(done.wrapping_add(more), Ordering::SeqCst);
    let is_over = |now: u32| now.wrapping_sub(done) as i32 >= more as i32;
    if actively(&|| is_over(bell.done.load(Ordering::SeqCst))) {
        return;
    }
    let now = bell.done.load(Ordering::SeqCst);
    if !is_over(now) {
        bell.done.sleep(now, at_most);
    }
}

#[cfg(test)]
mod tests {
    use loom::cell::UnsafeCell;
    use loom::sync::atomic::AtomicU32;
    use loom::sync::{Arc, Condvar, Mutex};
    use loom::thread;

    use super::*;

    const FOREVER: Duration = Duration::MAX;

    /// A word whose futex is a condition variable without spurious wake-ups, so that a lost wake-up is a deadlock. Loom
    /// weakens sequentially consistent loads and stores to acquire and release; as read-modify-writes, they have one
    /// order.
    struct Modeled {
        value: AtomicU32,
        queue: Mutex<()>,
        woken: Condvar,
    }

    impl Modeled {
        fn new(value: u32) -> Self {
            Self { value: AtomicU32::new(value), queue: Mutex::new(()), woken: Condvar::new() }
        }
    }

    impl Word for Modeled {
        fn load(&self, order: Ordering) -> u32 {
            match order {
                Ordering::SeqCst => self.value.fetch_add(0, order),
                _ => self.value.load(order),
            }
        }

        fn store(&self, value: u32, order: Ordering) {
            match order {
                Ordering::SeqCst => {
                    self.value.swap(value, order);
                }
                _ => self.value.store(value, order),
            }
        }

        fn add(&self, value: u32) -> u32 {
            self.value.fetch_add(value, Ordering::SeqCst).wrapping_add(value)
        }

        fn sleep(&self, value: u32, _: Duration) {
            let queue = self.queue.lock().unwrap();
            // The kernel compares under the lock of the queue.
            if self.value.load(Ordering::Acquire) == value {
                drop(self.woken.wait(queue).unwrap());
            }
        }

        fn wake(&self) {
            let _queue = self.queue.lock().unwrap();
            self.woken.notify_one();
        }
    }

    /// A slot with data written by its holder.
    struct ModeledSlot {
        state: Modeled,
        number: UnsafeCell<u32>,
    }

    struct Shared {
        slots: Vec<ModeledSlot>,
        done: Modeled,
        wanted: Modeled,
    }

    impl Shared {
        fn new(slots: usize) -> Self {
            let slot = |_| ModeledSlot { state: Modeled::new(READY), number: UnsafeCell::new(0) };
            Self { slots: (0..slots).map(slot).collect(), done: Modeled::new(0), wanted: Modeled::new(0) }
        }

        fn bell(&self) -> Bell<'_, Modeled> {
            Bell { done: &self.done, wanted: &self.wanted }
        }

        /// Adds 1 to the number of a slot, once for each command.
        fn work(&self, slot: usize, commands: usize) {
            let slot = &self.slots[slot];
            for _ in 0..commands {
                while !await_slot(&slot.state, FOREVER, |is_over| is_over()) {}
                // SAFETY: the worker holds the slot; loom checks it.
                slot.number.with_mut(|number| unsafe { *number += 1 });
                give_back(&slot.state, self.bell());
            }
        }

        /// Gives a command to every slot, waits for all, and returns the numbers.
        fn step(&self) -> Vec<u32> {
            for slot in &self.slots {
                // SAFETY: the owner holds the slot; loom checks it.
                slot.number.with_mut(|number| unsafe { *number += 10 });
                give(&slot.state);
            }
            loop {
                let done = self.done.load(Ordering::SeqCst);
                let missing = self.slots.iter().filter(|slot| !is_back(&slot.state)).count() as u32;
                if missing == 0 {
                    break;
                }
                await_done(self.bell(), (done, missing), FOREVER, |is_over| is_over());
            }
            // SAFETY: as above.
            self.slots.iter().map(|slot| slot.number.with(|number| unsafe { *number })).collect()
        }
    }

    /// Runs all interleavings of an owner and one worker per slot, optionally limited to a maximum number of
    /// preemptions.
    fn explore(slots: usize, commands: usize, preemptions: Option<usize>) {
        let mut model = loom::model::Builder::new();
        model.preemption_bound = preemptions;
        model.max_branches = 20_000;
        model.check(move || {
            let shared = Arc::new(Shared::new(slots));
            let worker = |slot: usize| {
                let shared = Arc::clone(&shared);
                thread::spawn(move || shared.work(slot, commands))
            };
            let workers: Vec<_> = (0..slots).map(worker).collect();
            for command in 1..=commands as u32 {
                assert_eq!(shared.step(), vec![11 * command; slots]);
            }
            workers.into_iter().for_each(|worker| worker.join().unwrap());
        });
    }

    #[test]
    fn no_wake_up_is_lost_and_only_the_holder_touches_a_slot() {
        explore(1, 1, None);
        explore(1, 2, Some(3));
        explore(2, 1, Some(3));
    }
}
