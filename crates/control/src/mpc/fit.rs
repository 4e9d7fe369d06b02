//! Fits a model to hours in which the levels of shifts moved.

use super::drivers::Drivers;
use super::hour::Hour;
use super::model::{Effect, Model, Response};
use super::prior::Prior;
use super::regression::{Estimate, Rows};
use super::undisturbed::{expected_inputs, inputs};
use crate::guideline36::{REVISION, Shift};

/// Powers of a shift: its effect is linear and, to a lesser degree, quadratic.
const POWERS: usize = 2;
/// Regularization of the regressors of an hour without shifts.
const RIDGE: f64 = 1e-2;
/// Deviation of the powers of a shift without a prior: effects of some percent are usual, and much curvature is not.
const USUAL: [f64; POWERS] = [0.18, 0.06];
/// Cost and discomfort.
pub(super) const AMOUNTS: usize = 2;
/// Regularization of the expected amount of an hour.
const EXPECTED_RIDGE: f64 = 0.1;

/// Smallest size of the errors of an hour, relative to the mean hour.
const LEAST_SIZE: f64 = 0.1;
/// Share of the mean hour's cost below which equipment is off: such hours are left out.
const OFF: f64 = 0.02;

/// Regression of an hourly amount, relative to its mean. Effects are relative to the expected amount of each hour.
pub(super) struct Explained {
    expected: Vec<f64>,
    pub(super) estimate: Estimate,
}

/// Identifies the model of a building from consecutive hours.
pub(super) fn fit(
    building: &str,
    identified: String,
    (tried, hours): (&[Shift], &[Hour]),
    prior: &Prior,
) -> Model {
    let columns = columns(tried, prior);
    let (setpoints, drivers) = drivers(hours);
    let [cost, discomfort] = [0, 1].map(|amount| explain(amount, hours, &drivers, &columns));
    let profile = |explained: &Option<Explained>| profile(explained.as_ref(), hours, &drivers);
    let uncertain = columns.iter().map(|column| count(column.shift)).sum();
    let mut first = 0;
    let mut effects = Vec::new();
    for column in &columns {
        let levels = column.levels.into_iter().filter(|level| Drivers::may_be_chosen(column.shift, *level));
        effects.extend(levels.flat_map(|level| [level, 0.5 * level]).map(|value| {
            let response = |explained: &Option<Explained>| {
                column.response(value, explained.as_ref().map(|own| &own.estimate), first, uncertain)
            };
            let [cost, discomfort] = [&cost, &discomfort].map(response);
            Effect { shift: column.shift.described().0.to_owned(), value, cost, discomfort }
        }));
        first += count(column.shift);
    }
    Model {
        building: building.to_owned(),
        identified,
        guideline36: REVISION,
        setpoints,
        effects,
        deviation: 24.0 * hours.iter().map(|hour| hour.deviation).sum::<f64>() / hours.len() as f64,
        cost: profile(&cost),
        discomfort: profile(&discomfort),
    }
}

/// Returns the lowest and the highest setpoint, and the drivers of all hours.
pub(super) fn drivers(hours: &[Hour]) -> ([f64; 2], Vec<Drivers>) {
    let pick = |pick: fn(f64, f64) -> f64| hours.iter().map(|hour| hour.setpoint).reduce(pick).unwrap_or(0.0);
    let setpoints = [pick(f64::min), pick(f64::max)];
    let of_hour = |hour: &Hour| Drivers::new(hour.outdoor, hour.setpoint, setpoints);
    (setpoints, hours.iter().map(of_hour).collect())
}

/// Returns the regressors of all shifts, with what a prior expects of them.
pub(super) fn columns(tried: &[Shift], prior: &Prior) -> Vec<Column> {
    let of_shift = |(number, &shift): (usize, &Shift)| {
        let expected = || [0, 1].map(|amount| prior.expected(shift, amount));
        Drivers::levels(shift).map(|levels| Column { shift, number, levels, expected: expected() })
    };
    tried.iter().enumerate().filter_map(of_shift).collect()
}

/// Returns the number of regressors of a shift.
pub(super) fn count(shift: Shift) -> usize {
    let (terms, parts) = Drivers::shape(shift);
    POWERS * terms * parts
}

