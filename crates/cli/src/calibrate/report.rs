//! The result of a calibration.

use std::path::Path;

use b2b_building::MonthlyEnergy;
use b2b_building::calibration::{Agreement, Fit, Fuel, Metered};
use b2b_building::edit::Change;
use b2b_dataset::BuildingName;
use serde::Serialize;

use crate::table::Table;

/// Everything that a report is made of.
pub struct Calibrated<'a> {
    pub metered: &'a Metered,
    pub parameters: &'a [Change],
    pub fit: &'a Fit,
    pub before: MonthlyEnergy,
    pub after: MonthlyEnergy,
}

/// What `--json` prints.
#[derive(Serialize)]
pub struct Report {
    model: String,
    place: String,
    parameters: Vec<Parameter>,
    fuels: Vec<FuelReport>,
    iterations: usize,
    pub simulations: usize,
    pub warnings: Vec<String>,
}

/// A calibrated parameter.
#[derive(Serialize)]
struct Parameter {
    name: Change,
    multiplier: f64,
    at_bound: bool,
}

/// A fuel before and after calibration.
#[derive(Serialize)]
struct FuelReport {
    fuel: Fuel,
    months: Vec<usize>,
    metered_kwh: Vec<f64>,
    before_kwh: Vec<f64>,
    after_kwh: Vec<f64>,
    before: Agreement,
    after: Agreement,
}

impl Report {
    /// Compares the model before and after with the metered energy.
    pub fn new(model: &BuildingName, place: &str, calibrated: Calibrated<'_>) -> Self {
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
            model: model.to_string(),
            place: place.to_owned(),
            parameters: parameters.iter().enumerate().map(parameter).collect(),
            fuels: metered.fuels.iter().map(fuel).collect(),
            iterations: fit.iterations,
            simulations: fit.evaluations,
            warnings: warnings(parameters, fit),
        }
    }

    /// Returns the report as text.
    pub fn text(&self, out: &Path) -> String {
        let mut parameters = Table::new(["parameter", "multiplier"]);
        for parameter in &self.parameters {
            parameters.row([parameter.name.to_string(), format!("{:.3}", parameter.multiplier)]);
        }
        let mut fuels =
            Table::new(["fuel", "model", "CV(RMSE) (%)", "NMBE (%)", "Guideline 14 (15 %, ±5 %)"]);
        for each in &self.fuels {
            for (model, agreement) in [("before", each.before), ("calibrated", each.after)] {
                fuels.row([
                    each.fuel.to_string(),
                    model.into(),
                    percent(agreement.cv_rmse_percent),
                    percent(agreement.nmbe_percent),
                    if agreement.meets_guideline_14 { "met" } else { "not met" }.into(),
                ]);
            }
        }
        format!(
            "{}\n\n{}\n\n{} simulations; {} written",
            parameters.text(),
            fuels.text(),
            self.simulations,
            out.display()
        )
    }
}

/// Returns a number with one decimal; never `-0.0`.
fn percent(value: f64) -> String {
    format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0)
}

fn warnings(parameters: &[Change], fit: &Fit) -> Vec<String> {
    let names = |indices: &[usize]| -> String {
        indices.iter().map(|index| parameters[*index].name()).collect::<Vec<_>>().join(", ")
    };
    let mut warnings = Vec::new();
    if !fit.collinear.is_empty() {
        warnings.push(format!(
            "{} are nearly collinear: monthly energy hardly tells them apart, and other multipliers may agree as well; \
             calibrate fewer parameters",
            names(&fit.collinear)
        ));
    }
    for index in &fit.at_bound {
        warnings.push(format!(
            "{} ends at its bound, a multiplier of {:.2}: check the model and the metered energy, or calibrate other \
             parameters",
            parameters[*index].name(),
            fit.point[*index].exp()
        ));
    }
    if !fit.without_effect.is_empty() {
        warnings.push(format!(
            "{} has almost no effect on the metered energy and is not determined",
            names(&fit.without_effect)
        ));
    }
    warnings
}
