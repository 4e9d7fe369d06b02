//! Systems of linear equations.

/// Solves a positive definite system in place, by Cholesky's factorization.
pub(crate) fn solve(matrix: &mut [f64], right: &mut [f64]) {
    let width = right.len();
    for column in 0..width {
        for row in column..width {
            let known = dot(&matrix[row * width..][..column], &matrix[column * width..][..column]);
            let rest = matrix[row * width + column] - known;
            matrix[row * width + column] =
                if row == column { rest.sqrt() } else { rest / matrix[column * width + column] };
        }
    }
    for row in 0..width {
        let known = dot(&matrix[row * width..][..row], &right[..row]);
        right[row] = (right[row] - known) / matrix[row * width + row];
    }
    for row in (0..width).rev() {
        let known: f64 = (row + 1..width).map(|below| matrix[below * width + row] * right[below]).sum();
        right[row] = (right[row] - known) / matrix[row * width + row];
    }
}

/// Returns the product of two vectors.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_positive_definite_system_is_solved() {
        let mut right = [10.0, 11.0];
        solve(&mut [4.0, 2.0, 2.0, 3.0], &mut right);
        assert!((right[0] - 1.0).abs() < 1e-12 && (right[1] - 3.0).abs() < 1e-12, "{right:?}");
    }
}
