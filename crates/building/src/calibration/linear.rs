//! Small systems of linear equations.

/// Solves `a x = b` by elimination with partial pivoting; `None` if `a` is singular.
pub(super) fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|i, j| a[*i][column].abs().total_cmp(&a[*j][column].abs()))?;
        if a[pivot][column].abs() < 1e-14 {
            return None;
        }
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (above, below) = a.split_at_mut(column + 1);
        let pivot = &above[column];
        for (offset, row) in below.iter_mut().enumerate() {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).skip(column).for_each(|(value, pivot)| *value -= factor * pivot);
            b[column + 1 + offset] -= factor * b[column];
        }
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| a[row][k] * b[k]).sum();
        b[row] = (b[row] - known) / a[row][row];
    }
    Some(b)
}

/// Returns the diagonal of the inverse of a matrix; infinite if it is singular.
pub(super) fn inverse_diagonal(a: &[Vec<f64>]) -> Vec<f64> {
    let unit = |i: usize| (0..a.len()).map(|j| f64::from(u8::from(i == j))).collect();
    (0..a.len()).map(|i| solve(a.to_vec(), unit(i)).map_or(f64::INFINITY, |column| column[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved_and_a_singular_one_is_not() {
        let a = vec![vec![0.0, 2.0], vec![4.0, 2.0]];
        assert_eq!(solve(a.clone(), vec![2.0, 6.0]), Some(vec![1.0, 1.0]));
        assert_eq!(inverse_diagonal(&a), [-0.25, 0.0]);
        let singular = vec![vec![1.0, 2.0], vec![2.0, 4.0]];
        assert_eq!(solve(singular.clone(), vec![1.0, 1.0]), None);
        assert_eq!(inverse_diagonal(&singular), [f64::INFINITY; 2]);
    }
}
