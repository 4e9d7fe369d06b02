//! What is known of the effects in buildings of a type before one of them is identified: their means and deviations over
//! training buildings. The identification of a building begins from them and moves as far as its own hours justify.

use std::collections::BTreeMap;

use b2b_building::{BuildingType, PreparedBuilding};
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use super::fit::{AMOUNTS, Explained, columns, count, drivers, explain, unknown};
use super::identification::Observed;
use crate::guideline36::{REVISION, Shift};
use crate::search::least_squares::{dot, solve};

/// The priors that ship with the program, by building type.
pub(super) const SHIPPED: &str = include_str!("../../data/mpc_prior.json");
/// Rounds of the estimate of means and deviations.
const ROUNDS: usize = 300;
/// Smallest deviation between buildings.
const LEAST_DEVIATION: f64 = 0.003;

/// Mean and deviation of a coefficient over the buildings of a type.
type Expected = [f64; 2];

/// Priors of building types, and what they were learned under.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Priors {
    /// Revision of the sequences ([`REVISION`]).
    guideline36: u32,
    /// Task, for readers. Effects are relative to the cost of their hour, so that they hold under other tariffs too.
    task: String,
    /// Priors by building type.
    types: BTreeMap<BuildingType, Prior>,
}

impl Priors {
    /// Returns priors that were learned under the sequences as they are and under this task.
    pub fn new(task: &Task, types: BTreeMap<BuildingType, Prior>) -> Self {
        Self { guideline36: REVISION, task: task.to_string(), types }
    }

    fn shipped() -> Self {
        serde_json::from_str(SHIPPED).expect("a test reads the shipped priors")
    }
}

/// Expected coefficients of cost and of discomfort, by the name of a shift. Nothing is expected of the effect of a shift
/// without an entry, besides its usual size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Prior(BTreeMap<String, [Vec<Expected>; AMOUNTS]>);

impl Prior {
    /// Returns the shipped prior of a building's type; for other buildings, one that expects nothing.
    pub(super) fn of(building: &PreparedBuilding) -> Self {
        let own = building.class.and_then(|class| Priors::shipped().types.remove(&class.building_type));
        own.unwrap_or_default()
    }

    /// Returns what is expected of the coefficients of a shift for an amount.
    pub(super) fn expected(&self, shift: Shift, amount: usize) -> Vec<Expected> {
        self.0.get(shift.described().0).map_or_else(|| unknown(shift), |own| own[amount].clone())
    }

    /// Estimates means and deviations from what was observed in buildings of a type, by expectation maximization.
    pub fn learn(observed: &[Observed]) -> Self {
        let mut evidence: BTreeMap<&str, [Vec<Evidence>; AMOUNTS]> = BTreeMap::new();
        let mut first_guess: BTreeMap<&str, Vec<Expected>> = BTreeMap::new();
        for own in observed {
            let columns = columns(&own.tried, &Self::default());
            let (_, drivers) = drivers(&own.hours);
            for amount in 0..AMOUNTS {
                let Some(explained) = explain(amount, &own.hours, &drivers, &columns) else { continue };
                let mut first = 0;
                for column in &columns {
                    let name = column.shift.described().0;
                    first_guess.insert(name, unknown(column.shift));
                    let own = Evidence::of(column.shift, first, &explained);
                    // A building that is off for nearly all hours says nothing.
                    evidence.entry(name).or_default()[amount].extend(Some(own).filter(Evidence::is_finite));
                    first += count(column.shift);
                }
            }
        }
        let learned = |(name, amounts): (&str, [Vec<Evidence>; AMOUNTS])| {
            let of_amount = |own: Vec<Evidence>| maximize(&own, first_guess[name].clone());
            (name.to_owned(), amounts.map(of_amount))
        };
        Self(evidence.into_iter().map(learned).collect())
    }
}

/// What the hours of one building say of the coefficients of a shift: precision, row by row, and precision × mean.
struct Evidence {
    precision: Vec<f64>,
    weighted: Vec<f64>,
}

impl Evidence {
    /// Takes from an estimate what was expected before.
    fn of(shift: Shift, first: usize, explained: &Explained) -> Self {
        let width = count(shift);
        let estimate = &explained.estimate;
        let base = estimate.coefficients.len() - estimate.covariance.len();
        let mean = &estimate.coefficients[base + first..][..width];
        let covariance: Vec<f64> = (first..first + width)
            .flat_map(|row| estimate.covariance[row][first..][..width].to_vec())
            .collect();
        let mut precision = inverse(&covariance, width);
        let mut weighted = multiply(&precision, mean);
        for (number, [expected, deviation]) in unknown(shift).into_iter().enumerate() {
            precision[number * width + number] -= deviation.powi(-2);
            weighted[number] -= expected * deviation.powi(-2);
        }
        Self { precision, weighted }
    }

