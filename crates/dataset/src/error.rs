//! Errors of generated buildings and of the catalog.

use std::path::PathBuf;

use b2b_base::suggestion::{did_you_mean, nearest};
use b2b_building::BuildingType;
use b2b_building::parameter::OutOfBounds;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Text that is not a valid building id.
    #[error("unknown building id `{text}`; expected a type and a number, for example OfficeSmall-0042")]
    BuildingId {
        /// The text.
        text: String,
    },
    /// Text that is not the interface of a building.
    #[error("unknown control `{text}`{}; expected actuators or setpoints", near_control(text))]
    Control {
        /// The text.
        text: String,
    },
    /// The text is neither the name of a building nor a model file.
    #[error("{why}; the name of a model file ends in .idf or .epJSON")]
    NoBuilding {
        /// Why it is not the name of a building.
        why: String,
    },
    /// A building number outside the dataset.
    #[error(
        "unknown building id `{building_type}-{number}`; ids run from {building_type}-0001 to {building_type}-{last}"
    )]
    BuildingNumber {
        /// The type.
        building_type: BuildingType,
        /// The number, as given.
        number: String,
        /// The highest number of the type.
        last: u32,
    },
    /// An engine without its example models.
    #[error("this EnergyPlus installation has no {file}; unset B2B_ENERGYPLUS to use the packaged engine")]
    NoStockModels {
        /// The missing file.
        file: String,
    },
    /// A parameter of a generated building out of bounds.
    #[error(transparent)]
    Parameter(#[from] OutOfBounds),
    /// An invalid value of a parameter.
    #[error("parameter `{name}` is `{text}`; {remedy}")]
    Setting {
        /// The parameter.
        name: String,
        /// The value, as given.
        text: String,
        /// What is expected.
        remedy: String,
    },
    /// An unknown parameter of a building type.
    #[error(
        "unknown parameter `{name}` of {building_type}{}; expected one of {known}",
        did_you_mean(near.unwrap_or_default())
    )]
    UnknownParameter {
        /// The name.
        name: String,
        /// The type.
        building_type: BuildingType,
        /// The most similar parameter.
        near: Option<&'static str>,
        /// Every parameter.
        known: String,
    },
    /// A parameter out of the bounds set by the climate of a place.
    #[error("{source} in {place} (climate zone {zone}); narrow the range or choose other places")]
    AtPlace {
        /// The place.
        place: String,
        /// Its climate zone.
        zone: String,
        /// The error.
        source: Box<Error>,
    },
    /// A climate zone without prescriptive requirements.
    #[error(
        "no envelope of the code for climate zone `{zone}`; expected 1 to 6 with the letter of the moisture regime, for \
         example 5B, or 7 or 8; a weather file may take the nearest one"
    )]
    ClimateZone {
        /// The text.
        zone: String,
    },
    /// A building type that is not commercial.
    #[error("{building_type} is not a commercial building type")]
    NotCommercial {
        /// The type.
        building_type: BuildingType,
    },
    /// Another place for a building of the dataset.
    #[error(
        "{building} is located in {place}; use --weather FILE.epw for other weather, or a building type for another place"
    )]
    HasPlace {
        /// The building.
        building: String,
        /// Its place.
        place: String,
    },
    /// Design days of the model are to be kept, but the building is generated for its weather.
    #[error("`{name}` has the design days of its weather; --keep-design-days is for model files, remove it")]
    HasDesignDays {
        /// The building.
        name: String,
    },
    /// A user's model without a weather file.
    #[error("{path} needs weather: use --weather FILE.epw or --place NAME (see `b2b list places`)")]
    NoWeather {
        /// The model.
        path: PathBuf,
    },
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
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
        match error {
            b2b_building::Error::Parameter(error) => Self::Parameter(error),
            error => Self::Building(Box::new(error)),
        }
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Returns the most similar interface, as a question; empty if none is similar.
fn near_control(text: &str) -> String {
    did_you_mean(&nearest(text, ["actuators", "setpoints"]))
}
