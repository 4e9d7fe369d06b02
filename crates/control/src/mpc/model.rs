//! Effects of levels of supervisory points on cost and discomfort, identified from hours in which they moved at random.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::drivers::Drivers;
use crate::guideline36::{REVISION, Shift};
use crate::parameter_set::read;
use crate::{Error, Result};

/// Distance from 0 beyond which an effect on cost and one on discomfort count, in standard deviations.
const SURE: [f64; 2] = [1.0, 2.0];

/// Smallest effect that counts, relative to the hour's amount.
const LEAST: f64 = 0.005;

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
    /// Deviation outside the band, K·h per zone and day.
    pub deviation: f64,
    /// Expected cost by hour of the day, in setback and outside, relative to the mean hour.
    pub cost: [Vec<f64>; 2],
    /// Expected discomfort, likewise.
    pub discomfort: [Vec<f64>; 2],
    /// Effects of the tried levels that may be chosen, and of half of them.
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
    /// Effect on cost, relative to the hour's.
    pub cost: Response,
    /// Effect on discomfort, relative to the hour's.
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
    fn sure(&self, terms: &[f64], sure: f64) -> f64 {
        let [mean, deviation] = self.at(terms);
        if mean.abs() > (sure * deviation).max(LEAST) { mean } else { 0.0 }
    }
}

impl Effect {
    /// Returns the effects on cost and discomfort in an hour, relative to the hour's, as far as they are sure.
    fn predict(&self, drivers: Drivers) -> [f64; 2] {
        let Some(shift) = shift(&self.shift).filter(|shift| drivers.allow(*shift)) else { return [0.0; 2] };
        let terms = drivers.terms(shift);
        [self.cost.sure(&terms, SURE[0]), self.discomfort.sure(&terms, SURE[1])]
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
        if !self.deviation.is_finite() {
            return Err("`deviation` is not a finite number".to_owned());
        }
        if self.cost.iter().chain(&self.discomfort).any(|hours| hours.len() != 24) {
            return Err("an hour of the day is missing in `cost` or `discomfort`".to_owned());
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
                    return Err(format!("an effect of `{}` does not have {terms} terms", effect.shift));
                }
                if !mean.iter().chain(covariance.iter().flatten()).all(|value| value.is_finite()) {
                    return Err(format!("an effect of `{}` is not a finite number", effect.shift));
                }
            }
        }
        Ok(())
    }

    /// Returns the effects of every level on cost and discomfort in an hour of the day, relative to the mean hour's.
    pub(super) fn predict(&self, hour: usize, drivers: Drivers) -> impl Iterator<Item = [f64; 2]> {
        let own = usize::from(drivers.narrow() > 0.5);
        let scale = [self.cost[own][hour], self.discomfort[own][hour]];
        self.effects.iter().map(move |effect| {
            let [cost, discomfort] = effect.predict(drivers);
            [cost * scale[0], discomfort * scale[1]]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Model {
        let response =
            || Response { mean: vec![-0.1, 0.02], covariance: vec![vec![0.01, 0.0], vec![0.0, 1e-6]] };
        let effect = Effect {
            shift: "minimum flow shift".to_owned(),
            value: -0.1,
            cost: response(),
            discomfort: response(),
        };
        Model {
            building: "a".to_owned(),
            identified: "06-01..06-14".to_owned(),
            guideline36: REVISION,
            setpoints: [16.0, 20.0],
            deviation: 0.2,
            cost: [vec![0.5; 24], vec![2.0; 24]],
            discomfort: [vec![0.0; 24], vec![1.0; 24]],
            effects: vec![effect],
        }
    }

    #[test]
    fn only_effects_beyond_their_uncertainty_count() {
        let model = model();
        let at = |outdoor, setpoint| {
            let drivers = Drivers::new(outdoor, setpoint, model.setpoints);
            model.predict(12, drivers).next().unwrap()
        };
        assert_eq!(at(0.0, 20.0), [0.0; 2], "-0.1 with a deviation of 0.1");
        assert_eq!(
            at(30.0, 20.0),
            [0.04, 0.02],
            "0.02 with a deviation of 0.001, of twice the mean hour's cost"
        );
        assert_eq!(at(30.0, 16.0), [0.01, 0.0]);
    }

    #[test]
    fn a_model_of_other_shifts_or_sequences_is_refused() {
        let good = model();
        let said = |change: fn(&mut Model)| {
            let mut bad = good.clone();
            change(&mut bad);
            bad.check().unwrap_err()
        };
        assert!(said(|bad| bad.guideline36 += 1).contains("identify it again"));
        assert!(said(|bad| bad.cost[0].truncate(3)).contains("hour of the day"));
        assert!(said(|bad| bad.effects[0].shift = "earlier start".to_owned()).contains("minimum flow shift"));
        assert!(said(|bad| bad.effects[0].cost.mean.truncate(1)).contains("2 terms"));
        assert!(said(|bad| bad.effects[0].cost.mean[0] = f64::NAN).contains("finite"));
    }
}
