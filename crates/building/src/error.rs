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
    /// A model without any HVAC system that can be made controllable.
    #[error("{name} has no controllable system: {}", lines(reasons))]
    NothingToControl {
        /// Name of the building.
        name: String,
        /// Its systems that are not controlled, and why; one line for all of a class with the same reason.
        reasons: Vec<String>,
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
    /// A place or its weather file cannot be used.
    #[error(transparent)]
    Climate(#[from] b2b_climate::Error),
}

impl Error {
    /// An [`Error::Unsupported`] for an object.
    pub fn unsupported(class: &str, name: &str, why: &str) -> Self {
        Self::Unsupported { class: class.to_owned(), name: name.to_owned(), why: why.to_owned() }
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// The reasons, one a line.
fn lines(reasons: &[String]) -> String {
    if reasons.is_empty() {
        return "it has no air loop, unit heater or baseboard".to_owned();
    }
    reasons.iter().map(|reason| format!("\n  {reason}")).collect()
}
