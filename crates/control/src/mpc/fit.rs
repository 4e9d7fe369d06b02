//! Fits a model to hours in which the levels of shifts moved.

use super::drivers::Drivers;
use super::hour::Hour;
use super::model::{Effect, Model, Response};
use super::regression::{Estimate, Rows};
use super::undisturbed::{expected_inputs, inputs};
use crate::guideline36::{REVISION, Shift};

/// Powers of a shift: its effect is linear and, to a lesser degree, quadratic.
const POWERS: usize = 2;
/// Regularization of the regressors of an hour without shifts.
const RIDGE: f64 = 1e-2;
/// Regularization of the powers of a shift: effects of some percent are usual, and much curvature is not.
const EFFECT_RIDGE: [f64; POWERS] = [30.0, 300.0];
/// Regularization of the expected amount of an hour.
const EXPECTED_RIDGE: f64 = 0.1;

/// Smallest size of the errors of an hour, relative to the mean hour.
const LEAST_SIZE: f64 = 0.1;
/// Share of the mean hour's cost below which equipment is off: such hours are left out.
const OFF: f64 = 0.02;

/// Regression of an hourly amount, relative to its mean. Effects are relative to the expected amount of each hour.
struct Explained {
    expected: Vec<f64>,
    estimate: Estimate,
}

/// Identifies the model of a building from consecutive hours.
pub(super) fn fit(building: &str, identified: String, tried: &[Shift], hours: &[Hour]) -> Model {
    let pick = |pick: fn(f64, f64) -> f64| hours.iter().map(|hour| hour.setpoint).reduce(pick).unwrap_or(0.0);
    let setpoints = [pick(f64::min), pick(f64::max)];
    let drivers: Vec<Drivers> =
        hours.iter().map(|hour| Drivers::new(hour.outdoor, hour.setpoint, setpoints)).collect();
    let columns = columns(tried);
    let explain = |amount: fn(&Hour) -> f64| explain(amount, hours, &drivers, &columns);
    let (cost, discomfort) = (explain(|hour| hour.cost), explain(|hour| hour.discomfort));
    let profile = |explained: &Option<Explained>| profile(explained.as_ref(), hours, &drivers);
    let uncertain = columns.iter().map(Column::count).sum();
    let mut first = 0;
    let mut effects = Vec::new();
    for column in &columns {
        let levels = column.levels.into_iter().filter(|level| Drivers::may_be_chosen(column.shift, *level));
        effects.extend(levels.map(|value| {
            let response = |explained: &Option<Explained>| {
                column.response(value, explained.as_ref().map(|own| &own.estimate), first, uncertain)
            };
            let [cost, discomfort] = [&cost, &discomfort].map(response);
            Effect { shift: column.shift.described().0.to_owned(), value, cost, discomfort }
        }));
        first += column.count();
    }
    Model {
        building: building.to_owned(),
        identified,
        guideline36: REVISION,
        setpoints,
        effects,
        cost: profile(&cost),
        discomfort: profile(&discomfort),
    }
}

/// Returns the regressors of all shifts.
fn columns(tried: &[Shift]) -> Vec<Column> {
    let of_shift = |(number, &shift): (usize, &Shift)| {
        Drivers::levels(shift).map(|levels| Column { shift, number, levels })
    };
    tried.iter().enumerate().filter_map(of_shift).collect()
}

/// Explains an amount; `None` if there is none at all.
fn explain(
    amount: fn(&Hour) -> f64,
    hours: &[Hour],
    drivers: &[Drivers],
    columns: &[Column],
) -> Option<Explained> {
    let mean = hours.iter().map(amount).sum::<f64>() / hours.len() as f64;
    if mean <= 0.0 {
        return None;
    }
    let values: Vec<f64> = hours.iter().map(|hour| amount(hour) / mean).collect();
    let of_day = hours.iter().map(|hour| hour.of_day).collect();
    let known = expected_inputs(hours, drivers);
    let ridge = vec![EXPECTED_RIDGE; known.first().map_or(0, Vec::len)];
    let sizes = vec![1.0; hours.len()];
    let mut before = Rows { inputs: known, hours: of_day, sizes, ridge };
    before.sizes = before.fitted(&values).iter().map(|size| size + LEAST_SIZE).collect();
    let expected = before.fitted(&values);
    let mut inputs = inputs(hours, drivers);
    let base = inputs.first().map_or(0, Vec::len);
    for (row, input) in inputs.iter_mut().enumerate() {
        columns.iter().for_each(|column| column.add(row, hours, drivers, expected[row], input));
    }
    let least = OFF * hours.iter().map(|hour| hour.cost).sum::<f64>() / hours.len() as f64;
    let runs: Vec<usize> = (0..hours.len()).filter(|&row| hours[row].cost >= least).collect();
    let rows = Rows {
        inputs: runs.iter().map(|&row| std::mem::take(&mut inputs[row])).collect(),
        hours: runs.iter().map(|&row| hours[row].of_day).collect(),
        sizes: runs.iter().map(|&row| expected[row] + LEAST_SIZE).collect(),
        ridge: std::iter::repeat_n(RIDGE, base).chain(columns.iter().flat_map(Column::ridge)).collect(),
    };
    let values: Vec<f64> = runs.iter().map(|&row| values[row]).collect();
    Some(Explained { estimate: rows.explain(&values, columns.iter().map(Column::count).sum()), expected })
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
/// in later ones.
struct Column {
    shift: Shift,
    /// Number of the shift among the tried ones.
    number: usize,
    levels: [f64; 2],
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

    /// Number of regressors.
    fn count(&self) -> usize {
        let (terms, hours) = Drivers::shape(self.shift);
        POWERS * terms * hours
    }

    /// Returns the regularization of the regressors.
    fn ridge(&self) -> impl Iterator<Item = f64> {
        let each = self.count() / POWERS;
        EFFECT_RIDGE.into_iter().flat_map(move |ridge| std::iter::repeat_n(ridge, each))
    }

    /// Adds the regressors of an hour.
    fn add(&self, row: usize, hours: &[Hour], drivers: &[Drivers], expected: f64, input: &mut Vec<f64>) {
        let (terms, lasting) = Drivers::shape(self.shift);
        let own = drivers[row].terms(self.shift);
        for power in 0..POWERS {
            for later in 0..lasting {
                let past = row.checked_sub(later).map_or(0.0, |past| self.powers(&hours[past])[power]);
                input.extend(own[..terms].iter().map(|term| past * expected * term));
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
        let model = fit("a", "days".to_owned(), &[Shift::SupplyTemperature], &hours());
        model.check().unwrap();
        let values: Vec<f64> = model.effects.iter().map(|effect| effect.value).collect();
        assert_eq!(values, [6.0]);
        let at = |setpoint| {
            let drivers = Drivers::new(-2.0, setpoint, model.setpoints);
            model.predict(12, drivers).collect::<Vec<_>>()
        };
        let [[saving, discomfort]] = at(20.0)[..] else { panic!("{:?}", model.effects) };
        assert!((-0.15..-0.05).contains(&saving) && discomfort == 0.0, "{saving} {discomfort}");
    }
}
