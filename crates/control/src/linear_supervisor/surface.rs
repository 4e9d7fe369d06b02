//! Response surfaces: how a day's cost and discomfort depend on the weights of a rule.

/// Regularization, as a share of the mean square of each term over the samples.
const RIDGE: f64 = 0.02;
/// Sweeps of the descent by coordinates.
const SWEEPS: usize = 60;

/// A quadratic function without a constant: 0 where all coordinates are. Products count within groups of coordinates
/// only.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    terms: Vec<(usize, Option<usize>)>,
    coefficients: Vec<f64>,
}

impl Surface {
    /// Fits the surface to points, their values and the weights of these by a ridge regression. Coordinates form groups
    /// of `group`.
    pub(super) fn fit(points: &[&[f64]], values: &[[f64; 2]], group: usize) -> Self {
        let width = points.first().map_or(0, |point| point.len());
        let mut terms: Vec<(usize, Option<usize>)> = (0..width).map(|index| (index, None)).collect();
        for first in 0..width {
            let end = (first / group + 1) * group;
            terms.extend((first..end.min(width)).map(|second| (first, Some(second))));
        }
        let count = terms.len();
        let (mut matrix, mut right) = (vec![0.0; count * count], vec![0.0; count]);
        for (point, [value, weight]) in points.iter().zip(values) {
            let row: Vec<f64> = terms.iter().map(|term| value_of(*term, point)).collect();
            for (index, own) in row.iter().map(|own| own * weight).enumerate() {
                right[index] += own * value;
                let entries = &mut matrix[index * count..(index + 1) * count];
                entries.iter_mut().zip(&row).for_each(|(entry, other)| *entry += own * other);
            }
        }
        for index in 0..count {
            let diagonal = &mut matrix[index * count + index];
            *diagonal = *diagonal * (1.0 + RIDGE) + f64::MIN_POSITIVE.sqrt();
        }
        crate::search::least_squares::solve(&mut matrix, &mut right);
        Self { terms, coefficients: right }
    }

    /// Returns the value at a point.
    pub(super) fn at(&self, point: &[f64]) -> f64 {
        self.terms.iter().zip(&self.coefficients).map(|(term, own)| own * value_of(*term, point)).sum()
    }
}

fn value_of((first, second): (usize, Option<usize>), point: &[f64]) -> f64 {
    point[first] * second.map_or(1.0, |second| point[second])
}

/// Returns a point with the lowest value of a function within bounds, starting from a point in them, by descent along
/// one coordinate at a time. The function is quadratic in every coordinate on either side of the first point.
pub(super) fn lowest(start: &[f64], bounds: &[[f64; 2]], value: &dyn Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut point = start.to_vec();
    for _ in 0..SWEEPS {
        for (index, &[low, high]) in bounds.iter().enumerate() {
            let mut with = |coordinate: f64| {
                point[index] = coordinate;
                value(&point)
            };
            let sides = [[low, start[index]], [start[index], high]].map(|side| lowest_along(side, &mut with));
            point[index] = if sides[0].1 <= sides[1].1 { sides[0].0 } else { sides[1].0 };
        }
    }
    point
}

/// Returns where a quadratic function of one variable is lowest within bounds, and its value.
fn lowest_along([low, high]: [f64; 2], value: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    let (middle, half) = (f64::midpoint(low, high), (high - low) / 2.0);
    let [at_low, at_middle, at_high] = [low, middle, high].map(&mut *value);
    let curvature = at_low + at_high - 2.0 * at_middle;
    let end = if at_low < at_high { (low, at_low) } else { (high, at_high) };
    if curvature <= 0.0 {
        return end;
    }
    let vertex = (middle + half * (at_low - at_high) / (2.0 * curvature)).clamp(low, high);
    let at_vertex = value(vertex);
    if at_vertex < end.1 { (vertex, at_vertex) } else { end }
}

#[cfg(test)]
mod tests {
    use b2b_base::random::{standard_normal, stream};

    use super::*;

    #[test]
    fn a_quadratic_surface_is_found_from_noisy_samples_and_so_is_its_lowest_point() {
        let truth =
            |x: &[f64]| -0.3 * x[0] + 0.4 * x[0] * x[0] + 0.2 * x[0] * x[1] + 0.1 * x[2] + 0.2 * x[3] * x[3];
        let mut random = stream("surface", 0, 0);
        let points: Vec<Vec<f64>> =
            (0..400).map(|_| (0..4).map(|_| 0.4 * standard_normal(&mut random)).collect()).collect();
        let values: Vec<[f64; 2]> =
            points.iter().map(|point| [truth(point) + 0.02 * standard_normal(&mut random), 0.5]).collect();
        let points: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
        let surface = Surface::fit(&points, &values, 2);
        for point in [[0.5, 0.0, 0.0, 0.0], [0.3, -0.4, 0.2, 0.5], [0.0; 4]] {
            assert!((surface.at(&point) - truth(&point)).abs() < 0.02, "{point:?}");
        }
        let found = lowest(&[0.0; 4], &[[-0.5, 0.5]; 4], &|point| surface.at(point));
        let expected = [0.5, -0.5, -0.5, 0.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.1, "{found} {expected}");
        }
    }
}
