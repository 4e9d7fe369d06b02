//! The result of a calibration.

use serde::Serialize;

use super::{Agreement, Fit, Fuel, Metered};
use crate::MonthlyEnergy;
use crate::edit::Change;

/// The inputs of a report.
pub(super) struct Calibrated<'a> {
    pub(super) metered: &'a Metered,
    pub(super) parameters: &'a [Change],
    pub(super) fit: &'a Fit,
    pub(super) before: MonthlyEnergy,
    pub(super) after: MonthlyEnergy,
}

/// A calibration: the multipliers, and the energy before and after.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the model.
    pub model: String,
    /// Name of the place, or of the weather file.
    pub place: String,
    /// The calibrated parameters.
    pub parameters: Vec<Parameter>,
    /// The metered fuels.
    pub fuels: Vec<FuelReport>,
    /// Number of iterations.
    pub iterations: usize,
    /// Number of simulated years.
    pub simulations: usize,
    /// Points to check before the model is used.
    pub warnings: Vec<String>,
}

/// A calibrated parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Parameter {
    /// The change of the model.
    pub name: Change,
    /// Its multiplier.
    pub multiplier: f64,
    /// Whether the multiplier ends at its bound.
    pub at_bound: bool,
}

/// A fuel before and after calibration.
#[derive(Clone, Debug, Serialize)]
pub struct FuelReport {
    /// The fuel.
    pub fuel: Fuel,
    /// The metered months, from 1.
    pub months: Vec<usize>,
    /// Metered energy of each month, kWh.
    pub metered_kwh: Vec<f64>,
    /// Simulated energy before calibration, kWh.
    pub before_kwh: Vec<f64>,
    /// Simulated energy after calibration, kWh.
    pub after_kwh: Vec<f64>,
    /// Agreement before calibration.
    pub before: Agreement,
    /// Agreement after calibration.
    pub after: Agreement,
}

impl Report {
    /// Compares the model before and after with the metered energy.
    pub(super) fn new(model: &str, place: &str, calibrated: Calibrated<'_>) -> Self {
        let Calibrated { metered, parameters, fit, before, after } = calibrated;
        let parameter = |(index, name): (usize, &Change)| Parameter {
            name: *name,
            multiplier: fit.point[index].exp(),
            at_bound: fit.at_bound.contains(&index),
        };
        let fuel = |(fuel, values): &(Fuel, Vec<f64>)| {
            let of = |energy: &MonthlyEnergy| -> Vec<f64> {
                metered.months.iter().map(|month| energy.fuel(*fuel)[month - 1]).collect()
            };
            let (before_kwh, after_kwh) = (of(&before), of(&after));
            FuelReport {
                fuel: *fuel,
                months: metered.months.clone(),
                metered_kwh: values.clone(),
                before: Agreement::of(values, &before_kwh),
                after: Agreement::of(values, &after_kwh),
                before_kwh,
                after_kwh,
            }
        };
        Self {
            model: model.to_owned(),
            place: place.to_owned(),
            parameters: parameters.iter().enumerate().map(parameter).collect(),
            fuels: metered.fuels.iter().map(fuel).collect(),
            iterations: fit.iterations,
            simulations: fit.evaluations,
            warnings: warnings(parameters, fit, metered),
        }
    }
}

/// Months of a year.
const YEAR: usize = 12;

fn warnings(parameters: &[Change], fit: &Fit, metered: &Metered) -> Vec<String> {
    let names = |indices: &[usize]| -> String {
        indices.iter().map(|index| parameters[*index].name()).collect::<Vec<_>>().join(", ")
    };
    let mut warnings = Vec::new();
    if metered.months.len() < YEAR {
        warnings.push(format!(
            "{} metered months: the limits of Guideline 14 are for a year",
            metered.months.len()
        ));
    }
    if metered.len() < 2 * parameters.len() {
        warnings.push(format!(
            "{} metered values for {} parameters: they may agree by chance; calibrate fewer parameters",
            metered.len(),
            parameters.len()
        ));
    }
    if fit.is_cut {
        warnings.push(format!("it still improved at the limit of iterations ({}); raise it", fit.iterations));
    }
    if !fit.collinear.is_empty() {
        warnings.push(format!(
            "{} are nearly collinear: monthly energy hardly tells them apart, and other multipliers may agree as well; \
             calibrate fewer parameters",
            names(&fit.collinear)
        ));
    }
    for index in &fit.at_bound {
        warnings.push(format!(
            "the multiplier of {} ends at its bound, {:.2}: check the model and the metered energy, or calibrate other \
             parameters",
            parameters[*index].name(),
            fit.point[*index].exp()
        ));
    }
    if !fit.without_effect.is_empty() {
        warnings.push(format!(
            "almost without effect on the metered energy, and so not determined: {}",
            names(&fit.without_effect)
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_hold_for_one_parameter_and_for_several() {
        let fit = |without_effect: Vec<usize>| Fit {
            point: vec![0.0, 2.0_f64.ln()],
            evaluations: 1,
            iterations: 1,
            at_bound: vec![1],
            collinear: Vec::new(),
            without_effect,
            is_cut: false,
        };
        let metered =
            |months| Metered { months: (1..=months).collect(), fuels: vec![(Fuel::Gas, vec![1.0; months])] };
        let parameters = [Change::WallU, Change::Lights];
        let said = |without_effect| warnings(&parameters, &fit(without_effect), &metered(12));
        let short = warnings(&parameters, &Fit { is_cut: true, ..fit(vec![]) }, &metered(3));
        assert!(short[0].starts_with("3 metered months") && short[1].starts_with("3 metered values for 2"));
        assert!(short[2].starts_with("it still improved at the limit of iterations (1)"), "{short:?}");
        assert!(said(vec![])[0].starts_with("the multiplier of lights ends at its bound, 2.00"));
        let several = "almost without effect on the metered energy, and so not determined: wall_u, lights";
        assert_eq!(said(vec![0, 1])[1], several);
        assert_eq!(said(vec![0])[1], several.replace(", lights", ""));
    }
}