/// Returns mean and deviation of the coefficients of a shift in any building.
pub(super) fn unknown(shift: Shift) -> Vec<[f64; 2]> {
    let each = count(shift) / POWERS;
    USUAL.into_iter().flat_map(|usual| std::iter::repeat_n([0.0, usual], each)).collect()
}

/// Explains cost (0) or discomfort (1); `None` if there is none at all.
pub(super) fn explain(
    number: usize,
    hours: &[Hour],
    drivers: &[Drivers],
    columns: &[Column],
) -> Option<Explained> {
    let amount = |hour: &Hour| [hour.cost, hour.discomfort][number];
    let mean = hours.iter().map(amount).sum::<f64>() / hours.len() as f64;
    if mean <= 0.0 {
        return None;
    }
    let values: Vec<f64> = hours.iter().map(|hour| amount(hour) / mean).collect();
    let of_day = hours.iter().map(|hour| hour.of_day).collect();
    let known = expected_inputs(hours, drivers);
    let width = known.first().map_or(0, Vec::len);
    let mut before = Rows {
        inputs: known,
        hours: of_day,
        sizes: vec![1.0; hours.len()],
        ridge: vec![EXPECTED_RIDGE; width],
        means: vec![0.0; width],
    };
    before.sizes = before.fitted(&values).iter().map(|size| size + LEAST_SIZE).collect();
    let expected = before.fitted(&values);
    let mut inputs = inputs(hours, drivers);
    let base = inputs.first().map_or(0, Vec::len);
    for (row, input) in inputs.iter_mut().enumerate() {
        columns.iter().for_each(|column| column.add(row, hours, drivers, expected[row], input));
    }
    let expected_of = |part: usize| {
        columns.iter().flat_map(move |column| column.expected[number].iter().map(move |own| own[part]))
    };
    let least = OFF * hours.iter().map(|hour| hour.cost).sum::<f64>() / hours.len() as f64;
    let runs: Vec<usize> = (0..hours.len()).filter(|&row| hours[row].cost >= least).collect();
    let rows = Rows {
        inputs: runs.iter().map(|&row| std::mem::take(&mut inputs[row])).collect(),
        hours: runs.iter().map(|&row| hours[row].of_day).collect(),
        sizes: runs.iter().map(|&row| expected[row] + LEAST_SIZE).collect(),
        ridge: std::iter::repeat_n(RIDGE, base).chain(expected_of(1).map(|own| own.powi(-2))).collect(),
        means: std::iter::repeat_n(0.0, base).chain(expected_of(0)).collect(),
    };
    let values: Vec<f64> = runs.iter().map(|&row| values[row]).collect();
    Some(Explained {
        estimate: rows.explain(&values, columns.iter().map(|column| count(column.shift)).sum()),
        expected,
    })
}

/// Returns the mean expected amount by hour of the day, in setback and outside.
fn profile(explained: Option<&Explained>, hours: &[Hour], drivers: &[Drivers]) -> [Vec<f64>; 2] {
    [false, true].map(|narrow| {
        let (mut sums, mut counts) = (vec![0.0; 24], vec![0.0; 24]);
        for (row, hour) in hours.iter().enumerate() {
            if (drivers[row].narrow() > 0.5) == narrow {
                sums[hour.of_day] += explained.map_or(0.0, |own| own.expected[row]);
                counts[hour.of_day] += 1.0;
            }
        }
        sums.iter().zip(&counts).map(|(sum, count)| sum / f64::max(*count, 1.0)).collect()
    })
}

/// The regressors of a shift: its share of the larger level and the square of it, times its terms, in its own hour and
/// in the earlier ones.
pub(super) struct Column {
    pub(super) shift: Shift,
    /// Number of the shift among the tried ones.
    number: usize,
    levels: [f64; 2],
    /// Mean and deviation of each coefficient before its estimate, for cost and for discomfort.
    expected: [Vec<[f64; 2]>; AMOUNTS],
}

impl Column {
    /// Returns a level as a share of the larger one.
    fn share(&self, value: f64) -> f64 {
        value / self.levels.map(f64::abs).into_iter().fold(0.0, f64::max)
    }

