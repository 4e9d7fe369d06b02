//! What levels of supervisory points do to cost and discomfort, identified from hours in which they moved at random.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::drivers::Drivers;
use super::hour::Hour;
use super::regression::{Estimate, Rows};
use crate::guideline36::{REVISION, Shift};
use crate::parameter_set::read;
use crate::{Error, Result};

/// Distance from 0, in standard deviations, from which on an effect counts: the one-sided interval of 95 %.
const SURE: f64 = 1.645;
/// Regularization of what explains an hour without shifts, and of effects.
const RIDGE: [f64; 2] = [1e-3, 0.05];
/// Least sum of the absolute values of a regressor, relative to its largest, with which it is used.
const LEAST_SUM: f64 = 3.0;
/// Distance to a setpoint within which a zone counts as heated or cooled, K.
const NEAR: f64 = 1.0;
/// Outdoor temperature below the zones' from which on they gain heat, K.
const GAIN: f64 = 8.0;
/// Units of heat losses and gains, K.
const UNITS: [f64; 2] = [20.0, 10.0];

/// The identified model of a building.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Name of the building.
    pub building: String,
    /// Days in which it was identified.
    pub identified: String,
    /// Revision of the sequences ([`REVISION`]).
    pub guideline36: u32,
    /// Lowest and highest mean heating setpoint, °C.
    pub setpoints: [f64; 2],
    /// Effects of the levels that were tried.
    pub effects: Vec<Effect>,
}

/// The effect of a level of a shift, on all its points together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Name of the shift.
    pub shift: String,
    /// The level, in the unit of the shift.
    pub value: f64,
    /// Effect on cost, relative to the mean hour's.
    pub cost: Response,
    /// Effect on discomfort, relative to the mean hour's.
    pub discomfort: Response,
}

/// An effect as a linear function of its terms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Response {
    /// Coefficients of the terms.
    pub mean: Vec<f64>,
    /// Their covariances.
    pub covariance: Vec<Vec<f64>>,
}

impl Response {
    /// Returns the effect and its standard deviation.
    fn at(&self, terms: &[f64]) -> [f64; 2] {
        let mean = self.mean.iter().zip(terms).map(|(mean, term)| mean * term).sum();
        let rows = self.covariance.iter().zip(terms);
        let variance: f64 = rows
            .map(|(row, own)| own * row.iter().zip(terms).map(|(value, term)| value * term).sum::<f64>())
            .sum();
        [mean, variance.max(0.0).sqrt()]
    }

    /// Returns the effect if it is surely not 0, otherwise 0.
    fn sure(&self, terms: &[f64]) -> f64 {
        let [mean, deviation] = self.at(terms);
        if mean.abs() > SURE * deviation { mean } else { 0.0 }
    }
}

impl Effect {
    /// Returns the effects on cost and discomfort in an hour, as far as they are sure.
    pub(super) fn predict(&self, drivers: Drivers) -> [f64; 2] {
        let Some(shift) = shift(&self.shift) else { return [0.0; 2] };
        let terms = drivers.terms(shift);
        [self.cost.sure(&terms), self.discomfort.sure(&terms)]
    }
}

/// Returns the shift of a name, if a model may have effects of it.
fn shift(name: &str) -> Option<Shift> {
    shifts().find(|shift| shift.described().0 == name)
}

/// Returns the shifts with levels.
pub(super) fn shifts() -> impl Iterator<Item = Shift> {
    let all = Shift::AIR_LOOP.iter().chain(Shift::UNIT).chain(Shift::ZONE).copied();
    all.filter(|shift| Drivers::levels(*shift).is_some())
}

impl Model {
    /// Reads a model from a JSON file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ParameterFile`] with the reason.
    pub fn read(path: &Path) -> Result<Self> {
        let model: Self = read(path)?;
        match model.check() {
            Ok(()) => Ok(model),
            Err(why) => Err(Error::ParameterFile { path: path.to_owned(), why }),
        }
    }

