//! Stepping of several episodes at once.

use super::episode::Episode;
use super::region::LOOK;
use super::workers::Workers;
use b2b_env::{Error, Result};

/// Waits until at least `count` of the busy episodes have finished, and lists their indices in `ready`. All must belong
/// to the same [`Workers`]. [`Episode::last_step`] returns each outcome.
///
/// Together with [`Episode::send`], this steps several episodes asynchronously: ready ones receive their next actions
/// while the others continue.
///
/// # Errors
/// [`Error::Interrupted`]; the episodes continue.
pub fn recv(episodes: &mut [Episode], count: usize, ready: &mut Vec<usize>) -> Result<()> {
    ready.clear();
    ready.extend((0..episodes.len()).filter(|index| episodes[*index].is_busy()));
    let idle = episodes.len() - ready.len();
    wait(episodes, idle + count.min(ready.len()))?;
    ready.retain(|index| !episodes[*index].is_busy());
    Ok(())
}

/// Steps every episode once. `actions` has the concatenated actions of all episodes.
///
/// # Errors
/// [`Error::ActionLength`] and the errors of [`Episode::send`] before any action is sent; [`Error::Lost`] when an
/// episode is lost; [`Error::Interrupted`].
pub fn step_all(episodes: &mut [Episode], actions: &[f64]) -> Result<()> {
    let width = |episode: &Episode| episode.known_spaces().action.len();
    let expected = episodes.iter().map(width).sum();
    if actions.len() != expected {
        return Err(Error::ActionLength { given: actions.len(), expected });
    }
    let mut rest = actions;
    for episode in episodes.iter() {
        let (action, others) = rest.split_at(width(episode));
        episode.check(action)?;
        rest = others;
    }
    let mut rest = actions;
    for episode in episodes.iter_mut() {
        let (action, others) = rest.split_at(width(episode));
        episode.send(action)?;
        rest = others;
    }
    wait(episodes, episodes.len())?;
    episodes.iter().try_for_each(|episode| episode.last_step().map(|_| ()))
}

/// Waits until at least `count` of these episodes are idle.
pub(super) fn wait(episodes: &mut [Episode], count: usize) -> Result<()> {
    let Some(workers) = episodes.first().map(|episode| episode.workers().clone()) else { return Ok(()) };
    let count = count.min(episodes.len());
    loop {
        let done = workers.region().done();
        if rest(&workers, episodes, |episode| Some(episode), count, done)? >= count {
            return Ok(());
        }
    }
}

/// Sleeps until `count` of these episodes are idle or another event has happened since `done`, which must be read
/// before checking any of them. Returns the number of idle episodes; items without an episode count as idle.
pub(super) fn rest<T>(
    workers: &Workers,
    items: &mut [T],
    episode: fn(&mut T) -> Option<&mut Episode>,
    count: usize,
    done: u32,
) -> Result<usize> {
    let settle = |items: &mut [T]| {
        let settled = items.iter_mut().map(|item| episode(item).is_none_or(Episode::settle));
        settled.map(usize::from).sum::<usize>()
    };
    let ready = settle(items);
    if ready >= count {
        return Ok(ready);
    }
    let starting = items.iter_mut().filter_map(episode).any(|episode| episode.is_starting());
    if starting {
        workers.lock().advance_all();
    }
    // A template that becomes ready or has finished its copies is a separate event; steps are awaited together.
    workers.region().sleep(done, if starting { 1 } else { (count - ready) as u32 }, LOOK);
    let look = workers.lock().check_is_due();
    if look {
        workers.check_interrupt()?;
        workers.lock().advance_all();
        items.iter_mut().filter_map(episode).for_each(Episode::check_worker);
    }
    Ok(settle(items))
}
