//! Least squares with bounds, by the method of Levenberg and Marquardt.
//!
//! The unknowns are logarithms of multipliers. An iteration evaluates the derivatives, by differences, in one batch and
//! several step lengths in another, so that the simulations of a batch can run in parallel. The result does not depend
//! on the number of parallel simulations.

use super::linear::{inverse_diagonal, solve};

/// Difference of a logarithm for derivatives: 5 %.
const DIFFERENCE: f64 = 0.05;
/// Longest step of a logarithm: a factor of 2.
const MAX_STEP: f64 = 0.7;
/// First damping, relative to the diagonal.
const DAMPING: f64 = 1e-3;
/// Dampings that a batch tries, relative to the current one.
const TRIALS: [f64; 2] = [1.0, 30.0];
/// Increase of the damping after a batch without improvement.
const INCREASE: f64 = 1000.0;
/// Batches of steps without improvement after which the fit ends.
const MAX_FAILURES: usize = 2;
/// Decrease of the sum of squares, relative to it, below which the fit ends.
const MIN_DECREASE: f64 = 1e-3;
/// Mean square of the residuals below which the fit ends: the square of 0.01 % of the mean energy.
const EXACT: f64 = 1e-8;
/// Variance inflation above which an unknown is nearly collinear: the others explain 96 % of its effect.
const MAX_INFLATION: f64 = 25.0;
/// Root mean square effect of a factor of e, relative to the mean energy, below which an unknown counts as having no
/// effect.
const MIN_EFFECT: f64 = 1e-3;

/// The limits of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Lowest and highest value of each unknown.
    pub bounds: Vec<[f64; 2]>,
    /// Maximum number of iterations.
    pub max_iterations: usize,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The unknowns with the lowest sum of squares.
    pub point: Vec<f64>,
    /// Number of evaluations.
    pub evaluations: usize,
    /// Number of iterations.
    pub iterations: usize,
    /// Whether the limit of iterations ended the fit, which another might have improved.
    pub is_cut: bool,
    /// The unknowns at a bound.
    pub at_bound: Vec<usize>,
    /// The unknowns whose effects are nearly combinations of the others'.
    pub collinear: Vec<usize>,
    /// The unknowns that have almost no effect.
    pub without_effect: Vec<usize>,
}

/// A point with its residuals.
struct Best {
    point: Vec<f64>,
    residuals: Vec<f64>,
    cost: f64,
}

/// Minimizes the sum of squared residuals, starting at the origin. `evaluate` returns the residuals of each point of a
/// batch.
///
/// # Errors
/// Errors from `evaluate`.
pub fn fit<E>(
    options: &Options,
    evaluate: impl FnMut(&[Vec<f64>]) -> Result<Vec<Vec<f64>>, E>,
) -> Result<Fit, E> {
    let mut search = Search::start(options, evaluate)?;
    let (mut iterations, mut is_cut) = (1, false);
    while !search.best.is_exact() && search.improve()? {
        if iterations >= options.max_iterations {
            is_cut = true;
            break;
        }
        search.differentiate()?;
        iterations += 1;
    }
    let Search { best: Best { point, .. }, jacobian, evaluations, .. } = search;
    let is_at_bound = |j: &usize| options.bounds[*j].contains(&point[*j]);
    let at_bound = (0..point.len()).filter(is_at_bound).collect();
    let (collinear, without_effect) = weak(&jacobian);
    Ok(Fit { at_bound, collinear, without_effect, evaluations, iterations, is_cut, point })
}

/// A fit in progress.
struct Search<'a, F> {
    options: &'a Options,
    evaluate: F,
    best: Best,
    /// Derivatives of the residuals by unknown.
    jacobian: Vec<Vec<f64>>,
    damping: f64,
    evaluations: usize,
}

