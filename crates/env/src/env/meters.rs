//! The engine's own HVAC meters over the run period, to compare with the sums of the steps.

use std::path::Path;

use b2b_building::Model;

use crate::{Error, Result};

/// The meters that make up HVAC energy, electricity and gas; a building need not have both.
pub(super) const METERS: [&str; 2] = ["Electricity:HVAC", "NaturalGas:HVAC"];
/// The file that the engine writes them to.
pub(super) const METER_FILE: &str = "eplusout.mtr";
pub(super) const JOULES_PER_WATT_HOUR: f64 = 3600.0;

/// Makes the engine write the HVAC meters of the run period to [`METER_FILE`].
pub(super) fn request(model: &mut Model) {
    for meter in METERS {
        let fields = serde_json::json!({"key_name": meter, "reporting_frequency": "RunPeriod"});
        model.insert("Output:Meter:MeterFileOnly", meter, fields);
    }
    for name in model.names("OutputControl:Files") {
        if let Some(files) = model.get_mut("OutputControl:Files", &name) {
            files.insert("output_mtr".into(), "Yes".into());
        }
    }
}

/// Reads the meters of a finished run, Wh/m²: electricity and gas.
pub(super) fn read(path: &Path, floor_area: f64) -> Result<[f64; 2]> {
    let text = std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    Ok(METERS.map(|meter| run_period_value(&text, meter).unwrap_or(0.0) / JOULES_PER_WATT_HOUR / floor_area))
}

/// A run-period value from the text of a meter file: `12,1,Electricity:HVAC [J] !RunPeriod …` gives the number
/// of the line with the value, `12,123.4,…`.
fn run_period_value(text: &str, meter: &str) -> Option<f64> {
    let named = format!(",{meter} [J] !RunPeriod");
    let number = text.lines().find(|line| line.contains(&named))?.split(',').next()?;
    let value = text.lines().skip_while(|line| !line.starts_with("End of Data Dictionary"));
    let mut fields = value.map(|line| line.split(',')).find(|f| f.clone().next() == Some(number))?;
    fields.nth(1)?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_meter_is_read_by_the_number_that_the_dictionary_gives_it() {
        let text = "Program Version,EnergyPlus\n12,1,Electricity:HVAC [J] !RunPeriod [Value]\n\
                    End of Data Dictionary\n5,1.0\n12,7200.0,1.0\nEnd of Data\n";
        assert_eq!(run_period_value(text, "Electricity:HVAC"), Some(7200.0));
        assert_eq!(run_period_value(text, "NaturalGas:HVAC"), None);
    }
}