    /// Checks that the model is of these sequences, and that all effects are of known shifts and finite.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        if self.guideline36 != REVISION {
            return Err(format!(
                "its model is of revision {} of guideline36, which is {REVISION} here; identify it again, by `mpc` without a file",
                self.guideline36
            ));
        }
        for effect in &self.effects {
            let Some(own) = shift(&effect.shift) else {
                let known: Vec<&str> = shifts().map(|shift| shift.described().0).collect();
                return Err(format!(
                    "unknown shift `{}`; expected one of {}",
                    effect.shift,
                    known.join(", ")
                ));
            };
            let (terms, _) = Drivers::shape(own);
            for Response { mean, covariance } in [&effect.cost, &effect.discomfort] {
                let fits = mean.len() == terms && covariance.len() == terms;
                if !fits || covariance.iter().any(|row| row.len() != terms) {
                    return Err(format!("an effect of `{}` has not {terms} terms", effect.shift));
                }
                if !mean.iter().chain(covariance.iter().flatten()).all(|value| value.is_finite()) {
                    return Err(format!("an effect of `{}` is not a finite number", effect.shift));
                }
            }
        }
        Ok(())
    }

    /// Identifies a model from consecutive hours in which the levels of the shifts of a building moved.
    pub(super) fn of(building: &str, identified: String, tried: &[Shift], hours: &[Hour]) -> Self {
        let bounds = [f64::min as fn(f64, f64) -> f64, f64::max];
        let setpoints = bounds.map(|pick| hours.iter().map(|hour| hour.setpoint).reduce(pick).unwrap_or(0.0));
        let (rows, columns) = rows(tried, hours, setpoints);
        let uncertain = columns.iter().map(Column::count).sum();
        let explain = |value: fn(&Hour) -> f64| {
            let mean = hours.iter().map(value).sum::<f64>() / hours.len() as f64;
            let values: Vec<f64> = hours.iter().map(|hour| value(hour) / mean).collect();
            (mean > 0.0).then(|| rows.explain(&values, uncertain))
        };
        let (cost, discomfort) = (explain(|hour| hour.cost), explain(|hour| hour.discomfort));
        let mut first = 0;
        let effects = columns.iter().map(|column| {
            let own = first;
            first += column.count();
            let response = |estimate: &Option<Estimate>| column.response(estimate.as_ref(), own, uncertain);
            let [cost, discomfort] = [&cost, &discomfort].map(response);
            Effect { shift: column.shift.described().0.to_owned(), value: column.value, cost, discomfort }
        });
        let effects = effects.collect();
        Self { building: building.to_owned(), identified, guideline36: REVISION, setpoints, effects }
    }
}

/// The regressors of a level: its terms, in its own hour and in later ones.
struct Column {
    shift: Shift,
    /// Number of the shift among the tried ones.
    number: usize,
    /// The level, from 1.
    level: usize,
    value: f64,
}

impl Column {
    /// Number of regressors.
    fn count(&self) -> usize {
        let (terms, hours) = Drivers::shape(self.shift);
        terms * hours
    }

    /// Returns the effect in all hours together, of the coefficients from `first` on among the uncertain ones.
    fn response(&self, estimate: Option<&Estimate>, first: usize, uncertain: usize) -> Response {
        let (terms, hours) = Drivers::shape(self.shift);
        let Some(Estimate { coefficients, covariance }) = estimate else {
            return Response { mean: vec![0.0; terms], covariance: vec![vec![0.0; terms]; terms] };
        };
        let base = coefficients.len() - uncertain;
        let at = |term: usize, hour: usize| first + hour * terms + term;
        let mean = |term: usize| (0..hours).map(|hour| coefficients[base + at(term, hour)]).sum();
        let covariance = |row: usize, column: usize| {
            let pairs = (0..hours).flat_map(|own| (0..hours).map(move |other| (own, other)));
            pairs.map(|(own, other)| covariance[at(row, own)][at(column, other)]).sum()
        };
        Response {
            mean: (0..terms).map(mean).collect(),
            covariance: (0..terms)
                .map(|row| (0..terms).map(|column| covariance(row, column)).collect())
                .collect(),
        }
    }
}

/// Returns the rows of a regression, and the levels whose effects are the last regressors.
fn rows(tried: &[Shift], hours: &[Hour], setpoints: [f64; 2]) -> (Rows, Vec<Column>) {
    let drivers: Vec<Drivers> =
        hours.iter().map(|hour| Drivers::new(hour.outdoor, hour.setpoint, setpoints)).collect();
    let columns: Vec<Column> = tried
        .iter()
        .enumerate()
        .flat_map(|(number, &shift)| {
            let levels = Drivers::levels(shift).into_iter().flatten().enumerate();
            levels.map(move |(level, value)| Column { shift, number, level: level + 1, value })
        })
        .collect();
    let mut inputs = undisturbed(hours, &drivers);
    let base = inputs.first().map_or(0, Vec::len);
    for (row, input) in inputs.iter_mut().enumerate() {
        for column in &columns {
            let (terms, lasting) = Drivers::shape(column.shift);
            for later in 0..lasting {
                let is_on = row >= later && hours[row - later].levels[column.number] == column.level;
                let own =
                    if is_on { drivers[row - later].terms(column.shift) } else { [0.0; Drivers::TERMS] };
                input.extend(&own[..terms]);
            }
        }
    }
    let width = inputs.first().map_or(0, Vec::len);
    let ridge = (0..width).map(|index| RIDGE[usize::from(index >= base)]).collect();
    (Rows { inputs, hours: hours.iter().map(|hour| hour.of_day).collect(), ridge }, columns)
}

