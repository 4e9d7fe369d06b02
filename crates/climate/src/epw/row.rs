//! A row of an EPW file: the weather of an hour or of a part of it.

use super::column;

/// Columns that the engine needs, up to the indicator of observed weather. It treats missing values of later columns as
/// unknown.
const NEEDED: usize = 27;
/// The column of source and uncertainty flags, the only text among them.
const FLAGS: usize = 5;
/// The columns of radiation, W/m². Negative values and values of 9999 or more are missing.
pub(super) const RADIATION: [(usize, &str); 3] = [
    (column::GLOBAL, "global horizontal radiation"),
    (column::BEAM, "direct normal radiation"),
    (column::DIFFUSE, "diffuse horizontal radiation"),
];
pub(super) const RADIATIONS: std::ops::Range<f64> = 0.0..9999.0;
/// Highest plausible radiation, W/m²: above the sun with reflections of clouds, below the same in kJ/m² an hour.
const HIGHEST_RADIATION: f64 = 2000.0;
/// The largest difference of a dew point above its dry bulb, K: of rounding, instruments and freezing fog.
const SUPERSATURATION: f64 = 5.0;
/// The columns of the air, whose values must be plausible.
pub(super) const COLUMNS: [Column; 5] = [
    Column {
        index: column::DRY_BULB,
        quantity: "dry-bulb temperature (°C)",
        limits: [-90.0, 60.0],
        missing: 99.9,
    },
    Column { index: column::DEW_POINT, quantity: "dew point (°C)", limits: [-100.0, 60.0], missing: 99.9 },
    Column {
        index: column::HUMIDITY,
        quantity: "relative humidity (%)",
        limits: [0.0, 110.0],
        missing: 999.0,
    },
    Column { index: column::WIND, quantity: "wind speed (m/s)", limits: [0.0, 115.0], missing: 999.0 },
    Column {
        index: column::PRESSURE,
        quantity: "pressure (Pa)",
        limits: [31_000.0, 120_000.0],
        missing: 999_999.0,
    },
];

/// A column with plausible limits, which are beyond the records on Earth, and the code of a missing value.
pub(super) struct Column {
    pub index: usize,
    pub quantity: &'static str,
    pub limits: [f64; 2],
    missing: f64,
}

/// A row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub year: u32,
    pub month: u32,
    pub day: u32,
    /// Hour that it falls in or ends, 1 to 24.
    pub hour: u32,
    /// Number of columns.
    pub columns: usize,
    /// Values of [`COLUMNS`]; `None` if missing.
    pub air: [Option<f64>; COLUMNS.len()],
    /// Values of [`RADIATION`]; `None` if missing.
    pub radiation: [Option<f64>; RADIATION.len()],
}

impl Row {
    /// Reads a row.
    ///
    /// # Errors
    /// The reason, if a column that the engine needs is absent, not a finite number or not plausible.
    pub fn read(line: &str) -> Result<Self, String> {
        let mut values = [0.0; NEEDED];
        let mut columns = 0;
        for (index, text) in line.split(',').enumerate() {
            columns += 1;
            if index < NEEDED && index != FLAGS {
                let number = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
                values[index] =
                    number.ok_or_else(|| format!("column {} is `{text}`, not a finite number", index + 1))?;
            }
        }
        if columns < NEEDED {
            return Err(format!("{columns} columns instead of at least {NEEDED}"));
        }
        let air = known(&values)?;
        let [year, month, day, hour] = [0, 1, 2, 3].map(|column| values[column].round() as u32);
        let radiation = radiation(&values)?;
        Ok(Self { year, month, day, hour, columns, air, radiation })
    }
}

/// Returns the values of [`RADIATION`], `None` for missing ones.
fn radiation(values: &[f64; NEEDED]) -> Result<[Option<f64>; RADIATION.len()], String> {
    let mut known = [None; RADIATION.len()];
    for (known, (index, quantity)) in known.iter_mut().zip(RADIATION) {
        *known = Some(values[index]).filter(|value| RADIATIONS.contains(value));
        if let Some(value) = known.filter(|value| *value > HIGHEST_RADIATION) {
            return Err(format!(
                "the {quantity} is {value} W/m²; expected 0 to {HIGHEST_RADIATION}, or 9999 if it is missing"
            ));
        }
    }
    Ok(known)
}

/// Returns the values of [`COLUMNS`], `None` for the code of a missing value.
fn known(values: &[f64; NEEDED]) -> Result<[Option<f64>; COLUMNS.len()], String> {
    let mut known = [None; COLUMNS.len()];
    for (known, Column { index, quantity, limits: [low, high], missing }) in known.iter_mut().zip(COLUMNS) {
        let value = values[index];
        if value == missing {
            continue;
        }
        if !(low..=high).contains(&value) {
            return Err(format!(
                "the {quantity} is {value}; expected {low} to {high}, or {missing} if it is missing"
            ));
        }
        *known = Some(value);
    }
    if let [Some(dry_bulb), Some(dew_point), ..] = known
        && dew_point > dry_bulb + SUPERSATURATION
    {
        return Err(format!("the dew point is {dew_point} °C, above the dry bulb of {dry_bulb} °C"));
    }
    Ok(known)
}
