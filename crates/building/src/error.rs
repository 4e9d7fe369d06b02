//! What can go wrong with a building model.

use std::path::PathBuf;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that is not what its name says.
    #[error("{path}: {why}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        why: String,
    },
    /// An object that the model refers to, or that an edit needs, is not there.
    #[error("the model has no {class} named `{name}`")]
    MissingObject {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
    },
    /// The model has HVAC that cannot be made controllable.
    #[error("{class} `{name}` cannot be made controllable: {why}")]
    Unsupported {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
        /// Why, and what would do.
        why: String,
    },
    /// A name that is no building type.
    #[error(
        "there is no building type `{text}`{}; the types are {known}",
        near.map(|near| format!(": did you mean {near}?")).unwrap_or_default()
    )]
    UnknownType {
        /// The name.
        text: String,
        /// The type it resembles.
        near: Option<&'static str>,
        /// Every type.
        known: String,
    },
    /// Text that is no id of a building of the dataset.
    #[error("`{text}` is no building of the dataset: give a type and a number, for example OfficeSmall-0042")]
    BuildingId {
        /// The text.
        text: String,
    },
    /// A number that no building of the dataset has.
    #[error(
        "there is no {building_type} number `{number}`: the dataset has {building_type}-0001 to \
         {building_type}-{}",
        crate::dataset::BUILDINGS_PER_TYPE
    )]
    BuildingNumber {
        /// The type.
        building_type: crate::BuildingType,
        /// The number, as it was given.
        number: String,
    },
    /// The engine has no stock models beside it.
    #[error(
        "this EnergyPlus has no {file} beside it: unset B2B_ENERGYPLUS so that the packaged engine is used"
    )]
    NoStockModels {
        /// The file looked for.
        file: String,
    },
    /// Text that is no day of the year.
    #[error("`{text}` is no date of the year: give MM-DD, for example 02-28 (there is no 29 February)")]
    Date {
        /// The text.
        text: String,
    },
    /// Text that is no run period.
    #[error(
        "`{text}` is no run period: give winter, summer, full_year or MM-DD..MM-DD, \
         first day before last"
    )]
    RunPeriod {
        /// The text.
        text: String,
    },
    /// A parameter of a generated building that is out of its bounds.
    #[error("`{name}` is {value}, and must be a number from {low} to {high}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
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
        building_type: crate::BuildingType,
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
        building_type: crate::BuildingType,
    },
    /// A place that no known weather file is of.
    #[error(
        "there is no weather for `{name}`{}; the places are {}, or give the path of an EPW file",
        near.map(|near| format!(": did you mean {near}?")).unwrap_or_default(),
        known.join(", ")
    )]
    UnknownPlace {
        /// What was asked for.
        name: String,
        /// The known place it resembles.
        near: Option<&'static str>,
        /// Every known place.
        known: Vec<&'static str>,
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
    /// The engine or a weather package could not be had.
    #[error(transparent)]
    Install(#[from] b2b_energyplus::install::Error),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A user's model that the engine would take for another building than its author meant.
    #[error("{path} cannot be imported:{}", problems.iter().map(|p| format!("\n  {p}")).collect::<String>())]
    Import {
        /// The file.
        path: PathBuf,
        /// What has to be put right.
        problems: Vec<String>,
    },
    /// A model without any HVAC system that can be driven.
    #[error(
        "{name} has nothing to drive: {}",
        if left.is_empty() { "no air loop, unit heater or baseboard".to_owned() } else { reasons(left) }
    )]
    NothingToDrive {
        /// Name of the building.
        name: String,
        /// What it has, and why that cannot be driven.
        left: Vec<crate::hvac::LeftAlone>,
    },
    /// The engine refused a model or stopped.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
    /// The engine's table of sizes could not be read.
    #[error("the sizes in {path} cannot be read: {source}")]
    SizeTable {
        /// The engine's SQLite output.
        path: PathBuf,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// Fields that the model leaves to the engine to size and for which the engine gave no size.
    #[error("the engine gives no size for:\n  {}\nGive each a number in the model.", fields.join("\n  "))]
    Unsized {
        /// Each field as class, object and field.
        fields: Vec<String>,
    },
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why systems cannot be driven, one line for all of a class with the same reason.
fn reasons(left: &[crate::hvac::LeftAlone]) -> String {
    let mut lines: Vec<(String, usize, &str)> = Vec::new();
    for item in left {
        match lines.iter_mut().find(|(class, _, why)| *class == item.what.class && *why == item.why) {
            Some((_, count, _)) => *count += 1,
            None => lines.push((item.what.class.clone(), 1, &item.why)),
        }
    }
    let line = |(class, count, why): &(String, usize, &str)| format!("\n  {count} × {class}: {why}");
    lines.iter().map(line).collect()
}