/// Returns what explains hours without shifts: hour and kind of the day, how far zones are from their setpoints, weather, people
/// and the heat that units delivered.
fn undisturbed(hours: &[Hour], drivers: &[Drivers]) -> Vec<Vec<f64>> {
    let is_narrow: Vec<bool> = drivers.iter().map(|own| own.narrow() > 0.5).collect();
    let day = |row: usize| row / 24 * 24..hours.len().min(row / 24 * 24 + 24);
    let works = |row: usize| is_narrow[day(row)].contains(&true);
    let heat = scaled(hours);
    (0..hours.len())
        .map(|row| {
            let (hour, next) = (&hours[row], hours.get(row + 1).unwrap_or(&hours[row]));
            let narrow = f64::from(u8::from(is_narrow[row]));
            let Need { recovery, near, weather } = Need::of(hour, next);
            let mut inputs = vec![narrow, drivers[row].narrow(), narrow * hour.occupancy];
            inputs.extend(recovery);
            for factor in [1.0, narrow] {
                inputs.extend(near.map(|near| factor * near));
                inputs.extend(weather.map(|weather| factor * weather));
                inputs.extend([0, 1].map(|side: usize| factor * near[side] * weather[side]));
            }
            let mut clock = [0.0; 48];
            clock[hour.of_day + 24 * usize::from(works(row))] = 1.0;
            inputs.extend(clock);
            inputs.extend(heat.iter().map(|form| form[row]));
            inputs
        })
        .collect()
}

/// What the zones of an hour need, as means.
struct Need {
    /// Distance below the heating and above the cooling setpoint, of this hour and of the next, K.
    recovery: [f64; 4],
    /// Share of the zones near their heating and their cooling setpoint.
    near: [f64; 2],
    /// Losses and gains by the outdoor temperature.
    weather: [f64; 2],
}

impl Need {
    fn of(hour: &Hour, next: &Hour) -> Self {
        let mut own = Self { recovery: [0.0; 4], near: [0.0; 2], weather: [0.0; 2] };
        let share = 1.0 / hour.zones.len() as f64;
        let mut temperature = 0.0;
        for ([air, heating, cooling], [_, next_heating, next_cooling]) in hour.zones.iter().zip(&next.zones) {
            let recovery = [heating - air, air - cooling, next_heating - air, air - next_cooling];
            own.recovery.iter_mut().zip(recovery).for_each(|(sum, own)| *sum += share * own.max(0.0));
            let near = [air - heating, cooling - air].map(|distance| (1.0 - distance / NEAR).clamp(0.0, 1.0));
            own.near.iter_mut().zip(near).for_each(|(sum, own)| *sum += share * own);
            temperature += share * air;
        }
        let differences = [temperature - hour.outdoor, hour.outdoor - temperature + GAIN];
        own.weather = [0, 1].map(|side: usize| differences[side].max(0.0) / UNITS[side]);
        own
    }
}

/// Returns the forms of heat that units delivered, each relative to its largest value, without those that hardly occur.
fn scaled(hours: &[Hour]) -> Vec<Vec<f64>> {
    let forms = hours.first().map_or(0, |hour| hour.delivered.len());
    let form = |index: usize| {
        let values = hours.iter().map(|hour| hour.delivered[index]);
        let largest = values.clone().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let scaled: Vec<f64> = values.map(|value| value / largest).collect();
        (largest > 0.0 && scaled.iter().map(|value| value.abs()).sum::<f64>() > LEAST_SUM).then_some(scaled)
    };
    (0..forms).filter_map(form).collect()
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
            let saving = if level == 2 && setpoint > 18.0 { 0.1 } else { 0.0 };
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
    fn a_level_that_saves_is_told_from_one_that_does_nothing() {
        let model = Model::of("a", "days".to_owned(), &[Shift::SupplyTemperature], &hours());
        model.check().unwrap();
        let drivers = |setpoint| Drivers::new(-2.0, setpoint, model.setpoints);
        let [colder, warmer] = &model.effects[..] else { panic!("{:?}", model.effects) };
        assert_eq!((colder.value, warmer.value), (-3.0, 6.0));
        let [saving, discomfort] = warmer.predict(drivers(20.0));
        assert!((-0.13..-0.05).contains(&saving) && discomfort == 0.0, "{saving} {discomfort}");
        assert_eq!(colder.predict(drivers(20.0)), [0.0; 2]);
        assert_eq!(warmer.predict(drivers(16.0)), [0.0; 2], "at night");
    }

    #[test]
    fn a_model_of_other_shifts_or_sequences_is_refused() {
        let good = Model::of("a", "days".to_owned(), &[Shift::MinimumFlow], &hours());
        let said = |change: fn(&mut Model)| {
            let mut bad = good.clone();
            change(&mut bad);
            bad.check().unwrap_err()
        };
        assert!(said(|bad| bad.guideline36 += 1).contains("identify it again"));
        assert!(said(|bad| bad.effects[0].shift = "earlier start".to_owned()).contains("minimum flow shift"));
        assert!(said(|bad| bad.effects[0].cost.mean.truncate(1)).contains("3 terms"));
        assert!(said(|bad| bad.effects[1].cost.mean[0] = f64::NAN).contains("finite"));
    }
}