impl<'a, F, E> Search<'a, F>
where
    F: FnMut(&[Vec<f64>]) -> Result<Vec<Vec<f64>>, E>,
{
    /// Evaluates the origin and its neighbors.
    fn start(options: &'a Options, mut evaluate: F) -> Result<Self, E> {
        let origin = options.clamp(vec![0.0; options.bounds.len()]);
        let mut batch = options.all_beside(&origin);
        batch.push(origin.clone());
        let mut residuals = evaluate(&batch)?;
        let best = Best::new(origin, residuals.pop().unwrap_or_default());
        let jacobian = derivatives(&best, &batch, &residuals);
        Ok(Self { options, evaluate, best, jacobian, damping: DAMPING, evaluations: batch.len() })
    }

    /// Computes the derivatives at the best point.
    fn differentiate(&mut self) -> Result<(), E> {
        let batch = self.options.all_beside(&self.best.point);
        let residuals = (self.evaluate)(&batch)?;
        self.evaluations += batch.len();
        self.jacobian = derivatives(&self.best, &batch, &residuals);
        Ok(())
    }

    /// Moves to a better point, and returns whether another iteration can improve it noticeably.
    fn improve(&mut self) -> Result<bool, E> {
        let before = self.best.cost;
        for _ in 0..MAX_FAILURES {
            let dampings = TRIALS.map(|factor| self.damping * factor);
            let steps = dampings.map(|damping| self.options.step(&self.best, &self.jacobian, damping));
            let residuals = (self.evaluate)(&steps)?;
            self.evaluations += steps.len();
            let tried =
                steps.into_iter().zip(residuals).map(|(point, residuals)| Best::new(point, residuals));
            let lowest = tried.zip(dampings).min_by(|a, b| a.0.cost.total_cmp(&b.0.cost));
            match lowest.filter(|(found, _)| found.cost < before) {
                Some((found, damping)) => {
                    self.best = found;
                    self.damping = damping / 10.0;
                    break;
                }
                None => self.damping *= INCREASE,
            }
        }
        Ok(before - self.best.cost > MIN_DECREASE * before)
    }
}

/// Returns the derivatives of the residuals by unknown, from the residuals at points next to the best.
fn derivatives(best: &Best, batch: &[Vec<f64>], residuals: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let derivative = |(j, moved): (usize, &Vec<f64>)| {
        let difference = batch[j][j] - best.point[j];
        moved.iter().zip(&best.residuals).map(|(moved, here)| (moved - here) / difference).collect()
    };
    residuals.iter().enumerate().map(derivative).collect()
}

impl Best {
    fn new(point: Vec<f64>, residuals: Vec<f64>) -> Self {
        let cost = residuals.iter().map(|r| r * r).sum();
        Self { point, residuals, cost }
    }

    fn is_exact(&self) -> bool {
        self.cost <= EXACT * self.residuals.len() as f64
    }
}

impl Options {
    fn clamp(&self, point: Vec<f64>) -> Vec<f64> {
        point.into_iter().zip(&self.bounds).map(|(x, [low, high])| x.clamp(*low, *high)).collect()
    }

    /// Returns the neighbors of a point along each unknown.
    fn all_beside(&self, at: &[f64]) -> Vec<Vec<f64>> {
        (0..at.len()).map(|unknown| self.beside(at, unknown)).collect()
    }

    /// Returns the neighbor of a point along an unknown, within the bounds.
    fn beside(&self, at: &[f64], unknown: usize) -> Vec<f64> {
        let mut point = at.to_vec();
        let up = at[unknown] + DIFFERENCE;
        point[unknown] = if up > self.bounds[unknown][1] { at[unknown] - DIFFERENCE } else { up };
        point
    }

    /// Returns the point after a damped step. Unknowns at a bound that the step would leave stay there.
    fn step(&self, from: &Best, jacobian: &[Vec<f64>], damping: f64) -> Vec<f64> {
        let gradient: Vec<f64> = jacobian.iter().map(|column| dot(column, &from.residuals)).collect();
        let is_free = |j: &usize| {
            let [low, high] = self.bounds[*j];
            let leaves = (from.point[*j] <= low && gradient[*j] > 0.0)
                || (from.point[*j] >= high && gradient[*j] < 0.0);
            !leaves && gradient[*j] != 0.0
        };
        let free: Vec<usize> = (0..jacobian.len()).filter(is_free).collect();
        let mut matrix = vec![vec![0.0; free.len()]; free.len()];
        for (row, i) in free.iter().enumerate() {
            for (column, j) in free.iter().enumerate() {
                matrix[row][column] = dot(&jacobian[*i], &jacobian[*j]);
            }
            matrix[row][row] *= 1.0 + damping;
        }
        let downhill = free.iter().map(|j| -gradient[*j]).collect();
        let mut point = from.point.clone();
        for (j, change) in free.iter().zip(solve(matrix, downhill).unwrap_or_default()) {
            point[*j] += change.clamp(-MAX_STEP, MAX_STEP);
        }
        self.clamp(point)
    }
}

