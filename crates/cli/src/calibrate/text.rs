//! The text of a calibration.

use std::path::Path;

use b2b_building::calibration::Report;

use crate::terminal::table::Table;

/// Returns a report as text.
pub fn text(report: &Report, out: &Path) -> String {
    let mut parameters = Table::new(["parameter", "multiplier"]);
    for parameter in &report.parameters {
        parameters.row([parameter.name.to_string(), format!("{:.3}", parameter.multiplier)]);
    }
    let mut fuels = Table::new(["fuel", "model", "CV(RMSE) (%)", "NMBE (%)", "Guideline 14 (15 %, ±5 %)"]);
    for each in &report.fuels {
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
        report.simulations,
        out.display()
    )
}

/// Returns a number with one decimal; never `-0.0`.
fn percent(value: f64) -> String {
    format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0)
}