    fn is_finite(&self) -> bool {
        self.precision.iter().chain(&self.weighted).all(|value| value.is_finite())
    }
}

/// Returns means and deviations under which the evidence is likely, beginning from some; without evidence, these.
fn maximize(evidence: &[Evidence], mut expected: Vec<Expected>) -> Vec<Expected> {
    let width = expected.len();
    if evidence.is_empty() {
        return expected;
    }
    for _ in 0..ROUNDS {
        let posteriors: Vec<(Vec<f64>, Vec<f64>)> =
            evidence.iter().map(|own| posterior(own, &expected)).collect();
        let share = 1.0 / evidence.len() as f64;
        for number in 0..width {
            let mean = share * posteriors.iter().map(|(mean, _)| mean[number]).sum::<f64>();
            let square = |(own, covariance): &(Vec<f64>, Vec<f64>)| {
                (own[number] - mean).powi(2) + covariance[number * width + number]
            };
            let variance = share * posteriors.iter().map(square).sum::<f64>();
            expected[number] = [mean, variance.sqrt().max(LEAST_DEVIATION)];
        }
    }
    let rounded = |own: Expected| own.map(|value| (1e4 * value).round() / 1e4);
    expected.into_iter().map(rounded).collect()
}

/// Returns mean and covariance of a building's coefficients.
fn posterior(own: &Evidence, expected: &[Expected]) -> (Vec<f64>, Vec<f64>) {
    let width = expected.len();
    let (mut precision, mut weighted) = (own.precision.clone(), own.weighted.clone());
    for (number, [mean, deviation]) in expected.iter().enumerate() {
        precision[number * width + number] += deviation.powi(-2);
        weighted[number] += mean * deviation.powi(-2);
    }
    let covariance = inverse(&precision, width);
    (multiply(&covariance, &weighted), covariance)
}

/// Returns the inverse of a positive definite matrix.
fn inverse(matrix: &[f64], width: usize) -> Vec<f64> {
    let column = |number: usize| {
        let mut column = vec![0.0; width];
        column[number] = 1.0;
        solve(&mut matrix.to_vec(), &mut column);
        column
    };
    (0..width).flat_map(column).collect()
}

fn multiply(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    matrix.chunks_exact(vector.len()).map(|row| dot(row, vector)).collect()
}

#[cfg(test)]
mod tests {
    use b2b_base::random::{standard_normal, stream};

    use super::super::model::shifts;
    use super::*;

    #[test]
    fn the_shipped_priors_are_read() {
        let Priors { guideline36, types, .. } = Priors::shipped();
        assert_eq!(guideline36, REVISION, "learn them again by `b2b tune prior`");
        for (name, prior) in types {
            for (shift, amounts) in &prior.0 {
                let own = shifts().find(|own| own.described().0 == shift).unwrap();
                assert_eq!(amounts.each_ref().map(Vec::len), [count(own); AMOUNTS], "{name}, {shift}");
            }
            let values = prior.0.values().flatten().flatten();
            assert!(values.clone().count() > 0 && values.flatten().all(|value| value.is_finite()), "{name}");
        }
    }

    #[test]
    fn means_and_deviations_are_found_from_imprecise_buildings() {
        let mut random = stream("prior", 0, 0);
        // Effects of -0.06 ± 0.02, each known to 0.05.
        let mut building = || {
            let own = -0.06 + 0.02 * standard_normal(&mut random) + 0.05 * standard_normal(&mut random);
            Evidence { precision: vec![400.0], weighted: vec![400.0 * own] }
        };
        let evidence: Vec<Evidence> = (0..400).map(|_| building()).collect();
        let [[mean, deviation]] = maximize(&evidence, vec![[0.0, 0.2]])[..] else {
            panic!("one coefficient")
        };
        assert_eq!(maximize(&[], vec![[0.0, 0.2]]), [[0.0, 0.2]], "no building says anything");
        assert!((mean + 0.06).abs() < 0.008 && (0.01..0.035).contains(&deviation), "{mean} {deviation}");
    }
}
