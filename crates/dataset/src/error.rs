//! Errors of generated buildings and of the catalog.

use std::path::PathBuf;

use b2b_building::BuildingType;
use b2b_building::parameter::OutOfBounds;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Text that is no id of a building of the dataset.
    #[error("`{text}` is no building of the dataset: give a type and a number, for example OfficeSmall-0042")]
    BuildingId {
        /// The text.
        text: String,
    },
    /// A number that no building of the dataset has.
    #[error(
        "unknown building id `{building_type}-{number}`; ids of the type run from {building_type}-0001 to \
         {building_type}-{last}"
    )]
    BuildingNumber {
        /// The type.
        building_type: BuildingType,
        /// The number, as it was given.
        number: String,
        /// The highest number of the type.
        last: u32,
    },
    /// The engine has no stock models beside it.
    #[error(
        "this EnergyPlus has no {file} beside it: unset B2B_ENERGYPLUS so that the packaged engine is used"
    )]
    NoStockModels {
        /// The file looked for.
        file: String,
    },
    /// A parameter of a generated building that is not within its bounds.
    #[error(transparent)]
    Parameter(#[from] OutOfBounds),
    /// What was asked of a parameter cannot be.
    #[error("`{name}` is `{text}`: {remedy}")]
    Setting {
        /// The parameter.
        name: String,
        /// What was asked.
        text: String,
        /// What would do.
        remedy: String,
    },
    /// A name that is no parameter of a type.
    #[error(
        "{building_type} has no parameter `{name}`{}; its parameters are {known}",
        near.map(|near| format!(": did you mean {near}?")).unwrap_or_default()
    )]
    UnknownParameter {
        /// The name.
        name: String,
        /// The type.
        building_type: BuildingType,
        /// The parameter it resembles.
        near: Option<&'static str>,
        /// Every parameter.
        known: String,
    },
    /// A parameter that cannot be at a place, whose climate bounds it.
    #[error("{source} in {place} (climate zone {zone}): narrow it, or choose other places")]
    AtPlace {
        /// The place.
        place: String,
        /// Its climate zone.
        zone: String,
        /// What is wrong.
        source: Box<Error>,
    },
    /// Text that is no climate zone of ASHRAE 169 with a row in the code's tables.
    #[error("there is no climate zone `{zone}`: give 1 to 8 with the letter of its humidity, for example 5B")]
    ClimateZone {
        /// The text.
        zone: String,
    },
    /// A building type that the commercial generator does not make.
    #[error("{building_type} is no commercial building: it has a generator of its own")]
    NotCommercial {
        /// The type.
        building_type: BuildingType,
    },
    /// A building of the dataset under the weather of another place.
    #[error(
        "{building} stands in {place}: give a weather file (--weather FILE.epw) to put it under other weather, or a type for another place"
    )]
    HasPlace {
        /// The building.
        building: String,
        /// Its place.
        place: String,
    },
    /// A user's model without weather.
    #[error(
        "{path} has no weather: give a weather file (--weather FILE.epw), or a place (--place NAME; `b2b list places`)"
    )]
    NoWeather {
        /// The model.
        path: PathBuf,
    },
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A model cannot be read, edited or made controllable.
    #[error(transparent)]
    Building(Box<b2b_building::Error>),
    /// A place or its weather file cannot be used.
    #[error(transparent)]
    Climate(#[from] b2b_climate::Error),
    /// The engine could not be installed.
    #[error(transparent)]
    Install(#[from] b2b_energyplus::install::Error),
    /// The engine could not be loaded.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
}

impl From<b2b_building::Error> for Error {
    fn from(error: b2b_building::Error) -> Self {
        Self::Building(Box::new(error))
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