/// Returns the unknowns that are nearly collinear, and those without effect.
fn weak(jacobian: &[Vec<f64>]) -> (Vec<usize>, Vec<usize>) {
    let effect = |column: &Vec<f64>| (dot(column, column) / column.len().max(1) as f64).sqrt();
    let (active, without_effect): (Vec<_>, Vec<_>) =
        (0..jacobian.len()).partition(|j| effect(&jacobian[*j]) >= MIN_EFFECT);
    let cosine = |i: usize, j: usize| {
        let lengths = dot(&jacobian[i], &jacobian[i]) * dot(&jacobian[j], &jacobian[j]);
        dot(&jacobian[i], &jacobian[j]) / lengths.sqrt()
    };
    let cosines: Vec<Vec<f64>> =
        active.iter().map(|i| active.iter().map(|j| cosine(*i, *j)).collect()).collect();
    let inflations = inverse_diagonal(&cosines);
    let inflated = active.into_iter().zip(inflations).filter(|(_, inflation)| *inflation > MAX_INFLATION);
    (inflated.map(|(j, _)| j).collect(), without_effect)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// Fits residuals of two or three unknowns within ±ln 5.
    fn fitted(unknowns: usize, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Fit {
        let bound = 5.0_f64.ln();
        let options = Options { bounds: vec![[-bound, bound]; unknowns], max_iterations: 12 };
        let evaluate = |batch: &[Vec<f64>]| Ok::<_, Infallible>(batch.iter().map(|x| residuals(x)).collect());
        fit(&options, evaluate).unwrap()
    }

    /// Monthly energy of a building: a base load and a heating load, each with its multiplier.
    fn energy(x: &[f64], month: usize) -> f64 {
        let cold = [1.0, 0.8, 0.6, 0.3, 0.1, 0.0, 0.0, 0.0, 0.1, 0.4, 0.7, 0.9][month];
        0.6 * x[0].exp() + (cold * x[1].exp() - 0.2 * x[0].exp()).max(0.0)
    }

    #[test]
    fn multipliers_are_recovered() {
        let truth = [0.7_f64.ln(), 2.5_f64.ln()];
        let fit = fitted(2, |x| (0..12).map(|month| energy(x, month) - energy(&truth, month)).collect());
        for (found, truth) in fit.point.iter().zip(truth) {
            assert!((found - truth).abs() < 1e-3, "{fit:?}");
        }
        assert!(fit.at_bound.is_empty() && fit.collinear.is_empty() && fit.without_effect.is_empty());
    }

    #[test]
    fn an_unknown_that_wants_to_leave_its_bound_stays_there_and_the_other_is_fitted() {
        let fit = fitted(2, |x| vec![x[0].exp() - 9.0, x[1].exp() - 2.0]);
        assert_eq!(fit.at_bound, [0]);
        assert!((fit.point[0] - 5.0_f64.ln()).abs() < 1e-12 && (fit.point[1] - 2.0_f64.ln()).abs() < 1e-3);
    }

    #[test]
    fn collinear_unknowns_and_unknowns_without_effect_are_named() {
        let fit = fitted(3, |x| (0..12).map(|m| energy(x, m) - 2.0 + 1e-6 * x[2]).collect());
        assert_eq!((fit.collinear, fit.without_effect), (vec![], vec![2]));
        let fit = fitted(2, |x| vec![x[0] + x[1] - 1.0, 2.0 * x[0] + 2.01 * x[1] - 2.0]);
        assert_eq!(fit.collinear, [0, 1]);
    }
}
