//! Minibatches on several threads, with the same bits on any number of them.
//!
//! [`chunk`] splits a minibatch into chunks of whole sequences of rows, whatever the number of threads. Each chunk has
//! its own buffers and gradients, and gradients are summed in the order of the chunks.

use std::ops::Range;

/// Largest number of chunks of a minibatch.
const CHUNKS: usize = 4;
/// Minimum number of rows of a chunk, so that matrix products are worth their overhead.
const ROWS: usize = 64;
/// Minimum number of sequences of a chunk: a step of a recurrent layer costs nearly the same for one sequence as for
/// several.
const SEQUENCES: usize = 4;
/// Number of parameters × rows below which starting a thread costs more than it saves.
const WORK: usize = 1 << 20;

/// Returns the number of chunks of rows in sequences of this length: one per 64 rows and per four sequences, and at
/// most four.
pub fn chunk_count(rows: usize, length: usize) -> usize {
    (rows / ROWS).clamp(1, CHUNKS).min((rows / length / SEQUENCES).max(1))
}

/// Returns the rows of a chunk. Sequences of one row are split anywhere.
pub fn chunk(rows: usize, length: usize, index: usize) -> Range<usize> {
    let (count, sequences) = (chunk_count(rows, length), rows / length);
    index * sequences / count * length..(index + 1) * sequences / count * length
}

/// Returns the number of threads for a minibatch: one if it is small.
pub fn threads_for(rows: usize, parameters: usize, threads: usize) -> usize {
    if rows * parameters < WORK { 1 } else { threads }
}

/// Calls `work` with every item and its index, on this many threads.
pub fn for_each<T: Send>(items: &mut [T], threads: usize, work: impl Fn(usize, &mut T) + Sync) {
    let share = items.len().div_ceil(threads.max(1)).max(1);
    let run = |first: usize, items: &mut [T]| {
        items.iter_mut().enumerate().for_each(|(index, item)| work(first + index, item));
    };
    let (own, others) = items.split_at_mut(share.min(items.len()));
    if others.is_empty() {
        return run(0, own);
    }
    std::thread::scope(|scope| {
        for (index, items) in others.chunks_mut(share).enumerate() {
            scope.spawn(move || run((index + 1) * share, items));
        }
        run(0, own);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_all_rows() {
        for (rows, length, count) in
            [(1, 1, 1), (64, 1, 1), (128, 1, 2), (336, 1, 4), (1000, 1, 4), (480, 96, 1), (768, 96, 2)]
        {
            assert_eq!(chunk_count(rows, length), count);
            let chunks: Vec<_> = (0..count).map(|index| chunk(rows, length, index)).collect();
            assert!(chunks.iter().all(|chunk| !chunk.is_empty() && chunk.len().is_multiple_of(length)));
            assert_eq!(chunks.into_iter().flatten().collect::<Vec<_>>(), (0..rows).collect::<Vec<_>>());
        }
    }

    #[test]
    fn every_item_is_worked_on_once() {
        for threads in 1..6 {
            let mut items = vec![0; 5];
            for_each(&mut items, threads, |index, item| *item += index + 1);
            assert_eq!(items, [1, 2, 3, 4, 5]);
        }
    }
}
