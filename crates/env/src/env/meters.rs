//! The engine's own HVAC meters over the run period, to compare with the sums of the steps.

use std::path::Path;

use b2b_building::{Carrier, CarrierEnergy, HvacMeter, Model, PreparedBuilding};

use crate::task::Task;
use crate::{Error, Result};

/// The file to which the engine writes them.
pub(super) const METER_FILE: &str = "eplusout.mtr";
const JOULES_PER_WATT_HOUR: f64 = 3600.0;

/// Returns the meters whose run-period values add up to the energy of a task. An operation task uses the end-use
/// meters, unless the building has fans outside the HVAC: those meters include such fans, HVAC energy does not.
pub(super) fn compared(building: &PreparedBuilding, task: &Task) -> Vec<HvacMeter> {
    if !task.is_operation() || building.fans_outside().next().is_some() {
        return building.meters.clone();
    }
    let end_uses = |meter: &HvacMeter| {
        let carrier = meter.carrier;
        meter.end_uses().into_iter().map(move |(_, name)| HvacMeter { carrier, name })
    };
    building.meters.iter().flat_map(end_uses).collect()
}

/// Makes the engine write the HVAC meters of the run period to [`METER_FILE`].
pub(super) fn request(model: &mut Model, meters: &[HvacMeter]) {
    for HvacMeter { name, .. } in meters {
        let fields = serde_json::json!({"key_name": name, "reporting_frequency": "RunPeriod"});
        model.insert("Output:Meter:MeterFileOnly", name, fields);
    }
    for name in model.names("OutputControl:Files") {
        if let Some(files) = model.get_mut("OutputControl:Files", &name) {
            files.insert("output_mtr".into(), "Yes".into());
        }
    }
}

/// Reads the meters of a finished run, Wh/m²: electricity and fuels.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read or is not complete.
pub(super) fn read(path: &Path, meters: &[HvacMeter], floor_area: f64) -> Result<[f64; 2]> {
    let io = |source| Error::Io { path: path.to_owned(), source };
    let text = std::fs::read_to_string(path).map_err(io)?;
    if !is_complete(&text) {
        return Err(io(std::io::Error::other("the engine writes its meters at the end of the run period")));
    }
    let values =
        meters.iter().map(|meter| (meter.carrier, run_period_value(&text, &meter.name).unwrap_or(0.0)));
    Ok(electricity_and_fuels(&by_carrier(values, floor_area)))
}

/// Sums meter readings (J) by carrier, Wh/m². A building may lack some meters.
pub(super) fn by_carrier(readings: impl Iterator<Item = (Carrier, f64)>, floor_area: f64) -> CarrierEnergy {
    let mut energy = CarrierEnergy::default();
    for (carrier, joules) in readings {
        energy[carrier as usize] += per_area(joules, floor_area);
    }
    energy
}

/// Returns the reading of a meter (J) per floor area, Wh/m².
pub(super) fn per_area(joules: f64, floor_area: f64) -> f64 {
    joules / JOULES_PER_WATT_HOUR / floor_area
}

/// Electricity, and the sum of all other carriers.
pub(super) fn electricity_and_fuels(energy: &CarrierEnergy) -> [f64; 2] {
    [energy[0], energy[1..].iter().sum()]
}

/// Returns whether a meter file is complete.
fn is_complete(text: &str) -> bool {
    text.lines().any(|line| line.trim_end() == "End of Data")
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
    fn a_meter_is_read_by_its_number_in_the_dictionary() {
        let text = "Program Version,EnergyPlus\n12,1,Electricity:HVAC [J] !RunPeriod [Value]\n\
                    End of Data Dictionary\n5,1.0\n12,7200.0,1.0\nEnd of Data\n";
        assert_eq!(run_period_value(text, "Electricity:HVAC"), Some(7200.0));
        assert_eq!(run_period_value(text, "NaturalGas:HVAC"), None);
    }

    #[test]
    fn the_meters_of_an_unfinished_run_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(METER_FILE);
        let meter = HvacMeter { name: "Electricity:HVAC".into(), carrier: Carrier::Electricity };
        let begun = "12,1,Electricity:HVAC [J] !RunPeriod [Value]\nEnd of Data Dictionary\n";
        std::fs::write(&path, begun).unwrap();
        let error = read(&path, std::slice::from_ref(&meter), 1.0).unwrap_err().to_string();
        assert!(error.contains("end of the run period"), "{error}");
        std::fs::write(&path, format!("{begun}12,7200.0\nEnd of Data\n Number of Records Written=1\n"))
            .unwrap();
        assert_eq!(read(&path, &[meter], 1.0).unwrap(), [2.0, 0.0]);
    }
}
