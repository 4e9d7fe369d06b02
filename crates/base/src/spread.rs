//! Samples that are evenly spread over a list.

/// Returns at most `count` of `all`, evenly spread.
pub fn spread<T: Clone>(all: &[T], count: usize) -> Vec<T> {
    let count = count.min(all.len());
    (0..count).map(|index| all[index * all.len() / count].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_begins_with_the_first_and_has_no_more_than_all() {
        assert_eq!(spread(&[0, 1, 2, 3, 4, 5], 3), [0, 2, 4]);
        assert_eq!(spread(&[7, 8], 5), [7, 8]);
        assert_eq!(spread(&[7, 8], 0), [0; 0]);
    }
}
