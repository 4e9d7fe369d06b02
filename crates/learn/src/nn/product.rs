//! Products of matrices in single precision.

#![allow(unsafe_code, reason = "a matrix product with checked sizes")]

/// A matrix over a slice, with its strides.
#[derive(Clone, Copy, Debug)]
pub struct Matrix<'a> {
    values: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Returns the matrix with these values, row by row.
    ///
    /// # Panics
    /// When the number of values is not rows × columns.
    pub fn new(values: &'a [f32], rows: usize, columns: usize) -> Self {
        assert_eq!(values.len(), rows * columns, "values of a matrix");
        Self { values, rows, columns, row_stride: columns, column_stride: 1 }
    }

    /// Returns the transposed matrix.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self {
            values: self.values,
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
        }
    }
}

/// Writes `product` ← a b + `keep` × `product`, row by row. With a `keep` of 0 the previous values are not read.
///
/// # Panics
/// When the shapes do not fit.
pub fn multiply(a: Matrix<'_>, b: Matrix<'_>, keep: f32, product: &mut [f32]) {
    assert_eq!(a.columns, b.rows, "inner dimensions of a product");
    assert_eq!(product.len(), a.rows * b.columns, "values of a product");
    let stride = |stride: usize| isize::try_from(stride).expect("a stride is below the length of a slice");
    // SAFETY: `Matrix` has rows × columns values and its strides are (columns, 1) or the reverse of a transposed one,
    // so every element that sgemm reads is within the slice. `product` has exactly rows × columns elements with strides
    // (columns, 1), and as a mutable slice it aliases neither `a` nor `b`.
    unsafe {
        matrixmultiply::sgemm(
            a.rows,
            a.columns,
            b.columns,
            1.0,
            a.values.as_ptr(),
            stride(a.row_stride),
            stride(a.column_stride),
            b.values.as_ptr(),
            stride(b.row_stride),
            stride(b.column_stride),
            keep,
            product.as_mut_ptr(),
            stride(b.columns),
            1,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_match_the_definition() {
        let a = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let b = [1.0, 0.0, -1.0, 2.0, 0.5, 1.0];
        let mut product = [1.0; 4];
        multiply(Matrix::new(&a, 2, 3), Matrix::new(&b, 3, 2), 2.0, &mut product);
        assert_eq!(product, [0.5 + 2.0, 7.0 + 2.0, 2.0 + 2.0, 16.0 + 2.0]);
        // aᵀ bᵀ, of 3 × 2 and 2 × 3.
        let mut product = [f32::NAN; 9];
        multiply(Matrix::new(&a, 2, 3).transposed(), Matrix::new(&b, 3, 2).transposed(), 0.0, &mut product);
        assert_eq!(product, [1.0, 7.0, 4.5, 2.0, 8.0, 6.0, 3.0, 9.0, 7.5]);
    }
}
