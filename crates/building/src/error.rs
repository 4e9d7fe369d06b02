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
