//! Ridge regression of hourly values whose errors are proportional to their usual size, by a factor that differs by the
//! hour of the day, and are correlated from hour to hour.

use crate::search::least_squares::{dot, solve};

/// Rounds in which errors are estimated from residuals.
const ROUNDS: usize = 6;
/// Bounds of the correlation of the errors of consecutive rows.
const LASTING: [f64; 2] = [-0.3, 0.9];
/// Addition to the standard deviation of an error, relative to the usual size.
const LEAST_DEVIATION: f64 = 0.02;
/// Smallest variance of whitened errors: a few rows are explained exactly, but not known exactly.
const LEAST_VARIANCE: f64 = 0.01;
/// Smallest number of degrees of freedom.
const LEAST_FREEDOM: f64 = 10.0;

/// Rows to explain.
pub(super) struct Rows {
    /// Values of the regressors, one row per hour.
    pub(super) inputs: Vec<Vec<f64>>,
    /// Hour of the day of each row.
    pub(super) hours: Vec<usize>,
    /// Usual size of each value, to which its error is proportional.
    pub(super) sizes: Vec<f64>,
    /// Regularization of each coefficient: how much its distance from its mean costs.
    pub(super) ridge: Vec<f64>,
    /// Mean of each coefficient before its estimate.
    pub(super) means: Vec<f64>,
}

/// Coefficients with their uncertainty.
pub(super) struct Estimate {
    pub(super) coefficients: Vec<f64>,
    /// Covariances of the last coefficients, row by row.
    pub(super) covariance: Vec<Vec<f64>>,
}

/// Model of the errors.
struct Errors {
    /// Standard deviation relative to the usual size, by hour of the day.
    deviation: [f64; 24],
    /// Correlation between consecutive rows.
    lasting: f64,
}

impl Rows {
    /// Explains values; returns the covariances of the last `uncertain` coefficients.
    pub(super) fn explain(&self, values: &[f64], uncertain: usize) -> Estimate {
        let mut errors = Errors { deviation: [1.0; 24], lasting: 0.0 };
        let width = self.ridge.len();
        let freedom = (values.len() as f64 - width as f64).max(LEAST_FREEDOM);
        let mut coefficients = self.means.clone();
        let mut matrix = Vec::new();
        for round in 0..ROUNDS {
            let (inputs, whitened_values) = self.whiten(values, &errors);
            let rows = inputs.iter().zip(&whitened_values);
            let squares: f64 = rows.map(|(row, value)| (value - dot(row, &coefficients)).powi(2)).sum();
            let variance = if round == 0 { 1.0 } else { (squares / freedom).max(LEAST_VARIANCE) };
            (matrix, coefficients) = self.normal_equations(&inputs, &whitened_values, variance);
            solve(&mut matrix.clone(), &mut coefficients);
            errors = self.errors(values, &coefficients);
        }
        let column = |number: usize| {
            let mut column = vec![0.0; width];
            column[number] = 1.0;
            solve(&mut matrix.clone(), &mut column);
            column.split_off(width - uncertain)
        };
        let covariance = (width - uncertain..width).map(column).collect();
        Estimate { coefficients, covariance }
    }

    /// Returns the fitted values, clipped at 0.
    pub(super) fn fitted(&self, values: &[f64]) -> Vec<f64> {
        let Estimate { coefficients, .. } = self.explain(values, 0);
        self.inputs.iter().map(|row| dot(row, &coefficients).max(0.0)).collect()
    }

    /// Returns rows and values transformed so that their errors have equal variance and are independent.
    fn whiten(&self, values: &[f64], errors: &Errors) -> (Vec<Vec<f64>>, Vec<f64>) {
        let scaled = |row: usize| {
            let scale = 1.0 / (self.sizes[row] * errors.deviation[self.hours[row]]);
            let inputs: Vec<f64> = self.inputs[row].iter().map(|input| input * scale).collect();
            (inputs, values[row] * scale)
        };
        let mut last: Option<(Vec<f64>, f64)> = None;
        let mut whitened = (Vec::with_capacity(values.len()), Vec::with_capacity(values.len()));
        for row in 0..values.len() {
            let (inputs, value) = scaled(row);
            let (rest, rest_value) = match &last {
                Some((before, value_before)) => {
                    let rest = inputs.iter().zip(before).map(|(own, before)| own - errors.lasting * before);
                    (rest.collect(), value - errors.lasting * value_before)
                }
                None => (inputs.clone(), value),
            };
            whitened.0.push(rest);
            whitened.1.push(rest_value);
            last = Some((inputs, value));
        }
        whitened
    }

