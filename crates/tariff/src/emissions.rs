//! Emission profiles: kg of CO₂ equivalent per kWh by carrier, season and hour.

use std::path::Path;

use b2b_base::carrier::Carrier;
use serde::Deserialize;

use crate::calendar::{COMMON, Moment};
use crate::error::{Fault, Result, read};
use crate::file::Source;
use crate::fuel::{FuelValues, Fuels};

/// Limit of an hour's electricity, kg/MWh: a power plant that burns lignite emits about 1200.
const MOST: f64 = 3000.0;
/// Limit of fuels, kg/kWh: coal has 0.32. Beyond it, a value is per MWh.
const MOST_OF_FUELS: f64 = 2.0;

/// An emission profile.
#[derive(Clone, Debug)]
pub struct Emissions {
    /// Name of a shipped profile, such as `frcc-average`, or of the file without its extension.
    pub name: String,
    /// Title.
    pub title: String,
    /// Where it applies.
    pub place: String,
    /// Average or marginal.
    pub rate: Rate,
    /// Where the figures come from.
    pub source: Source,
    /// kg/kWh of electricity by season and hour.
    electricity: [[f64; 24]; 4],
    fuels: FuelValues,
}

/// Kind of emission rate of electricity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rate {
    /// The average over the grid's generation, to account for energy used.
    Average,
    /// The effect of a lasting change of the load, including new plants, for comparing controllers.
    LongRunMarginal,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EmissionsFile {
    title: String,
    place: String,
    rate: Rate,
    source: Source,
    electricity: toml::Spanned<IntensityFile>,
    fuels: Option<toml::Spanned<Fuels>>,
}

/// kg/MWh, one value or by season and hour.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct IntensityFile {
    flat: Option<f64>,
    winter: Option<[f64; 24]>,
    spring: Option<[f64; 24]>,
    summer: Option<[f64; 24]>,
    autumn: Option<[f64; 24]>,
}

impl Emissions {
    /// Reads an emission profile from a TOML file.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::File`](crate::Error::File) with the line, if the file is not a
    /// profile.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Self::parse(&name, &path.display().to_string(), &read(path)?)
    }

    /// Returns the emission profile of a TOML text. Errors name it `file`.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) with the line.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self> {
        Self::of_text(name, text).map_err(|fault| fault.of(file, text))
    }

    fn of_text(name: &str, text: &str) -> Result<Self, Fault> {
        let file: EmissionsFile = toml::from_str(text)?;
        let place = file.electricity.span().start;
        let electricity = file.electricity.get_ref().kg_per_kwh().map_err(|why| Fault::at(place, why))?;
        Ok(Self {
            name: name.to_owned(),
            title: file.title,
            place: file.place,
            rate: file.rate,
            source: file.source,
            electricity,
            fuels: FuelValues::EMISSIONS.with(file.fuels.as_ref(), Some(MOST_OF_FUELS))?,
        })
    }

    /// Returns kg of CO₂ equivalent per kWh of a carrier at a moment of a year without 29 February. Hours are of
    /// standard time; seasons begin in December, March, June and September.
    pub fn at(&self, fuel: Carrier, at: Moment) -> f64 {
        let season = (COMMON.month_of(at.day) + 1) % 12 / 3;
        self.fuels.at(fuel, self.electricity[season][at.hour as usize % 24])
    }
}

impl IntensityFile {
    fn kg_per_kwh(&self) -> Result<[[f64; 24]; 4], String> {
        let per_mwh = match (self.flat, self.winter, self.spring, self.summer, self.autumn) {
            (Some(flat), None, None, None, None) => [[flat; 24]; 4],
            (None, Some(winter), Some(spring), Some(summer), Some(autumn)) => [winter, spring, summer, autumn],
            _ => return Err("[electricity] needs either `flat` or all of `winter`, `spring`, `summer` and `autumn`, in kg/MWh".into()),
        };
        if let Some(value) = per_mwh.iter().flatten().find(|value| !(0.0..=MOST).contains(*value)) {
            return Err(format!("[electricity] has {value} kg/MWh; expected numbers of 0 to {MOST}"));
        }
        Ok(per_mwh.map(|season| season.map(|value| value / 1000.0)))
    }
}
