//! Function calls with a time limit, because a network in a third-party file may run forever.

use std::io::Result;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// Time limit of a call. Policy networks need a thousandth of it. Shorter than the time in which a command must stop.
pub(super) const LIMIT: Duration = Duration::from_secs(5);
/// Maximum time counted per wait, so that time in which the process is stopped does not count.
const TICK: Duration = Duration::from_millis(100);

/// Stack of a thread, bytes. The ONNX library recurses along every chain of nodes.
const STACK: usize = 256 << 20;

/// A function in its own thread. A call that exceeds [`LIMIT`] is abandoned: its thread cannot be killed and stays
/// until the process ends.
pub(super) struct Limited<I, O> {
    inputs: SyncSender<I>,
    outputs: Receiver<O>,
    given_up: bool,
}

impl<I: Send + 'static, O: Send + 'static> Limited<I, O> {
    /// Starts the thread, which ends when this is dropped.
    ///
    /// # Errors
    /// Errors of the operating system, which may have no memory for the stack.
    pub(super) fn new(mut function: impl FnMut(I) -> O + Send + 'static) -> Result<Self> {
        let (inputs, to_do) = sync_channel::<I>(1);
        let (done, outputs) = sync_channel(1);
        std::thread::Builder::new().stack_size(STACK).spawn(move || {
            // Runs until either end of the channels is gone.
            to_do.into_iter().try_for_each(|input| done.send(function(input)))
        })?;
        Ok(Self { inputs, outputs, given_up: false })
    }

    /// Calls the function; `None` if it exceeds the time limit, now or in an earlier call.
    pub(super) fn call(&mut self, input: I) -> Option<O> {
        if self.given_up || self.inputs.send(input).is_err() {
            return None;
        }
        let mut left = LIMIT;
        while !left.is_zero() {
            match self.outputs.recv_timeout(TICK) {
                Ok(output) => return Some(output),
                Err(RecvTimeoutError::Timeout) => left = left.saturating_sub(TICK),
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        self.given_up = true;
        None
    }
}

/// Calls a function once in its own thread; `None` if it exceeds the time limit.
///
/// # Errors
/// Same as [`Limited::new`].
pub(super) fn once<O: Send + 'static>(function: impl FnOnce() -> O + Send + 'static) -> Result<Option<O>> {
    let mut function = Some(function);
    let call = move |()| function.take().map(|function| function());
    Ok(Limited::new(call)?.call(()).flatten())
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;

    #[test]
    fn a_call_that_never_ends_is_given_up_and_so_are_later_ones() {
        let mut endless = Limited::new(|input: u32| {
            if input == 0 {
                loop {
                    std::thread::park();
                }
            }
            input + 1
        })
        .unwrap();
        assert_eq!(endless.call(1), Some(2));
        let begun = Instant::now();
        assert_eq!(endless.call(0), None);
        assert!((LIMIT..2 * LIMIT).contains(&begun.elapsed()), "{:?}", begun.elapsed());
        assert_eq!(endless.call(1), None);
        assert_eq!(once(|| 7).unwrap(), Some(7));
    }
}
