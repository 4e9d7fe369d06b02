//! A row of an EPW file: the weather of an hour or of a part of it.

use super::column;

/// Columns that the engine needs, up to the indicator of observed weather. It treats missing values of later columns as
/// unknown.
const NEEDED: usize = 27;
/// The column of source and uncertainty flags, the only text among them.
const FLAGS: usize = 5;
/// The columns of global horizontal, direct normal and diffuse horizontal radiation, W/m². Negative values and values of
/// 9999 or more are missing.
const RADIATION: [usize; 3] = [column::GLOBAL, column::BEAM, column::DIFFUSE];
pub(super) const RADIATIONS: std::ops::Range<f64> = 0.0..9999.0;
/// The columns of the air, whose values must be plausible.
pub(super) const COLUMNS: [Column; 4] = [
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
];

/// A column with plausible limits, which are beyond the records on Earth, and the code of a missing value.
pub(super) struct Column {
    pub index: usize,
    quantity: &'static str,
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
    /// Dry bulb (°C), dew point (°C), relative humidity (%) and wind speed (m/s); `None` if missing.
    pub air: [Option<f64>; 4],
    /// Global horizontal, direct normal and diffuse horizontal, W/m²; `None` if missing.
    pub radiation: [Option<f64>; 3],
}

impl Row {
    /// Reads a row.
    ///
    /// # Errors
    /// The reason, if a column that the engine needs is missing, not a finite number or not plausible.
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
        let radiation =
            RADIATION.map(|column| Some(values[column]).filter(|value| RADIATIONS.contains(value)));
        Ok(Self { year, month, day, hour, columns, air, radiation })
    }
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
    Ok(known)
}
