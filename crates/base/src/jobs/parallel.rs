//! Work on lists of items by several threads.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Tells work that runs in several threads to stop, because a part of it has failed.
#[derive(Debug, Default)]
pub struct Halt(AtomicBool);

impl Halt {
    /// Returns whether a part has failed.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Works on the items, at most `threads` at a time, beginning with the first. Returns the results in the order of the
/// items. After an error, no more work begins.
///
/// # Errors
/// The first error in time.
pub fn map<T: Sync, R: Send, E: Send>(
    threads: usize,
    items: &[T],
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    map_until(&Halt::default(), threads, items, work)
}

/// Like [`map`], and sets `halt` after an error, so that running work can end early.
///
/// # Errors
/// The first error in time.
pub fn map_until<T: Sync, R: Send, E: Send>(
    halt: &Halt,
    threads: usize,
    items: &[T],
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let (next, failure) = (AtomicUsize::new(0), Mutex::new(None));
    let thread = || {
        let mut done = Vec::new();
        while !halt.is_set() {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(number) else { break };
            match work(item) {
                Ok(result) => done.push((number, result)),
                Err(error) => {
                    // Before `halt`, so that the errors of work that ends early come later.
                    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    halt.0.store(true, Ordering::Relaxed);
                }
            }
        }
        done
    };
    let mut done: Vec<(usize, R)> = std::thread::scope(|scope| {
        let threads: Vec<_> =
            (0..threads.clamp(1, items.len().max(1))).map(|_| scope.spawn(thread)).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    done.sort_by_key(|(number, _)| *number);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_items() {
        let items: Vec<usize> = (0..100).collect();
        for threads in [0, 1, 3, 200] {
            let doubled = map(threads, &items, |item| Ok::<_, String>(2 * item)).unwrap();
            assert!(doubled.iter().enumerate().all(|(item, double)| *double == 2 * item), "{threads}");
        }
        assert_eq!(map(4, &[], |item: &usize| Ok::<_, String>(*item)), Ok(vec![]));
    }

    #[test]
    fn an_error_stops_the_work_and_is_not_replaced_by_the_errors_of_halted_work() {
        let (halt, begun) = (Halt::default(), AtomicUsize::new(0));
        let items: Vec<usize> = (0..1000).collect();
        let ended = map_until(&halt, 2, &items, |item| {
            begun.fetch_add(1, Ordering::Relaxed);
            if *item == 0 {
                return Err("broken");
            }
            while !halt.is_set() {
                std::thread::yield_now();
            }
            Err("halted")
        });
        assert_eq!((ended, begun.into_inner() <= 2), (Err::<Vec<()>, _>("broken"), true));
    }

    #[test]
    #[should_panic(expected = "of the work")]
    fn a_panic_is_passed_on() {
        let _ = map(2, &[1, 2], |_| -> Result<(), String> { panic!("of the work") });
    }
}