    /// Returns matrix and right side of the equations for errors of this variance.
    fn normal_equations(&self, inputs: &[Vec<f64>], values: &[f64], variance: f64) -> (Vec<f64>, Vec<f64>) {
        let width = self.ridge.len();
        let mut matrix = vec![0.0; width * width];
        let mut right = vec![0.0; width];
        for (row, value) in inputs.iter().zip(values) {
            for (index, own) in row.iter().enumerate().filter(|(_, own)| **own != 0.0) {
                right[index] += own * value;
                let entries = &mut matrix[index * width..(index + 1) * width];
                entries.iter_mut().zip(row).for_each(|(entry, other)| *entry += own * other);
            }
        }
        matrix.iter_mut().chain(&mut right).for_each(|entry| *entry /= variance);
        for (index, (ridge, mean)) in self.ridge.iter().zip(&self.means).enumerate() {
            matrix[index * width + index] += ridge;
            right[index] += ridge * mean;
        }
        (matrix, right)
    }

    /// Estimates the errors from the residuals; the deviations are smoothed over neighboring hours.
    fn errors(&self, values: &[f64], coefficients: &[f64]) -> Errors {
        let rows = self.inputs.iter().zip(values).zip(&self.sizes);
        let residuals: Vec<f64> =
            rows.map(|((row, value), size)| (value - dot(row, coefficients)) / size).collect();
        let (mut squares, mut counts) = ([0.0; 24], [0.0; 24]);
        for (residual, &hour) in residuals.iter().zip(&self.hours) {
            squares[hour] += residual * residual;
            counts[hour] += 1.0;
        }
        let mean = |hour: usize| squares[hour % 24] / f64::max(counts[hour % 24], 1.0);
        let deviation = std::array::from_fn(|hour| {
            let smooth = 0.5 * mean(hour) + 0.25 * (mean(hour + 23) + mean(hour + 1));
            smooth.sqrt() + LEAST_DEVIATION
        });
        let scaled: Vec<f64> =
            residuals.iter().zip(&self.hours).map(|(residual, &hour)| residual / deviation[hour]).collect();
        let square = dot(&scaled, &scaled);
        let lasting = if square > 0.0 { dot(&scaled, &scaled[1..]) / square } else { 0.0 };
        Errors { deviation, lasting: lasting.clamp(LASTING[0], LASTING[1]) }
    }
}

#[cfg(test)]
mod tests {
    use b2b_base::random::{standard_normal, stream};

    use super::*;

    #[test]
    fn coefficients_are_found_within_their_uncertainty_under_errors_that_last() {
        let mut random = stream("regression", 0, 0);
        let mut error = 0.0;
        let mut values = Vec::new();
        let rows: Vec<Vec<f64>> = (0..336).map(|_| vec![1.0, standard_normal(&mut random)]).collect();
        for (hour, row) in rows.iter().enumerate() {
            let size = if hour % 24 < 8 { 1.0 } else { 0.1 };
            error = 0.7 * error + standard_normal(&mut random);
            values.push(1.0 - 0.05 * row[1] + 0.3 * size * error);
        }
        let rows = Rows {
            inputs: rows,
            hours: (0..336).map(|hour| hour % 24).collect(),
            sizes: vec![1.0; 336],
            ridge: vec![1e-3; 2],
            means: vec![0.0; 2],
        };
        let found = rows.explain(&values, 1);
        let deviation = found.covariance[0][0].sqrt();
        assert!(deviation < 0.006, "{deviation}: hours with small errors count most");
        assert!((found.coefficients[1] + 0.05).abs() < 2.5 * deviation, "{:?}", found.coefficients);
    }
}
