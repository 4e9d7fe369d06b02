//! Conversions between NumPy arrays and slices.

use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::interpreter::error::Exception;

/// Returns the values of any one-dimensional array or sequence.
pub fn numbers(given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    // Copied rather than borrowed: rust-numpy registers every borrow in a global table.
    if let Ok(Ok(values)) = given.cast::<PyArray1<f32>>().map(|array| array.to_vec()) {
        return Ok(values.into_iter().map(f64::from).collect());
    }
    if let Ok(Ok(values)) = given.cast::<PyArray1<f64>>().map(|array| array.to_vec()) {
        return Ok(values);
    }
    given
        .extract()
        .or_else(|_| converted(given)?.extract())
        .map_err(|_: PyErr| wrong(given, "a one-dimensional array"))
}

/// Returns the values of any two-dimensional array, row by row, with its shape.
pub fn rows(given: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, [usize; 2])> {
    if let Ok(array) = given.cast::<PyArray2<f32>>() {
        let array = array.readonly();
        let view = array.as_array();
        return Ok((view.iter().map(|value| f64::from(*value)).collect(), [view.nrows(), view.ncols()]));
    }
    let given = converted(given)?;
    let array =
        given.cast::<PyArray2<f64>>().map_err(|_| wrong(&given, "a two-dimensional array"))?.readonly();
    let view = array.as_array();
    Ok((view.iter().copied().collect(), [view.nrows(), view.ncols()]))
}

/// Converts to an array of f64.
fn converted<'py>(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    given.py().import("numpy")?.call_method1("asarray", (given, "float64"))
}

fn wrong(given: &Bound<'_, PyAny>, expected: &str) -> PyErr {
    let given = given.repr().map_or_else(|_| "value".into(), |text| text.to_string());
    let given: String = given.chars().take(80).collect();
    Exception::Action.new_err(format!("{given} is not {expected} of numbers"))
}

/// Creates a one-dimensional array.
pub fn row<'py, T: Element>(py: Python<'py>, values: &[T]) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_slice(py, values)
}

/// Creates a one-dimensional array of f32.
pub fn single<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f32>> {
    let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
    PyArray1::from_slice(py, &values)
}

/// Creates a two-dimensional array.
pub fn table<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: [usize; 2],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}
