//! Reproducible Latin hypercube samples.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

use b2b_base::random::{stream, uniform};

/// Returns `count` points of the unit cube, one in each of `count` equal intervals along every axis.
///
/// Axes are independent, and the same name and seed give the same points. The name selects a [`stream`].
pub(crate) fn latin_hypercube<const D: usize>(name: &str, seed: u64, count: usize) -> Vec<[f64; D]> {
    let mut points = vec![[0.0; D]; count];
    for axis in 0..D {
        let mut random = stream(name, seed, axis as u64);
        for (point, slice) in points.iter_mut().zip(shuffled(count, &mut random)) {
            point[axis] = (slice as f64 + uniform(&mut random)) / count as f64;
        }
    }
    points
}

/// Returns 0 to `count - 1` in random order.
pub(crate) fn permutation(name: &str, seed: u64, count: usize) -> Vec<usize> {
    shuffled(count, &mut stream(name, seed, PERMUTATION))
}

/// The stream of a permutation, distinct from the axes' streams.
const PERMUTATION: u64 = 1000;

/// Fisher-Yates shuffle, implemented here because `rand`'s may change between versions.
fn shuffled(count: usize, random: &mut ChaCha8Rng) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, below(last + 1, random));
    }
    order
}

/// A uniform integer below `end`, from the upper bits of a product.
fn below(end: usize, random: &mut ChaCha8Rng) -> usize {
    ((u128::from(random.next_u64()) * end as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interval_of_every_axis_holds_one_point() {
        let points = latin_hypercube::<3>("test", 1, 100);
        for axis in 0..3 {
            let mut slices: Vec<usize> = points.iter().map(|point| (point[axis] * 100.0) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..100).collect::<Vec<_>>());
        }
    }

    #[test]
    fn name_and_seed_determine_the_points() {
        let points = |name, seed| latin_hypercube::<2>(name, seed, 10);
        assert_eq!(points("a", 1), points("a", 1));
        assert_ne!(points("a", 1), points("a", 2));
        assert_ne!(points("a", 1), points("b", 1));
    }

    #[test]
    fn the_stream_is_reproducible() {
        assert_eq!(permutation("v1/OfficeSmall", 0, 8), [7, 1, 6, 0, 5, 4, 2, 3]);
    }
}