    /// Returns the shift's powers in an hour.
    fn powers(&self, hour: &Hour) -> [f64; POWERS] {
        let share =
            hour.levels[self.number].checked_sub(1).map_or(0.0, |level| self.share(self.levels[level]));
        [share, share * share]
    }

    /// Adds the regressors of an hour.
    fn add(&self, row: usize, hours: &[Hour], drivers: &[Drivers], expected: f64, input: &mut Vec<f64>) {
        let (terms, parts) = Drivers::shape(self.shift);
        let own = drivers[row].terms(self.shift);
        let earlier = &hours[row.saturating_sub(Drivers::lasting(self.shift))..row];
        for power in 0..POWERS {
            let mean = |of: &[Hour]| {
                of.iter().map(|hour| self.powers(hour)[power]).sum::<f64>() / of.len().max(1) as f64
            };
            for level in [mean(&hours[row..=row]), mean(earlier)].into_iter().take(parts) {
                input.extend(own[..terms].iter().map(|term| level * expected * term));
            }
        }
    }

    /// Returns the effect of a level in all hours together, of the coefficients from `first` on among the uncertain
    /// ones.
    fn response(&self, value: f64, estimate: Option<&Estimate>, first: usize, uncertain: usize) -> Response {
        let (terms, hours) = Drivers::shape(self.shift);
        let Some(Estimate { coefficients, covariance }) = estimate else {
            return Response { mean: vec![0.0; terms], covariance: vec![vec![0.0; terms]; terms] };
        };
        let (share, base) = (self.share(value), coefficients.len() - uncertain);
        let factor = |number: usize| [share, share * share][number / hours];
        let at = |term: usize, number: usize| first + number * terms + term;
        let numbers = || 0..POWERS * hours;
        let mean = |term: usize| numbers().map(|own| factor(own) * coefficients[base + at(term, own)]).sum();
        let covariance = |row: usize, column: usize| {
            let pairs = numbers().flat_map(|own| numbers().map(move |other| (own, other)));
            pairs
                .map(|(own, other)| factor(own) * factor(other) * covariance[at(row, own)][at(column, other)])
                .sum()
        };
        Response {
            mean: (0..terms).map(mean).collect(),
            covariance: (0..terms)
                .map(|row| (0..terms).map(|column| covariance(row, column)).collect())
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use b2b_base::random::{standard_normal, stream, uniform};

    use super::*;

    /// Two weeks of a building whose cost rises with the cold, and falls by a tenth of the mean under warm supply air.
    fn hours() -> Vec<Hour> {
        let mut random = stream("model", 0, 0);
        let hour = |number: usize| {
            let (of_day, level) = (number % 24, (3.0 * uniform(&mut random)) as usize);
            let outdoor = -2.0 + 4.0 * standard_normal(&mut random);
            let setpoint = if (6..22).contains(&of_day) { 20.0 } else { 16.0 };
            let saving = if level == 2 { 0.1 } else { 0.0 };
            Hour {
                of_day,
                outdoor,
                setpoint,
                zones: vec![[setpoint + 0.1, setpoint, 26.0]; 2],
                levels: vec![level],
                cost: 1.0 - outdoor / 20.0 - saving + 0.05 * standard_normal(&mut random),
                discomfort: 0.1 * uniform(&mut random),
                ..Hour::default()
            }
        };
        (0..336).map(hour).collect()
    }

    #[test]
    fn a_level_that_saves_is_distinguished_from_one_without_effect() {
        let model = fit("a", "days".to_owned(), (&[Shift::SupplyTemperature], &hours()), &Prior::default());
        model.check().unwrap();
        let values: Vec<f64> = model.effects.iter().map(|effect| effect.value).collect();
        assert_eq!(values, [6.0, 3.0], "the level that was tried, and half of it");
        let at = |setpoint| {
            let drivers = Drivers::new(-2.0, setpoint, model.setpoints);
            model.predict(12, drivers).collect::<Vec<_>>()
        };
        let [[saving, discomfort], _] = at(20.0)[..] else { panic!("{:?}", model.effects) };
        assert!((-0.15..-0.05).contains(&saving) && discomfort == 0.0, "{saving} {discomfort}");
    }
}
